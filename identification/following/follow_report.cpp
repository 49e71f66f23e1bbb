#include "samara/identification/following/follow_report.h"

#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "samara/base/rounded.h"
#include "samara/base/unit_labels.h"
#include "samara/identification/report/diagnostics_report.h"

namespace samara::identification {

namespace {

Json rows_of(const Eigen::MatrixXd& table) {
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < table.rows(); ++row) rows.push_back(column(table.row(row).transpose()));
  return rows;
}

std::string header_of(const std::string& name, const std::string& unit) {
  return fmt::format("{}[{}]", name, unit);
}

void add_cell(std::string& line, double value) {
  line += std::isfinite(value) ? fmt::format(",{}", value) : ",";
}

/// The last row that has a state; -1 if there is none.
Eigen::Index last_followed(const FollowedMotion& motion) {
  for (Eigen::Index row = motion.values.rows(); row-- > 0;) {
    if (motion.values.cols() > 0 && !std::isnan(motion.values(row, 0))) return row;
  }
  return -1;
}

/// The last row in which anything was seen; -1 if there is none.
Eigen::Index last_seen(const FollowedMotion& motion) {
  for (Eigen::Index row = std::ssize(motion.frames); row-- > 0;) {
    if (motion.frames[static_cast<std::size_t>(row)].status != FollowStatus::blind) return row;
  }
  return -1;
}

struct Innovations {
  double squared = 0.0;  ///< of frames within the gate, as are the values
  int values = 0;
  int frames = 0;                                    ///< that were compared
  int beyond = 0;                                    ///< frames beyond the gate
  int runs = 0;                                      ///< rows of such frames
  double ratio() const { return squared / values; }  ///< to what was expected
};

Innovations innovations_of(const FollowedMotion& motion) {
  Innovations sum;
  bool was_beyond = false;
  for (const FollowedFrame& frame : motion.frames) {
    if (std::isnan(frame.innovation_squared)) continue;
    const bool is_beyond = frame.status == FollowStatus::outlier || frame.status == FollowStatus::lost;
    ++sum.frames;
    if (is_beyond) {
      ++sum.beyond;
      if (!was_beyond) ++sum.runs;
    } else {
      sum.squared += frame.innovation_squared;
      sum.values += frame.values;
    }
    // The frame after a loss is compared with a start of its own.
    was_beyond = frame.status == FollowStatus::outlier;
  }
  return sum;
}

/// Wrong frames of a right model, such as a marker that was mixed up, are fewer than a tenth, and one wrong state,
/// such as an angle that nothing measures, makes one row of frames lie far off: those alone do not speak against the
/// model. Fewer than ten frames tell too little.
bool speak_against_model(const Innovations& innovations) {
  constexpr int kFewest = 10;
  constexpr double kMost = 0.1;
  return innovations.frames >= kFewest && innovations.runs > 1 &&
         innovations.beyond > kMost * innovations.frames;
}

std::string noise_text(const FollowReport& report) {
  const NoiseChoice& noise = report.noise;
  const GivenNoise& given = report.given;
  const auto shown = [&](double number, const char* unit, const std::optional<double>& said) {
    return fmt::format("{:.3g}{}{}", number, unit, report.noise_was_chosen && said ? " (given)" : "");
  };
  std::vector<std::string> of_model;
  if (report.has_velocities)
    of_model.push_back("of velocities " + shown(noise.velocity, " m/s", given.velocity));
  if (report.has_rates) of_model.push_back("of rates " + shown(noise.rate, " rad/s", given.rate));
  return fmt::format(
      "noise of frames times {}{}{}{}; coefficients differ by {} and drift by {} per root of a second: {}\n",
      shown(noise.noise_factor, "", given.noise_factor), of_model.empty() ? "" : ", ",
      fmt::join(of_model, " and "), of_model.empty() ? "" : " per root of a second",
      shown(noise.spread, "", given.spread), shown(noise.drift, "", given.drift),
      report.noise_was_chosen ? "chosen on captures to train" : "as given");
}

}  // namespace

bool is_followed_to_end(const FollowReport& report) {
  const Eigen::Index row = last_followed(report.motion);
  return row >= 0 && row >= last_seen(report.motion);
}

void add_follow_warnings(FollowReport& report) {
  const FollowedMotion& motion = report.motion;
  const Eigen::Index row = last_followed(motion);
  if (row < 0) {
    report.warnings.add(WarningKind::captures, "no start was found: no frame was followed");
  } else if (!is_followed_to_end(report)) {
    report.warnings.add(
        WarningKind::model,
        fmt::format("the motion was lost after {:.6g} s, and not found again by the last "
                    "frame, at {:.6g} s: the state is that of {:.6g} s",
                    motion.times[row], motion.times[last_seen(motion)], motion.state_times[row]));
  }
  const Innovations innovations = innovations_of(motion);
  if (speak_against_model(innovations)) {
    report.warnings.add(
        WarningKind::model,
        fmt::format("{} of {} frames lie farther from the forecast than errors allow, where one in 10,000 "
                    "was expected: the model does not move as the frames do, or the errors are too small",
                    innovations.beyond, innovations.frames));
  }
}

std::string follow_text(const FollowReport& report) {
  const FollowedMotion& motion = report.motion;
  std::string text;
  const auto out = std::back_inserter(text);
  std::array<int, 5> counts = {};
  for (const FollowedFrame& frame : motion.frames) ++counts[static_cast<std::size_t>(frame.status)];
  fmt::format_to(out, "{} followed through \"{}\": {} frames", report.model, motion.capture,
                 motion.frames.size());
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] > 0) fmt::format_to(out, ", {} {}", counts[k], to_string(static_cast<FollowStatus>(k)));
  }
  const Innovations innovations = innovations_of(motion);
  text += "\n";
  if (innovations.values > 0) {
    fmt::format_to(out, "innovations squared are {:.3g} times what was expected of {} values\n",
                   innovations.ratio(), innovations.values);
  }
  text += noise_text(report);
  const Eigen::Index row = last_followed(motion);
  if (row < 0) {
    return text;
  }
  fmt::format_to(out, "\nat {:.6g} s{:>14} {:>14} {:>14}\n", motion.state_times[row], "", "value", "error");
  for (std::size_t k = 0; k < motion.names.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    const double error = motion.errors(row, at);
    fmt::format_to(out, "{:<24} {:>14} {:>14.2g} {}\n", motion.names[k],
                   rounded(motion.values(row, at), error), error, shown_unit(motion.units[k]));
  }
  if (motion.outputs.empty()) return text;
  fmt::format_to(out, "\nfrom {:.6g} s, {:.6g} s ahead{:>8} {:>14} {:>14}\n", motion.times[row], motion.ahead,
                 "mean", "90 % from", "to");
  for (std::size_t k = 0; k < motion.outputs.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    fmt::format_to(out, "{:<24} {:>14.5g} {:>14.5g} {:>14.5g} {}\n", motion.outputs[k],
                   motion.forecasts.mean(row, at), motion.forecasts.lower(row, at),
                   motion.forecasts.upper(row, at), shown_unit(motion.output_units[k]));
  }
  return text;
}

std::string follow_csv(const FollowReport& report) {
  const FollowedMotion& motion = report.motion;
  std::string text = "t[s],status,hypotheses[1],innovation_squared[1],state_t[s]";
  for (const char* kind : {"", "smoothed "}) {
    for (std::size_t k = 0; k < motion.names.size(); ++k) {
      text += fmt::format(",{},{}", header_of(kind + motion.names[k], motion.units[k]),
                          header_of(fmt::format("{}error of {}", kind, motion.names[k]), motion.units[k]));
    }
  }
  for (std::size_t k = 0; k < motion.outputs.size(); ++k) {
    for (const char* kind : {"ahead ", "ahead 5 % ", "ahead 95 % "})
      text += "," + header_of(kind + motion.outputs[k], motion.output_units[k]);
  }
  text += "\n";
  for (Eigen::Index row = 0; row < motion.times.size(); ++row) {
    const FollowedFrame& frame = motion.frames[static_cast<std::size_t>(row)];
    std::string line = fmt::format("{},{},{}", motion.times[row], to_string(frame.status), frame.hypotheses);
    add_cell(line, frame.innovation_squared);
    add_cell(line, motion.state_times[row]);
    for (const auto& [values, errors] : {std::pair{&motion.values, &motion.errors},
                                         std::pair{&motion.smoothed_values, &motion.smoothed_errors}}) {
      for (Eigen::Index k = 0; k < values->cols(); ++k) {
        add_cell(line, (*values)(row, k));
        add_cell(line, (*errors)(row, k));
      }
    }
    for (Eigen::Index k = 0; k < std::ssize(motion.outputs); ++k) {
      for (const Eigen::MatrixXd* table :
           {&motion.forecasts.mean, &motion.forecasts.lower, &motion.forecasts.upper})
        add_cell(line, (*table)(row, k));
    }
    text += line + "\n";
  }
  return text;
}

std::string follow_json(const FollowReport& report) {
  const FollowedMotion& motion = report.motion;
  Json columns = Json::array();
  for (std::size_t k = 0; k < motion.names.size(); ++k)
    columns.push_back({{"name", motion.names[k]}, {"unit", motion.units[k]}});
  Json outputs = Json::array();
  for (std::size_t k = 0; k < motion.outputs.size(); ++k)
    outputs.push_back({{"name", motion.outputs[k]}, {"unit", motion.output_units[k]}});
  Json frames = Json::array();
  for (std::size_t k = 0; k < motion.frames.size(); ++k) {
    const FollowedFrame& frame = motion.frames[k];
    const auto row = static_cast<Eigen::Index>(k);
    frames.push_back({{"time", motion.times[row]},
                      {"state_time", number(motion.state_times[row])},
                      {"status", to_string(frame.status)},
                      {"values", frame.values},
                      {"innovation_squared", number(frame.innovation_squared)},
                      {"hypotheses", frame.hypotheses}});
  }
  const Json object = {{"schema", "samara-follow/1"},
                       {"model", report.model},
                       {"source", report.source},
                       {"capture", motion.capture},
                       {"noise",
                        {{"chosen", report.noise_was_chosen},
                         {"noise_factor", report.noise.noise_factor},
                         {"velocity", report.noise.velocity},
                         {"rate", report.noise.rate},
                         {"spread", report.noise.spread},
                         {"drift", report.noise.drift},
                         {"score", report.noise_was_chosen ? Json(report.noise.score) : Json(nullptr)}}},
                       {"columns", columns},
                       {"frames", frames},
                       {"values", rows_of(motion.values)},
                       {"errors", rows_of(motion.errors)},
                       {"smoothed_values", rows_of(motion.smoothed_values)},
                       {"smoothed_errors", rows_of(motion.smoothed_errors)},
                       {"log_likelihood", number(motion.log_likelihood)},
                       {"ahead", motion.outputs.empty() ? Json(nullptr) : Json(motion.ahead)},
                       {"outputs", outputs},
                       {"forecast", rows_of(motion.forecasts.mean)},
                       {"forecast_lower", rows_of(motion.forecasts.lower)},
                       {"forecast_upper", rows_of(motion.forecasts.upper)},
                       {"warnings", report.warnings.sentences()}};
  return object.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace samara::identification
