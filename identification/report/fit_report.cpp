#include "samara/identification/report/fit_report.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/base/names.h"
#include "samara/base/rounded.h"
#include "samara/base/unit_labels.h"
#include "samara/identification/captures/capture_suspicions.h"
#include "samara/identification/report/diagnostics_report.h"
#include "samara/identification/report/fit_setup.h"

namespace samara::identification {

namespace {

/// Row by row.
Json matrix(const Eigen::MatrixXd& values) {
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < values.rows(); ++row) rows.push_back(column(values.row(row).transpose()));
  return rows;
}

Json json_of(const FitResult& result, const Coefficient& c) {
  return {{"name", c.name},
          {"unit", c.unit},
          {"value", number(c.value)},
          {"standard_error", number(c.standard_error)},
          {"naive_standard_error", number(c.naive_standard_error)},
          {"lower", c.lower},
          {"upper", c.upper},
          {"at_bound", c.at_bound},
          {"determined", c.determined},
          {"cluster_shares", c.cluster_shares},
          {"effective_clusters", number(c.effective_clusters)},
          {"integration_shift", number(c.integration_shift)},
          {"verdict", verdict(result, c)}};
}

Json json_of(const std::vector<OutputRms>& residuals) {
  Json array = Json::array();
  for (const OutputRms& r : residuals)
    array.push_back({{"output", r.output}, {"unit", r.unit}, {"rms", number(r.rms)}});
  return array;
}

Json json_of(const CaptureFit& capture) {
  Json nuisances = Json::array();
  for (const Nuisance& n : capture.nuisances) {
    nuisances.push_back({{"name", n.name},
                         {"unit", n.unit},
                         {"value", number(n.value)},
                         {"standard_error", number(n.standard_error)},
                         {"at_bound", n.at_bound}});
  }
  Json outputs = Json::object();
  // Residuals may end with the attitude's, which has no column.
  for (Eigen::Index at = 0; at < capture.measured.cols(); ++at) {
    outputs[capture.residuals[static_cast<std::size_t>(at)].output] = {
        {"measured", column(capture.measured.col(at))}, {"model", column(capture.model.col(at))}};
  }
  return {{"id", capture.id},
          {"file", capture.file},
          {"checksum", capture.checksum},
          {"whole", capture.whole},
          {"labels", capture.labels},
          {"notes", capture.notes},
          {"known", capture.known},
          {"cluster", capture.cluster},
          {"frames", capture.frames},
          {"start", number(capture.start)},
          {"nuisances", nuisances},
          {"residuals", json_of(capture.residuals)},
          {"times", column(capture.times)},
          {"outputs", outputs}};
}

Json json_of(const StartRecord& start) {
  Json values = Json::array();
  for (const double value : start.coefficients) values.push_back(number(value));
  return {{"status", to_string(start.status)},
          {"message", start.message},
          {"coefficients", values},
          {"cost", number(start.cost)},
          {"iterations", start.iterations},
          {"reached_best", start.reached_best}};
}

Json json_of(const OtherOptimum& optimum) {
  const auto list = [](const std::vector<double>& values) {
    Json array = Json::array();
    for (const double value : values) array.push_back(number(value));
    return array;
  };
  return {{"coefficients", list(optimum.coefficients)},
          {"standard_errors", list(optimum.standard_errors)},
          {"cost", number(optimum.cost)},
          {"excess", number(optimum.excess)},
          {"excess_error", number(optimum.excess_error)}};
}

std::string error_text(const std::optional<double>& error) {
  return error ? fmt::format("{:.2g}", *error) : "-";
}

/// Lines without the blanks that padding leaves at their ends.
std::string without_trailing_blanks(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\n') result.erase(result.find_last_not_of(' ') + 1);
    result.push_back(c);
  }
  return result;
}

void add_coefficient_table(const FitResult& result, std::back_insert_iterator<std::string> out) {
  if (result.coefficients.empty()) return;
  fmt::format_to(out, "\n{:<16} {:>12} {:<10} {:>12} {:>12} {:>23} {}\n", "coefficient", "value", "unit",
                 "std. error", "naive", "box", "what may be said");
  for (const Coefficient& c : result.coefficients) {
    fmt::format_to(out, "{:<16} {:>12} {:<10} {:>12} {:>12} {:>23} {}\n", c.name,
                   rounded(c.value, c.standard_error ? c.standard_error : c.naive_standard_error),
                   shown_unit(c.unit), error_text(c.standard_error), error_text(c.naive_standard_error),
                   fmt::format("{:.4g} .. {:.4g}", c.lower, c.upper), verdict(result, c));
  }
  fmt::format_to(out,
                 "standard errors from the scatter of {} cluster{}; naive: frames taken as independent\n",
                 result.clusters, result.clusters == 1 ? "" : "s");
  for (const Coefficient& c : result.coefficients) {
    std::vector<std::string> parts;
    for (const int cluster : carriers(result, c)) {
      const auto at = static_cast<std::size_t>(cluster);
      parts.push_back(fmt::format("{} ({:.0f} %)", result.cluster_names[at], 100.0 * c.cluster_shares[at]));
    }
    if (parts.empty()) continue;
    fmt::format_to(
        out,
        "{} is determined mostly by {}: its error is at least that of the scatter between all clusters\n",
        c.name, join(parts));
  }
}

void add_capture_table(const FitResult& result, std::back_insert_iterator<std::string> out) {
  std::size_t longest = 20;
  for (const CaptureFit& capture : result.captures) longest = std::max(longest, capture.id.size());
  fmt::format_to(out, "\n{:<{}}  {:>6}", "capture", longest, "frames");
  for (const Nuisance& n : result.captures.front().nuisances) {
    fmt::format_to(out, "  {:>22}", with_unit(n.name, n.unit));
  }
  for (const OutputRms& r : result.residuals)
    fmt::format_to(out, "  {:>16}", with_unit(fmt::format("rms {}", r.output), r.unit));
  fmt::format_to(out, "\n");
  for (const CaptureFit& capture : result.captures) {
    fmt::format_to(out, "{:<{}}  {:>6}", capture.id, longest, capture.frames);
    for (const Nuisance& n : capture.nuisances) {
      fmt::format_to(out, "  {:>22}",
                     fmt::format("{}{}{}", with_error(n.value, n.standard_error),
                                 n.standard_error ? "" : " +- -", n.at_bound ? " !" : ""));
    }
    for (const OutputRms& r : capture.residuals) fmt::format_to(out, "  {:>16.3g}", r.rms);
    fmt::format_to(out, "\n");
  }
}

/// A line for each kind, with the capture that has it first, and how many others do.
std::vector<std::string> counted_notes(const FitResult& result) {
  std::vector<std::pair<std::string, std::string>> notes;
  for (const CaptureFit& capture : result.captures) {
    for (const std::string& note : capture.notes) notes.emplace_back(capture.id, note);
  }
  return merge_alike(notes);
}

}  // namespace

std::string fit_json(const FitResult& result) {
  Json coefficients = Json::array();
  for (const Coefficient& c : result.coefficients) coefficients.push_back(json_of(result, c));
  Json captures = Json::array();
  for (const CaptureFit& capture : result.captures) captures.push_back(json_of(capture));
  Json starts = Json::array();
  for (const StartRecord& start : result.starts) starts.push_back(json_of(start));
  Json optima = Json::array();
  for (const OtherOptimum& optimum : result.other_optima) optima.push_back(json_of(optimum));
  Json kinds = Json::array();
  for (const Warning& warning : result.warnings) kinds.push_back(to_string(warning.kind));
  Json object = {{"schema", "samara-fit/1"},
                 {"status", to_string(result.status)},
                 {"message", result.message},
                 {"warnings", result.warnings.sentences()},
                 {"warning_kinds", kinds},
                 {"model", result.model},
                 {"source", result.source},
                 {"loss", result.loss},
                 {"fixed", result.fixed},
                 {"setup", setup_json(result.setup)},
                 {"coefficients", coefficients},
                 {"covariance", matrix(result.covariance)},
                 {"naive_covariance", matrix(result.naive_covariance)},
                 {"correlation", matrix(result.correlation)},
                 {"clusters", result.clusters},
                 {"cluster_names", result.cluster_names},
                 {"residuals", json_of(result.residuals)},
                 {"residual_count", result.residual_count},
                 {"cost", number(result.cost)},
                 {"join_defect", number(result.join_defect)},
                 {"captures", captures},
                 {"starts", starts},
                 {"starts_at_best", result.starts_at_best},
                 {"other_optima", optima},
                 {"iterations", result.iterations},
                 {"evaluations", result.evaluations},
                 {"seconds", result.seconds}};
  add_diagnostics(result, object);
  // Ids and labels come from files in any encoding.
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string fit_text(const FitResult& result) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "fit of {} by {}, {} loss: {}\n", result.model, result.source, result.loss,
                 result.message);
  add_coefficient_table(result, out);
  if (!result.captures.empty()) add_capture_table(result, out);
  if (!result.residuals.empty()) fmt::format_to(out, "\n");
  for (const OutputRms& r : result.residuals) {
    fmt::format_to(out, "rms of {}: {:.4g}{}\n", r.output, r.rms, unit_suffix(r.unit));
  }
  if (result.residual_count > 0) fmt::format_to(out, "{} values compared\n", result.residual_count);
  if (result.join_defect) {
    fmt::format_to(out, "segments join to within {:.2g} standard deviations of their starts\n",
                   *result.join_defect);
  }
  for (const std::string& sentence : counted_notes(result)) fmt::format_to(out, "note: {}\n", sentence);
  add_diagnostics_text(result, text);
  if (result.evaluations > 0) {
    fmt::format_to(out, "{} iterations, {} trajectories, {:.3g} s\n", result.iterations, result.evaluations,
                   result.seconds);
  }
  for (const Warning& warning : result.warnings) fmt::format_to(out, "warning: {}\n", warning.sentence);
  return without_trailing_blanks(text);
}

}  // namespace samara::identification
