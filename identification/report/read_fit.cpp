#include "samara/identification/report/read_fit.h"

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/base/errors.h"
#include "samara/base/termination.h"
#include "samara/identification/report/fit_setup.h"
#include "samara/io/text_file.h"

namespace samara::identification {

namespace {

using ParsedJson = nlohmann::json;

/// Files written before fits ended with the words of all other work say "not determined" and "iteration limit".
Termination status_of(const std::string& text) {
  if (text == "not determined") return Termination::not_determined;
  if (text == "iteration limit") return Termination::max_iterations;
  for (const Termination status :
       {Termination::converged, Termination::not_determined, Termination::max_iterations}) {
    if (to_string(status) == text) return status;
  }
  return Termination::failed;
}

std::optional<double> number_of(const ParsedJson& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return {};
  return found->get<double>();
}

double number_or_nan(const ParsedJson& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

/// Row by row; empty where there is none.
Eigen::MatrixXd matrix_of(const ParsedJson& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  const auto rows = static_cast<Eigen::Index>(found->size());
  Eigen::MatrixXd matrix(rows, rows);
  for (Eigen::Index row = 0; row < rows; ++row) {
    for (Eigen::Index column = 0; column < rows; ++column)
      matrix(row, column) =
          number_or_nan(found->at(static_cast<std::size_t>(row)).at(static_cast<std::size_t>(column)));
  }
  return matrix;
}

CaptureFit capture_of(const ParsedJson& object) {
  const auto id = object.at("id").get<std::string>();
  CaptureFit capture{.id = id,
                     .file = object.at("file").get<std::string>(),
                     .checksum = object.value("checksum", ""),
                     .whole = object.value("whole", id)};
  capture.start = number_of(object, "start").value_or(0.0);
  if (object.contains("known")) capture.known = object.at("known").get<std::map<std::string, double>>();
  if (object.contains("nuisances")) {
    for (const ParsedJson& n : object.at("nuisances")) {
      capture.nuisances.push_back({.name = n.at("name").get<std::string>(),
                                   .unit = n.at("unit").get<std::string>(),
                                   .value = number_or_nan(n.at("value"))});
    }
  }
  if (object.contains("times")) {
    const auto times = object.at("times").get<std::vector<double>>();
    capture.times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  }
  return capture;
}

/// The judgement without its series.
std::optional<Whiteness> whiteness_of(const ParsedJson& object) {
  const auto found = object.find("whiteness");
  if (found == object.end() || found->is_null()) return {};
  return Whiteness{.tested = found->at("tested").get<int>(),
                   .rejected = found->at("rejected").get<int>(),
                   .p_value = number_of(*found, "p_value")};
}

Coefficient coefficient_of(const ParsedJson& object) {
  Coefficient c{.name = object.at("name").get<std::string>(),
                .unit = object.at("unit").get<std::string>(),
                .value = object.at("value").get<double>()};
  c.lower = number_of(object, "lower").value_or(c.value);
  c.upper = number_of(object, "upper").value_or(c.value);
  c.standard_error = number_of(object, "standard_error");
  c.naive_standard_error = number_of(object, "naive_standard_error");
  c.effective_clusters = number_of(object, "effective_clusters");
  c.at_bound = object.value("at_bound", false);
  c.determined = object.value("determined", true);
  return c;
}

FitResult result_of(const ParsedJson& object) {
  FitResult result{.status = status_of(object.at("status").get<std::string>()),
                   .message = object.at("message").get<std::string>(),
                   .model = object.at("model").get<std::string>()};
  if (object.contains("fixed")) result.fixed = object.at("fixed").get<std::map<std::string, double>>();
  for (const ParsedJson& c : object.at("coefficients")) result.coefficients.push_back(coefficient_of(c));
  result.covariance = matrix_of(object, "covariance");
  result.naive_covariance = matrix_of(object, "naive_covariance");
  result.clusters = object.value("clusters", 0);
  for (const ParsedJson& c : object.at("captures")) result.captures.push_back(capture_of(c));
  if (object.contains("residuals")) {
    for (const ParsedJson& r : object.at("residuals")) {
      result.residuals.push_back({.output = r.at("output").get<std::string>(),
                                  .unit = r.at("unit").get<std::string>(),
                                  .rms = number_or_nan(r.at("rms"))});
    }
  }
  result.residual_count = object.value("residual_count", 0);
  result.whiteness = whiteness_of(object);
  for (const ParsedJson& level : object.at("noise")) {
    result.noise.push_back({.outputs = level.at("outputs").get<std::vector<std::string>>(),
                            .unit = level.at("unit").get<std::string>(),
                            .value = number_or_nan(level.at("value")),
                            .estimated = level.at("estimated").get<bool>()});
  }
  result.setup = read_setup(object, result);
  return result;
}

}  // namespace

FitResult read_fit(const std::filesystem::path& path) {
  const std::string text = io::read_text_file(path, {.expected = "the JSON of a fit (samara fit -o)"});
  const std::string expected = "the JSON of a fit (samara fit -o) was expected";
  try {
    const ParsedJson object = ParsedJson::parse(text);
    const std::string schema = object.is_object() ? object.value("schema", std::string()) : std::string();
    if (schema != "samara-fit/1") {
      throw InputError(path.string(),
                       schema.empty() ? expected : fmt::format("its schema is \"{}\"; {}", schema, expected));
    }
    return result_of(object);
  } catch (const ParsedJson::exception&) {
    throw InputError(path.string(), expected);
  }
}

}  // namespace samara::identification
