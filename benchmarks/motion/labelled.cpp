#include <cmath>
#include <cstdlib>
#include <iostream>
#include <sstream>

#include <boost/math/distributions/students_t.hpp>
#include <fmt/format.h>

#include "motion/cases.h"
#include "samara/motion/patterns/clusters.h"

namespace samara::benchmarks::motion_cases {

std::vector<std::uint64_t> fresh_seeds(const Options& options) {
  if (const char* const given = std::getenv("SAMARA_MOTION_SEEDS")) {  // of development
    std::vector<std::uint64_t> seeds;
    std::istringstream words(given);
    for (std::uint64_t seed = 0; words >> seed;) seeds.push_back(seed);
    return seeds;
  }
  std::vector<std::uint64_t> seeds = {271828, 314159, 577215, 618033, 662607,
                                      693147, 732050, 141421, 161803, 224744};
  if (options.quick) seeds.resize(2);
  return seeds;
}

void Labelled::add(const Labelled& more) {
  truth.insert(truth.end(), more.truth.begin(), more.truth.end());
  rule.insert(rule.end(), more.rule.begin(), more.rule.end());
}

void add(Labelled& to, motion::Pattern truth, motion::Pattern rule) {
  to.truth.push_back(static_cast<int>(truth));
  to.rule.push_back(static_cast<int>(rule));
}

std::vector<int> source_clusters(const std::vector<motion::Features>& all, int clusters) {
  Eigen::MatrixXd points(static_cast<Eigen::Index>(all.size()), 2);
  // The source gives every motion both: where noise hides the way over the ground, it has no shape.
  for (std::size_t n = 0; n < all.size(); ++n) {
    const double e = all[n][motion::Feature::e];
    points.row(static_cast<Eigen::Index>(n)) << all[n][motion::Feature::d], std::isfinite(e) ? e : 0.0;
  }
  return motion::k_means(motion::standardised(points), {.clusters = clusters}).assignment;
}

void report_agreement(const std::string& test_case, const std::vector<Labelled>& seeds, bool with_source) {
  constexpr int kClasses = static_cast<int>(motion::kPatterns);
  Labelled pooled;
  double source = 0.0;
  Eigen::MatrixX3d each(static_cast<Eigen::Index>(seeds.size()), 3);
  for (std::size_t k = 0; k < seeds.size(); ++k) {
    pooled.add(seeds[k]);
    const motion::Agreement one = motion::agreement(seeds[k].truth, seeds[k].rule, kClasses);
    each.row(static_cast<Eigen::Index>(k)) << one.share, one.balanced, one.adjusted_rand;
    if (with_source)
      source += motion::adjusted_rand(seeds[k].truth, seeds[k].source) / static_cast<double>(seeds.size());
  }
  const motion::Agreement all = motion::agreement(pooled.truth, pooled.rule, kClasses);
  const double n = static_cast<double>(seeds.size());
  // 97.5 % point of Student's t: the scatter is that of few seeds.
  const double student = boost::math::quantile(boost::math::students_t(std::max(1.0, n - 1.0)), 0.975);
  const Eigen::RowVector3d half =
      student / std::sqrt(n) *
      ((each.rowwise() - each.colwise().mean()).array().square().colwise().sum() / std::max(1.0, n - 1.0))
          .sqrt();
  const Eigen::RowVector3d least = each.colwise().minCoeff();
  std::ostringstream rows;
  rows << all.confusion;
  std::cerr << fmt::format(
      "{}: {} seeds pooled; +- of the mean over seeds (95 %): agreement {:.3f}, balanced {:.3f}, ari {:.3f}; "
      "worst "
      "seed {:.3f} {:.3f} {:.3f}\n  rows truth, columns rule ({}):\n{}\n",
      test_case, seeds.size(), half[0], half[1], half[2], least[0], least[1], least[2],
      fmt::join(motion::pattern_names(), " "), rows.str());
  print({kMotion, test_case, "agreement", all.share, "1"});
  print({kMotion, test_case, "balanced", all.balanced, "1"});
  print({kMotion, test_case, "ari", all.adjusted_rand, "1"});
  if (with_source) print({kMotion, test_case, "ari_source", source, "1"});
}

}  // namespace samara::benchmarks::motion_cases
