/// Errors from the scatter between clusters: by formulas where clusters are alike, by trials where they are
/// not.
#include "samara/identification/statistics/cluster_errors.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "samara/identification/fit/fit.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("clusters that are alike give C/(C - 1) times the scatter of their scores") {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const Eigen::Matrix2d H = (Eigen::Matrix2d() << 3.0, 1.0, 1.0, 2.0).finished();
  std::vector<ClusterTerms> clusters;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (int c = 0; c < 5; ++c) {
    clusters.push_back({H, Eigen::Vector2d(normal(random), normal(random))});
    scatter += clusters.back().score * clusters.back().score.transpose();
  }
  const ClusterErrors errors = cluster_errors(clusters, Eigen::Matrix2d::Zero());
  const Eigen::Matrix2d inverse = (5.0 * H).inverse();
  const Eigen::Matrix2d expected = 1.25 * inverse * scatter * inverse;
  CHECK((errors.covariance - expected).norm() < 1e-12 * expected.norm());
  CHECK((errors.shares.array() - 0.2).abs().maxCoeff() < 1e-12);
  CHECK_THAT(effective_clusters(errors.shares.row(0).transpose()), WithinRel(5.0, 1e-12));
}

namespace {

/// Eight clusters of y = X (b + d_c) + noise, d_c the cluster's own; of the second coefficient only the first
/// cluster says much.
struct Trial {
  double error_of_second = 0.0;  ///< of the estimate
  double plain = 0.0;            ///< standard error without correction
  double corrected = 0.0;
  double effective = 0.0;
};

Trial trial(std::mt19937_64& random) {
  constexpr int kClusters = 8, kRows = 12;
  std::normal_distribution<double> normal;
  std::vector<Eigen::MatrixX2d> X;
  std::vector<Eigen::VectorXd> y;
  Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (int c = 0; c < kClusters; ++c) {
    Eigen::MatrixX2d x(kRows, 2);
    for (int row = 0; row < kRows; ++row)
      x.row(row) << 1.0, c == 0 ? (row % 2 == 0 ? 1.0 : -1.0) : 0.12 * normal(random);
    const Eigen::Vector2d own(0.5 * normal(random), 0.5 * normal(random));
    Eigen::VectorXd values = x * own;
    for (double& value : values) value += 0.3 * normal(random);
    H += x.transpose() * x;
    right += x.transpose() * values;
    X.push_back(x);
    y.push_back(values);
  }
  const Eigen::Vector2d estimate = H.ldlt().solve(right);
  std::vector<ClusterTerms> clusters;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (int c = 0; c < kClusters; ++c) {
    const auto at = static_cast<std::size_t>(c);
    clusters.push_back({X[at].transpose() * X[at], X[at].transpose() * (X[at] * estimate - y[at])});
    scatter += clusters.back().score * clusters.back().score.transpose();
  }
  const Eigen::Matrix2d plain = 8.0 / 7.0 * H.inverse() * scatter * H.inverse();
  const ClusterErrors errors = cluster_errors(clusters, Eigen::Matrix2d::Zero());
  const double effective = effective_clusters(errors.shares.row(1).transpose());
  return {estimate[1], std::sqrt(plain(1, 1)), std::sqrt(errors.covariance(1, 1)), effective};
}

}  // namespace

TEST_CASE("the error of what one cluster carries covers the truth, as the plain one does not") {
  // 400 trials tell a share of a tenth to 1.5 %.
  constexpr int kTrials = 400;
  std::mt19937_64 random(12);
  int beyond_plain = 0, beyond = 0;
  for (int k = 0; k < kTrials; ++k) {
    const Trial one = trial(random);
    CHECK(one.effective < kFewClusters);
    beyond_plain += std::abs(one.error_of_second) > 2.0 * one.plain ? 1 : 0;
    // Student's quantile at 97.5 % for seven degrees of freedom, as a verdict has it.
    beyond += std::abs(one.error_of_second) > 2.365 * one.corrected ? 1 : 0;
  }
  INFO("beyond: plain " << beyond_plain << ", corrected " << beyond);
  CHECK(beyond_plain > 0.4 * kTrials);
  CHECK(beyond < 0.09 * kTrials);
}

namespace {

/// Six captures that brake; the first starts faster than its box allows.
std::vector<Capture> bounded_captures(std::mt19937_64& random) {
  const std::vector<double> times = even_times(20, 1.5);
  std::vector<Capture> captures;
  for (int c = 0; c < 6; ++c) {
    const double v = c == 0 ? 1.04 : 0.25 + 0.02 * c;
    captures.push_back(make_capture(fmt::format("{}", c), times, BrakedFamily::depths(1.4, v, times)));
    add_noise(captures.back(), 4e-3, random);
  }
  return captures;
}

}  // namespace

TEST_CASE("errors count that an initial value at its bound may be elsewhere") {
  // With its speed held at the bound the fastest capture says most of k, and says it wrong.
  constexpr int kSeeds = 60;
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.unknowns.box["v(0)"] = {0.2, 1.0};
  options.starts.count = 1;
  int bounded = 0, beyond = 0, beyond_held = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    const std::vector<Capture> captures = bounded_captures(random);
    const FitResult result = fit(BrakedFamily(), captures, options);
    const Coefficient& k = result.coefficients[0];
    bounded += result.captures[0].nuisances[0].at_bound ? 1 : 0;
    const double off = std::abs(k.value - 1.4);
    beyond += off > 2.0 * widened_error(result, k).value() ? 1 : 0;
    // As if the bound were known to be true: what the information at the answer, which holds it, says.
    const double naive_held = std::sqrt(2.0 * result.cost / (120.0 - 12.0) / result.information(0, 0));
    beyond_held += off > 2.0 * naive_held ? 1 : 0;
  }
  INFO("at the bound " << bounded << ", beyond " << beyond << ", held " << beyond_held);
  CHECK(bounded > 0.9 * kSeeds);
  CHECK(beyond_held > 0.3 * kSeeds);
  CHECK(beyond <= 0.1 * kSeeds);
}
