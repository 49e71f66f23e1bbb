#include "motion/sweep_patterns.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "motion/motion_answers.h"
#include "motion/pattern_points.h"
#include "samara/base/errors.h"
#include "samara/base/rounded.h"
#include "samara/io/atomic_file.h"
#include "samara/motion/pages/pattern_page.h"
#include "samara/motion/patterns/clusters.h"
#include "samara/motion/sweeps/landing.h"
#include "samara/motion/sweeps/pattern_map.h"
#include "samara/motion/sweeps/phase_diagram.h"
#include "samara/motion/sweeps/sweep_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

using motion::Feature;
using motion::Sweep;

const std::vector<Feature> kOurs = {Feature::tilt, Feature::flips, Feature::drift, Feature::recurrence};
const std::vector<Feature> kSource = {Feature::d, Feature::e};

/// Falls of a release that know all features that are clustered, so that all clusters are of the same falls.
std::vector<std::size_t> known_falls(const Sweep& sweep, Eigen::Index release) {
  std::vector<std::size_t> falls;
  for (Eigen::Index n = 0; n < sweep.fall_count(); ++n) {
    const auto k = static_cast<std::size_t>(n);
    const auto is_known = [&](Feature feature) { return sweep.features[k].knows(feature); };
    if (sweep.release_of(n) == release && std::ranges::all_of(kOurs, is_known) &&
        std::ranges::all_of(kSource, is_known))
      falls.push_back(k);
  }
  return falls;
}

/// Clusters of some features beside the rule.
struct ClusteredFalls {
  std::string name;
  motion::Clusters clusters;
  Eigen::MatrixXi counts;  ///< patterns x clusters
  double adjusted_rand = 0.0;
};

ClusteredFalls clustered(const Sweep& sweep, const std::vector<std::size_t>& falls, const std::string& name,
                         const std::vector<Feature>& features, bool mixture, int clusters) {
  std::vector<int> rule;
  std::vector<double> numbers;
  for (const std::size_t n : falls) {
    for (const Feature feature : features) numbers.push_back(sweep.features[n][feature]);
    rule.push_back(static_cast<int>(sweep.labels[n].pattern));
  }
  const auto columns = static_cast<Eigen::Index>(features.size());
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::MatrixXd points = motion::standardised(
      Eigen::Map<const Rows>(numbers.data(), static_cast<Eigen::Index>(rule.size()), columns));
  const motion::ClusterOptions options = {.clusters = clusters};
  ClusteredFalls result = {name, mixture ? gaussian_mixture(points, options) : k_means(points, options),
                           Eigen::MatrixXi::Zero(motion::kPatterns, clusters), 0.0};
  for (std::size_t n = 0; n < rule.size(); ++n) ++result.counts(rule[n], result.clusters.assignment[n]);
  result.adjusted_rand = motion::adjusted_rand(rule, result.clusters.assignment);
  return result;
}

/// None where fewer falls know their features than there are clusters.
std::vector<ClusteredFalls> all_clusters(const Sweep& sweep, Eigen::Index release, int clusters) {
  const std::vector<std::size_t> falls = known_falls(sweep, release);
  if (static_cast<int>(falls.size()) < clusters) return {};
  return {clustered(sweep, falls, "k-means of tilt, flips, drift, recurrence", kOurs, false, clusters),
          clustered(sweep, falls, "Gaussian mixture of the same", kOurs, true, clusters),
          clustered(sweep, falls, "k-means of the source's (d, e)", kSource, false, clusters)};
}

std::vector<std::string> cluster_names(int clusters) {
  std::vector<std::string> names;
  for (int c = 0; c < clusters; ++c) names.push_back(fmt::format("cluster {}", c + 1));
  return names;
}

std::string landing_text(const Sweep& sweep, Eigen::Index release) {
  std::string text;
  for (const motion::LandingStatistics& s : motion::landing_statistics(sweep, release)) {
    if (s.falls == 0) continue;
    text += fmt::format(
        "  {:<14} {:>6} falls  x {} m  y {} m  deviations {:.3g}, {:.3g} m  "
        "distance {} m  after {:.3g} s\n",
        to_string(s.pattern), s.falls, with_error(s.mean.x(), s.mean_error.x()),
        with_error(s.mean.y(), s.mean_error.y()), std::sqrt(s.covariance(0, 0)),
        std::sqrt(s.covariance(1, 1)), with_error(s.distance, s.distance_error), s.time);
  }
  return text.empty() ? text : "landing\n" + text;
}

std::string map_text(const motion::PatternMap& map) {
  std::string text = fmt::format(
      "map: {:.1f} % of the {} points that were run are called right by their {} nearest; {:.1f} % have a "
      "neighbour of another pattern\n",
      100.0 * map.left_one_out(), map.run_count(), motion::PatternMap::kNeighbours,
      100.0 * map.border_share());
  const std::vector<motion::MapRegion> regions = map.regions();
  for (std::size_t k = 0; k < motion::kPatterns; ++k) {
    const auto pattern = static_cast<motion::Pattern>(k);
    int count = 0;
    Eigen::Index largest = 0, total = 0;
    for (const motion::MapRegion& region : regions) {
      if (region.pattern != pattern) continue;
      ++count;
      total += region.falls;
      largest = std::max(largest, region.falls);
    }
    if (count > 0)
      text += fmt::format("  {:<14} {:>6} points in {} region{}, {:.1f} % of them in the largest\n",
                          to_string(pattern), total, count, count == 1 ? "" : "s",
                          100.0 * static_cast<double>(largest) / static_cast<double>(total));
  }
  return text;
}

Json landing_json(const Sweep& sweep, Eigen::Index release) {
  Json list = Json::array();
  for (const motion::LandingStatistics& s : motion::landing_statistics(sweep, release)) {
    list.push_back(
        {{"pattern", to_string(s.pattern)},
         {"share", s.share.value},
         {"share_interval", {s.share.lower, s.share.upper}},
         {"landed", s.falls},
         {"mean", {s.mean.x(), s.mean.y()}},
         {"mean_error", {s.mean_error.x(), s.mean_error.y()}},
         {"covariance", {{s.covariance(0, 0), s.covariance(0, 1)}, {s.covariance(1, 0), s.covariance(1, 1)}}},
         {"distance", s.distance},
         {"distance_error", s.distance_error},
         {"time", s.time}});
  }
  return list;
}

Json release_json(const Sweep& sweep, Eigen::Index release, int clusters) {
  const motion::PatternMap map(sweep, release);
  Json one = {{"left_one_out", map.left_one_out()},
              {"points_run", map.run_count()},
              {"border_share", map.border_share()},
              {"regions", Json::array()}};
  for (const motion::MapRegion& region : map.regions())
    one["regions"].push_back({{"pattern", to_string(region.pattern)}, {"points", region.falls}});
  one["clusters"] = Json::array();
  for (const ClusteredFalls& c : all_clusters(sweep, release, clusters))
    one["clusters"].push_back({{"name", c.name},
                               {"falls", c.counts.sum()},
                               {"adjusted_rand", c.adjusted_rand},
                               {"message", c.clusters.message}});
  one["landing"] = landing_json(sweep, release);
  return one;
}

std::string release_report(const Sweep& sweep, Eigen::Index release, int clusters) {
  std::string text = fmt::format("\nrelease {}\n{}{}", release_text(sweep, release),
                                 map_text(motion::PatternMap(sweep, release)), landing_text(sweep, release));
  for (const ClusteredFalls& c : all_clusters(sweep, release, clusters)) {
    text += fmt::format("{}, {} falls: adjusted Rand index {:.2f} with the rule\n{}", c.name, c.counts.sum(),
                        c.adjusted_rand,
                        confusion_table(c.counts, motion::pattern_names(), cluster_names(clusters)));
  }
  return text;
}

/// Of the points from which all releases lead to the same pattern.
double share_of_one_pattern(const Sweep& sweep) {
  const Eigen::MatrixXd shares = motion::release_shares(sweep);
  if (shares.rows() == 0) return 0.0;
  return (shares.rowwise().maxCoeff().array() == 1.0).cast<double>().mean();
}

std::string shares_text(const Sweep& sweep) {
  if (sweep.release_count() < 2) return "";
  return fmt::format(
      "{:.1f} % of the points have one pattern from all {} releases; the others fall in several ways\n",
      100.0 * share_of_one_pattern(sweep), sweep.release_count());
}

}  // namespace

int patterns_of_sweep(const PatternsArguments& arguments) {
  if (!arguments.labels.empty() || !arguments.classes.empty() || !arguments.sidecar.empty() ||
      !arguments.length.empty() || !arguments.body.empty() ||
      (!arguments.set.empty() && !asks_for_points(arguments)) || !arguments.thresholds.empty())
    throw ArgumentError(
        "--labels, --class, --sidecar, --length, --body, --set and --threshold are of captures, and the "
        "input is a sweep: its plan says what falls, and its thresholds");
  const Sweep sweep = motion::load_sweep(arguments.inputs.front());
  if (asks_for_points(arguments)) return points_of_map(arguments, sweep);
  if (!arguments.report.empty()) io::write_text_atomically(arguments.report, motion::pattern_html(sweep));
  Json object = sweep_json(sweep);
  std::string text = sweep_counts(sweep) + shares_text(sweep);
  if (sweep.release_count() > 1) object["points_of_one_pattern"] = share_of_one_pattern(sweep);
  const auto answer = [&] { write_answer(arguments.output, arguments.json ? json_line(object) : text); };
  const int clusters = arguments.clusters.value_or(4);
  if (sweep.fall_count() / sweep.release_count() <= std::max(motion::PatternMap::kNeighbours, clusters)) {
    narrate("so few points have no map and no clusters");
    answer();
    return kDone;
  }
  for (Eigen::Index r = 0; r < sweep.release_count(); ++r) {
    if (arguments.json) {
      object["releases"][static_cast<std::size_t>(r)].update(release_json(sweep, r, clusters));
    } else {
      text += release_report(sweep, r, clusters);
    }
  }
  answer();
  return kDone;
}

}  // namespace samara::apps
