#include <algorithm>

#include <Eigen/LU>
#include <Eigen/QR>
#include <catch2/catch.hpp>

#include "samara/identification/fit/fit.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kTruth = 1.4;

/// What differs between and within captures.
struct Noise {
  double frame = 2e-3;  ///< m, independent from frame to frame
  double scale = 0.0;   ///< relative error of a capture's scale, common to its frames
  double k = 0.0;       ///< relative scatter of k between captures
};

std::vector<Capture> braked_captures(int count, const Noise& noise, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const std::vector<double> times = even_times(20, 1.5);
  std::vector<Capture> captures;
  for (int c = 0; c < count; ++c) {
    const double k = kTruth * (1.0 + noise.k * normal(random));
    const double v0 = 0.5 + 0.1 * c;
    Eigen::VectorXd x = BrakedFamily::depths(k, v0, times) * (1.0 + noise.scale * normal(random));
    captures.push_back(make_capture(fmt::format("{}", c), times, x.array() + 0.3 * normal(random)));
    add_noise(captures.back(), noise.frame, random);
  }
  return captures;
}

/// Root mean squares of (estimate - truth)/error over many seeds.
struct Pulls {
  double clustered = 0.0;
  double naive = 0.0;
};

Pulls pulls(const Noise& noise, const LossOptions& loss) {
  constexpr int kSeeds = 100;
  constexpr int kCaptures = 12;
  const BrakedFamily family;
  FitOptions options;
  options.loss = loss;
  options.starts.count = 1;
  Pulls sum;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    const FitResult result = fit(family, braked_captures(kCaptures, noise, random), options);
    REQUIRE(result.status == samara::Termination::converged);
    const Coefficient& k = result.coefficients[0];
    sum.clustered += std::pow((k.value - kTruth) / k.standard_error.value(), 2);
    sum.naive += std::pow((k.value - kTruth) / k.naive_standard_error.value(), 2);
  }
  return {std::sqrt(sum.clustered / kSeeds), std::sqrt(sum.naive / kSeeds)};
}

}  // namespace

// The root mean square of 100 pulls scatters by 7 %; twelve clusters make it sqrt(11/9) = 1.1 at best.

TEST_CASE("clustered and naive errors are about right for independent noise") {
  for (const LossKind kind : {LossKind::none, LossKind::huber, LossKind::cauchy}) {
    INFO(to_string(kind));
    const Pulls rms = pulls({}, {.kind = kind, .length_scale = 4e-3});
    INFO("clustered " << rms.clustered << ", naive " << rms.naive);
    CHECK(rms.clustered > 0.7);
    CHECK(rms.clustered < 1.4);
    CHECK(rms.naive > 0.8);
    CHECK(rms.naive < 1.25);
  }
}

TEST_CASE("clustered errors stay right, and naive ones do not, when captures differ as wholes") {
  const Pulls rms = pulls({.k = 0.1}, {.kind = LossKind::huber, .length_scale = 4e-3});
  INFO("clustered " << rms.clustered << ", naive " << rms.naive);
  CHECK(rms.clustered > 0.7);
  CHECK(rms.clustered < 1.4);
  CHECK(rms.naive > 2.0);
}

TEST_CASE("captures of one cluster count as one observation") {
  // Every capture twice: as clusters of two, the copies bring nothing; as captures, the error shrinks by
  // sqrt(2) but for what each cluster decides by itself, C/(C - 1) where all are alike.
  std::mt19937_64 random(11);
  const BrakedFamily family;
  const std::vector<Capture> once = braked_captures(10, {.k = 0.05}, random);
  std::vector<Capture> twice;
  for (const Capture& capture : once) {
    for (const char* camera : {"1", "2"}) {
      twice.push_back(capture);
      twice.back().id = fmt::format("{}/{}", capture.id, camera);
      twice.back().labels = {{"drop", capture.id}, {"cam", camera}};
    }
  }
  const FitResult single = fit(family, once);
  FitOptions by_drop;
  by_drop.uncertainty.cluster_by = {"drop"};
  const FitResult clustered = fit(family, twice, by_drop);
  const FitResult split = fit(family, twice);
  CHECK(clustered.clusters == 10);
  CHECK(split.clusters == 20);
  CHECK(clustered.captures[1].cluster == clustered.captures[0].cluster);
  CHECK_THAT(clustered.coefficients[0].value, WithinRel(single.coefficients[0].value, 1e-5));
  CHECK_THAT(*clustered.coefficients[0].standard_error,
             WithinRel(*single.coefficients[0].standard_error, 1e-5));
  CHECK_THAT(
      *split.coefficients[0].standard_error,
      WithinRel(*single.coefficients[0].standard_error * std::sqrt(20.0 / 19.0 / (10.0 / 9.0) / 2.0), 0.05));
}

TEST_CASE("naive errors of a plain fit are those of linear least squares") {
  // With k held, x = v0 b(t) + offset is linear: cov = s^2 (J^T J)^-1 for each capture.
  std::mt19937_64 random(17);
  const BrakedFamily family;
  const std::vector<Capture> captures = braked_captures(1, {}, random);
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.unknowns.fixed = {{"k", kTruth}};
  const FitResult result = fit(family, captures, options);
  REQUIRE(result.status == samara::Termination::converged);

  Eigen::MatrixXd J(20, 2);
  J.col(0) = BrakedFamily::depths(kTruth, 1.0, even_times(20, 1.5));
  J.col(1).setOnes();
  const Eigen::VectorXd measured = captures[0].channels[0].values;
  const Eigen::VectorXd solution = J.colPivHouseholderQr().solve(measured);
  const double variance = (J * solution - measured).squaredNorm() / 18.0;
  const Eigen::MatrixXd covariance = variance * (J.transpose() * J).inverse();
  for (Eigen::Index k = 0; k < 2; ++k) {
    const Nuisance& nuisance = result.captures[0].nuisances[static_cast<std::size_t>(k)];
    CHECK_THAT(nuisance.value, WithinRel(solution[k], 1e-8));
    CHECK_THAT(*nuisance.standard_error, WithinRel(std::sqrt(covariance(k, k)), 1e-6));
  }
}

TEST_CASE("eliminating the captures' own unknowns leaves the errors of the whole problem") {
  std::mt19937_64 random(23);
  const BrakedFamily family;
  const std::vector<Capture> captures = braked_captures(3, {}, random);
  FitOptions options;
  options.loss.kind = LossKind::none;
  const FitResult result = fit(family, captures, options);
  REQUIRE(result.status == samara::Termination::converged);

  // All unknowns at once: k, then v(0) and offset of each capture.
  const std::vector<double> times = even_times(20, 1.5);
  const double k = result.coefficients[0].value;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(60, 7);
  Eigen::VectorXd r(60);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(7, 3);
  for (Eigen::Index c = 0; c < 3; ++c) {
    const CaptureFit& capture = result.captures[static_cast<std::size_t>(c)];
    const double v0 = capture.nuisances[0].value;
    const double h = 1e-5;
    J.block(20 * c, 0, 20, 1) =
        (BrakedFamily::depths(k + h, v0, times) - BrakedFamily::depths(k - h, v0, times)) / (2.0 * h);
    J.block(20 * c, 1 + 2 * c, 20, 1) = BrakedFamily::depths(k, 1.0, times);
    J.block(20 * c, 2 + 2 * c, 20, 1).setOnes();
    r.segment(20 * c, 20) = capture.model.col(0) - capture.measured.col(0);
    scores.col(c) = J.middleRows(20 * c, 20).transpose() * r.segment(20 * c, 20);
  }
  const Eigen::MatrixXd inverse = (J.transpose() * J).inverse();
  const Eigen::MatrixXd naive = r.squaredNorm() / 53.0 * inverse;
  // Of the score of a capture in k the answer has taken its share of the information on k.
  Eigen::Vector3d information;
  for (Eigen::Index c = 0; c < 3; ++c) {
    const Eigen::VectorXd by_k = J.block(20 * c, 0, 20, 1);
    const Eigen::MatrixXd by_own = J.block(20 * c, 1 + 2 * c, 20, 2);
    information[c] = (by_k - by_own * by_own.colPivHouseholderQr().solve(by_k)).squaredNorm();
  }
  double clustered = 0.0;
  for (Eigen::Index c = 0; c < 3; ++c) {
    clustered += std::pow((inverse * scores.col(c))[0], 2) / (1.0 - information[c] / information.sum());
  }
  CHECK_THAT(*result.coefficients[0].naive_standard_error, WithinRel(std::sqrt(naive(0, 0)), 1e-5));
  CHECK_THAT(*result.coefficients[0].standard_error, WithinRel(std::sqrt(clustered), 1e-5));
  CHECK_THAT(*result.captures[1].nuisances[0].standard_error, WithinRel(std::sqrt(naive(3, 3)), 1e-5));
  CHECK_THAT(*result.captures[2].nuisances[1].standard_error, WithinRel(std::sqrt(naive(6, 6)), 1e-5));
}

namespace {

/// Standard deviation of k over fits to captures drawn with replacement, widened as clustered errors are.
double drawn_error(const std::vector<Capture>& captures, int repeats, std::mt19937_64& random) {
  std::uniform_int_distribution<std::size_t> which(0, captures.size() - 1);
  FitOptions options;
  options.starts.count = 1;
  Eigen::ArrayXd values(repeats);
  for (double& value : values) {
    std::vector<Capture> drawn;
    for (std::size_t c = 0; c < captures.size(); ++c) {
      drawn.push_back(captures[which(random)]);
      drawn.back().id = fmt::format("draw {}", c);
    }
    value = fit(BrakedFamily(), drawn, options).coefficients[0].value;
  }
  const auto C = static_cast<double>(captures.size());
  return std::sqrt(C / (C - 1.0) * (values - values.mean()).square().sum() / (repeats - 1));
}

}  // namespace

TEST_CASE("random weights give the errors of captures drawn with replacement, and clustered ones") {
  // 400 replicates tell a deviation to 3.5 %; beyond the first order in 1/sqrt(16) the three differ by a sixth (4,000
  // replicates: 0.0187 against 0.0161).
  constexpr int kReplicates = 400;
  std::mt19937_64 random(5);
  const std::vector<Capture> captures = braked_captures(16, {.k = 0.05}, random);
  FitOptions options;
  options.starts.count = 1;
  options.uncertainty.bootstrap.replicates = kReplicates;
  const FitResult result = fit(BrakedFamily(), captures, options);
  REQUIRE(result.bootstrap);
  CHECK(result.bootstrap->replicates == kReplicates);
  CHECK(result.bootstrap->coefficients.rows() == kReplicates);
  const double error = result.bootstrap->standard_errors.at(0);
  CHECK_THAT(error, WithinRel(*result.coefficients[0].standard_error, 0.2));
  CHECK_THAT(error, WithinRel(drawn_error(captures, kReplicates, random), 0.2));
  CHECK_THAT(result.bootstrap->coefficients.col(0).mean(), WithinRel(result.coefficients[0].value, 0.01));
}

TEST_CASE("random weights are those of clusters, and of a seed") {
  std::mt19937_64 random(6);
  std::vector<Capture> captures = braked_captures(6, {.k = 0.05}, random);
  for (std::size_t c = 0; c < captures.size(); ++c) captures[c].labels = {{"drop", fmt::format("{}", c / 2)}};
  FitOptions options;
  options.uncertainty.cluster_by = {"drop"};
  options.uncertainty.bootstrap.replicates = 5;
  const auto replicates = [&] { return fit(BrakedFamily(), captures, options).bootstrap->coefficients; };
  const Eigen::MatrixXd first = replicates();
  CHECK(replicates() == first);
  options.uncertainty.bootstrap.replicates = 40;
  CHECK(replicates().topRows(5) == first);
  options.uncertainty.bootstrap.replicates = 5;
  options.uncertainty.bootstrap.seed = 2;
  CHECK(replicates() != first);

  // One of two clusters repeats the other: no weights can tell them apart.
  captures.resize(2);
  captures[1] = captures[0];
  captures[1].id = "again";
  captures[1].labels = {{"drop", "another"}};
  const FitResult twins = fit(BrakedFamily(), captures, options);
  CHECK(twins.bootstrap->standard_errors[0] < 1e-6 * twins.coefficients[0].value);

  captures[1].labels = captures[0].labels;
  const FitResult single = fit(BrakedFamily(), captures, options);
  CHECK_FALSE(single.bootstrap);
  CHECK(single.warnings.has(WarningKind::errors, "the captures are one cluster"));
}

TEST_CASE("what only a prior holds scatters by its deviation over fits of random weights") {
  // 400 replicates tell a deviation to 3.5 %.
  constexpr double kDeviation = 0.05;
  const std::vector<double> times = even_times(9, 2.0);
  std::mt19937_64 random(9);
  std::vector<Capture> captures;
  for (const char* id : {"a", "b", "c"}) {
    captures.push_back(make_capture(id, times, BrakedFamily::depths(1.2, 1.1, times)));
    add_noise(captures.back(), 1e-3, random);
  }
  const auto error = [&](const FitOptions& options) {
    const FitResult result = fit(BrakedFamily(), captures, options);
    REQUIRE(result.bootstrap);
    return result.bootstrap->standard_errors.at(0);
  };
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.starts.count = 1;
  options.uncertainty.bootstrap.replicates = 400;
  // Residuals over 1 km say nothing.
  options.loss.length_scale = 1e3;
  options.priors.coordinates["k"] = {.mean = 1.2, .deviation = kDeviation};
  CHECK_THAT(error(options), WithinRel(kDeviation, 0.15));
  options.priors.coordinates["k"] = {.mean = 1.2, .deviation = kDeviation, .logarithmic = true};
  CHECK_THAT(error(options), WithinRel(1.2 * kDeviation, 0.15));
  options.priors.coordinates.clear();
  options.priors.combinations = {{.weights = {{"k", 2.0}}, .mean = 2.4, .deviation = 2.0 * kDeviation}};
  CHECK_THAT(error(options), WithinRel(kDeviation, 0.15));
}

TEST_CASE("a coefficient at a bound has no error from random weights") {
  std::mt19937_64 random(6);
  const std::vector<Capture> captures = braked_captures(4, {}, random);
  FitOptions options;
  options.starts.count = 1;
  options.uncertainty.bootstrap.replicates = 3;
  options.unknowns.box["k"] = {2.0, 3.0};
  const FitResult result = fit(BrakedFamily(), captures, options);
  REQUIRE(result.coefficients[0].at_bound);
  CHECK(std::isnan(result.bootstrap->standard_errors.at(0)));
}

TEST_CASE("fits of random weights that stop early are told of") {
  std::mt19937_64 random(6);
  const std::vector<Capture> captures = braked_captures(6, {.k = 0.2}, random);
  FitOptions options;
  options.starts.count = 1;
  options.uncertainty.bootstrap.replicates = 4;
  const FitResult whole = fit(BrakedFamily(), captures, options);
  CHECK(whole.bootstrap->converged == 4);
  options.solver.max_iterations = 1;
  const FitResult cut = fit(BrakedFamily(), captures, options);
  REQUIRE(cut.bootstrap->converged < 4);
  CHECK(cut.warnings.has(WarningKind::errors, "weighted at random did not converge within 1 iterations"));
}
