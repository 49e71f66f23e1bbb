#include "motion/motion_answers.h"

#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "inputs/assignments.h"
#include "samara/codebooks/model/model_file.h"
#include "terminal/terminal.h"

namespace samara::apps {

std::string release_text(const motion::Sweep& sweep, Eigen::Index release) {
  if (sweep.releases.empty()) return "its own";
  const motion::Release& one = sweep.releases[static_cast<std::size_t>(release)];
  constexpr double kDegree = std::numbers::pi / 180.0;
  return fmt::format("{:.4g} deg about {:.4g} deg", one.tilt / kDegree, one.axis / kDegree);
}

std::string sweep_counts(const motion::Sweep& sweep) {
  std::string text = fmt::format("{:<24}", "release");
  for (const std::string& name : motion::pattern_names()) text += fmt::format(" {:>12}", name);
  for (Eigen::Index r = 0; r < sweep.release_count(); ++r) {
    text += fmt::format("\n{:<24}", release_text(sweep, r));
    for (const int count : sweep.counts(r)) text += fmt::format(" {:>12}", count);
  }
  text += "\n";
  if (sweep.run_count() < sweep.fall_count())
    text += fmt::format("{} of {} falls were run, the others inherited their patterns\n", sweep.run_count(),
                        sweep.fall_count());
  return text + thresholds_text(sweep.thresholds);
}

std::string thresholds_text(const motion::PatternThresholds& thresholds) {
  constexpr std::size_t kWidth = 110;
  std::string text, line = "thresholds";
  for (const motion::NamedThreshold& one : motion::named_thresholds()) {
    const std::string word = fmt::format("  {} {:g}", one.name, thresholds.*one.value);
    if (line.size() + word.size() > kWidth) {
      text += line + "\n";
      line = "          ";
    }
    line += word;
  }
  return text + line + "\n";
}

Json thresholds_json(const motion::PatternThresholds& thresholds) {
  Json object;
  for (const motion::NamedThreshold& one : motion::named_thresholds())
    object[one.name] = thresholds.*one.value;
  return object;
}

models::ParametricModel body_of(const std::string& name, const std::vector<std::string>& set) {
  const auto model = codebooks::open_model(name);
  std::map<std::string, std::string> units;
  for (const auto& parameter : model->info().parameters) units[parameter.name] = parameter.unit;
  for (const auto& state : model->info().states) units[state.name + "(0)"] = state.unit;
  const std::map<std::string, double> values = parse_assignments(set, units);
  require_parameters(name, model->info(), values);
  const models::ParametricModel body(model, values, {});
  body.check({});
  warn_of_parameters(*model, body.fixed());
  return body;
}

Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json sweep_json(const motion::Sweep& sweep) {
  Json object = {{"schema", "samara-sweep/1"},
                 {"model", sweep.model},
                 {"coordinates", sweep.names},
                 {"points", sweep.points.rows()},
                 {"falls", sweep.fall_count()},
                 {"run", sweep.run_count()},
                 {"thresholds", thresholds_json(sweep.thresholds)},
                 {"rounds", Json::array()},
                 {"releases", Json::array()}};
  for (const motion::RefiningRound& round : sweep.rounds)
    object["rounds"].push_back(
        {{"points", round.points}, {"run", round.run}, {"agreement", round.agreement}});
  for (Eigen::Index r = 0; r < sweep.release_count(); ++r) {
    Json one = {{"release", release_text(sweep, r)}};
    const std::vector<int> counts = sweep.counts(r);
    for (std::size_t k = 0; k < counts.size(); ++k) one["counts"][motion::pattern_names()[k]] = counts[k];
    object["releases"].push_back(one);
  }
  return object;
}

std::string confusion_table(const Eigen::MatrixXi& counts, const std::vector<std::string>& rows,
                            const std::vector<std::string>& columns) {
  std::string text = fmt::format("  {:<14}", "");
  for (Eigen::Index c = 0; c < counts.cols(); ++c) {
    if (counts.col(c).sum() > 0) text += fmt::format(" {:>12}", columns[static_cast<std::size_t>(c)]);
  }
  for (Eigen::Index r = 0; r < counts.rows(); ++r) {
    if (counts.row(r).sum() == 0) continue;
    text += fmt::format("\n  {:<14}", rows[static_cast<std::size_t>(r)]);
    for (Eigen::Index c = 0; c < counts.cols(); ++c) {
      if (counts.col(c).sum() > 0) text += fmt::format(" {:>12}", counts(r, c));
    }
  }
  return text + "\n";
}

Json to_json(const motion::Agreement& agreement) {
  Json rows = Json::array();
  for (const auto& row : agreement.confusion.rowwise())
    rows.push_back(std::vector<int>(row.begin(), row.end()));
  return {{"confusion", rows},
          {"agreement", agreement.share},
          {"balanced", agreement.balanced},
          {"kappa", agreement.kappa},
          {"adjusted_rand", agreement.adjusted_rand}};
}

}  // namespace samara::apps
