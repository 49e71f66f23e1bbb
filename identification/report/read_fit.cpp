#include "samara/identification/report/read_fit.h"

#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/base/errors.h"
#include "samara/io/text_file.h"

namespace samara::identification {

namespace {

using ParsedJson = nlohmann::json;

FitStatus status_of(const std::string& text) {
  for (const FitStatus status :
       {FitStatus::converged, FitStatus::not_determined, FitStatus::iteration_limit}) {
    if (to_string(status) == text) return status;
  }
  return FitStatus::failed;
}

std::optional<double> number_of(const ParsedJson& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return {};
  return found->get<double>();
}

Coefficient coefficient_of(const ParsedJson& object) {
  Coefficient c{.name = object.at("name").get<std::string>(),
                .unit = object.at("unit").get<std::string>(),
                .value = object.at("value").get<double>()};
  c.lower = number_of(object, "lower").value_or(c.value);
  c.upper = number_of(object, "upper").value_or(c.value);
  c.standard_error = number_of(object, "standard_error");
  c.naive_standard_error = number_of(object, "naive_standard_error");
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
  for (const ParsedJson& c : object.at("captures")) {
    const auto id = c.at("id").get<std::string>();
    result.captures.push_back(
        {.id = id, .file = c.at("file").get<std::string>(), .whole = c.value("whole", id)});
  }
  for (const ParsedJson& level : object.at("noise")) {
    result.noise.push_back({.outputs = level.at("outputs").get<std::vector<std::string>>(),
                            .unit = level.at("unit").get<std::string>(),
                            .value = level.at("value").get<double>(),
                            .estimated = level.at("estimated").get<bool>()});
  }
  return result;
}

}  // namespace

FitResult read_fit(const std::filesystem::path& path) {
  const std::string text = io::read_text_file(path);
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
