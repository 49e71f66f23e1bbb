#include "samara/identification/design/design_report.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/base/names.h"
#include "samara/base/rounded.h"
#include "samara/base/unit_labels.h"
#include "samara/identification/report/diagnostics_report.h"

namespace samara::identification {

namespace {

using Out = std::back_insert_iterator<std::string>;

Json json_of(const Design& design, const ProposedCapture& capture) {
  Json release = Json::object();
  for (std::size_t k = 0; k < capture.release.size(); ++k)
    release[design.coordinates[k].name] = number(capture.release[k]);
  return {{"release", release}, {"followed", capture.followed}};
}

std::string percent(double part) {
  return fmt::format("{:.3g} %", 100.0 * part);
}

void add_coefficients(const Design& design, Out out) {
  fmt::format_to(out, "\n{:<16} {:>12} {:<10} {:>12} {:>12}\n", "coefficient", "value", "unit", "error now",
                 "expected");
  for (const ExpectedError& c : design.coefficients) {
    fmt::format_to(out, "{:<16} {:>12} {:<10} {:>12} {:>12.2g}{}\n", c.name, rounded(c.value, c.now),
                   shown_unit(c.unit), c.was_determined ? fmt::format("{:.2g}", c.now) : "-", c.expected,
                   c.was_determined ? fmt::format(" {:>8}", percent(c.expected / c.now)) : "");
  }
  if (design.errors_are_clustered) {
    fmt::format_to(
        out,
        "errors so far are those of the scatter between captures, {:.3g} times the naive ones; noise of "
        "new captures counts as much more\n",
        std::sqrt(design.inflation));
  }
}

void add_releases(const Design& design, Out out) {
  if (design.coordinates.empty()) return;
  fmt::format_to(out, "\n{:<16}", "release");
  for (const ReleaseCoordinate& c : design.coordinates)
    fmt::format_to(out, " {:>18}", with_unit(c.name, c.unit));
  fmt::format_to(out, "\n");
  for (std::size_t k = 0; k < design.captures.size(); ++k) {
    fmt::format_to(out, "{:<16}", fmt::format("capture {}", k + 1));
    for (const double value : design.captures[k].release) fmt::format_to(out, " {:>18.5g}", value);
    fmt::format_to(out, "\n");
  }
  fmt::format_to(out, "{:<16}", "within");
  for (const ReleaseCoordinate& c : design.coordinates) {
    fmt::format_to(out, " {:>18}",
                   c.lower == c.upper ? "held" : fmt::format("{:.4g} .. {:.4g}", c.lower, c.upper));
  }
  fmt::format_to(out, "\nmean error expected: {} of that now", percent(design.error));
  if (std::isfinite(design.random_error))
    fmt::format_to(out, "; of as many releases anywhere in the box: {} (median)",
                   percent(design.random_error));
  fmt::format_to(out, "\n");
}

void add_outputs(const Design& design, Out out) {
  fmt::format_to(out, "\n{:<16} {:>12} {:>20} {:>20}\n", "output", "noise", "error, it alone", "without it");
  for (const OutputWorth& o : design.outputs) {
    fmt::format_to(out, "{:<16} {:>12.3g} {:>20} {:>20}\n", with_unit(o.output, o.unit), o.noise,
                   percent(o.alone), percent(o.without));
  }
}

/// Where shares of the precision are reached, and what fewer frames cost.
void add_times(const Design& design, Out out) {
  fmt::format_to(out, "\n{:<16} {:>12} {:>20}\n", "film until [s]", "error", "of what it adds");
  for (const double share : {0.25, 0.5, 0.75, 0.9}) {
    const auto reached =
        std::ranges::find_if(design.lengths, [&](const FilmLength& length) { return length.share >= share; });
    if (reached == design.lengths.end()) continue;
    fmt::format_to(out, "{:<16.4g} {:>12} {:>20}\n", reached->duration, percent(reached->error),
                   percent(reached->share));
  }
  fmt::format_to(out, "{} frames: {}", design.frames, percent(design.error));
  for (const FrameCount& count : design.frame_counts)
    fmt::format_to(out, ", {}: {}", count.frames, percent(count.error));
  fmt::format_to(
      out, "{}\n",
      design.errors_are_clustered ? "; fewer lose less than that where neighbours are wrong together" : "");
  if (design.times.empty()) return;
  fmt::format_to(out, "the best {} frames alone, {}: at", design.times.size(), percent(design.times_error));
  for (const double time : design.times) fmt::format_to(out, " {:.4g}", time);
  fmt::format_to(out, " s\n");
}

}  // namespace

std::string design_json(const Design& design) {
  Json coefficients = Json::array(), coordinates = Json::array(), captures = Json::array(),
       outputs = Json::array(), lengths = Json::array(), counts = Json::array();
  for (const ExpectedError& c : design.coefficients) {
    coefficients.push_back({{"name", c.name},
                            {"unit", c.unit},
                            {"value", number(c.value)},
                            {"was_determined", c.was_determined},
                            {"error_now", number(c.now)},
                            {"error_expected", number(c.expected)}});
  }
  for (const ReleaseCoordinate& c : design.coordinates)
    coordinates.push_back({{"name", c.name}, {"unit", c.unit}, {"lower", c.lower}, {"upper", c.upper}});
  for (const ProposedCapture& capture : design.captures) captures.push_back(json_of(design, capture));
  for (const OutputWorth& o : design.outputs) {
    outputs.push_back({{"output", o.output},
                       {"unit", o.unit},
                       {"noise", number(o.noise)},
                       {"error_alone", number(o.alone)},
                       {"error_without", number(o.without)}});
  }
  for (const FilmLength& l : design.lengths)
    lengths.push_back({{"duration", l.duration}, {"error", number(l.error)}, {"share", number(l.share)}});
  for (const FrameCount& f : design.frame_counts)
    counts.push_back({{"frames", f.frames}, {"error", number(f.error)}});
  const Json object = {{"schema", "samara-design/1"},
                       {"model", design.model},
                       {"source", design.source},
                       {"criterion", to_string(design.criterion)},
                       {"of", design.of},
                       {"duration", design.duration},
                       {"frames", design.frames},
                       {"errors_are_clustered", design.errors_are_clustered},
                       {"inflation", number(design.inflation)},
                       {"draws", design.draws},
                       {"coefficients", coefficients},
                       {"coordinates", coordinates},
                       {"captures", captures},
                       {"error", number(design.error)},
                       {"random_error", number(design.random_error)},
                       {"outputs", outputs},
                       {"lengths", lengths},
                       {"sufficient_duration", design.sufficient_duration},
                       {"frame_counts", counts},
                       {"times", design.times},
                       {"times_error", design.times.empty() ? Json(nullptr) : number(design.times_error)},
                       {"warnings", design.warnings.sentences()},
                       {"evaluations", design.evaluations},
                       {"seconds", design.seconds}};
  // Names come from files in any encoding.
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string design_text(const Design& design) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(
      out, "{} capture{} more of {} by {}, {}-optimal in {}: {:.4g} s, {} frames, means over {} draws\n",
      design.captures.size(), design.captures.size() == 1 ? "" : "s", design.model, design.source,
      to_string(design.criterion), join(design.of), design.duration, design.frames, design.draws);
  add_coefficients(design, out);
  add_releases(design, out);
  add_outputs(design, out);
  add_times(design, out);
  fmt::format_to(out, "{} trajectories, {:.3g} s\n", design.evaluations, design.seconds);
  for (const Warning& warning : design.warnings) fmt::format_to(out, "warning: {}\n", warning.sentence);
  return text;
}

}  // namespace samara::identification
