#include "samara/motion/patterns/clusters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/limits.h"
#include "samara/base/require.h"
#include "samara/base/streams.h"

namespace samara::motion {

namespace {

void check_clustering(const Eigen::MatrixXd& points, const ClusterOptions& options) {
  require(options.clusters >= 1, "clusters", options.clusters, "at least 1");
  require(options.restarts >= 1, "restarts", options.restarts, "at least 1");
  require(options.max_iterations >= 1, "max_iterations", options.max_iterations, "at least 1");
  require(options.tolerance >= 0.0, "tolerance", options.tolerance, "a number from 0 on");
  if (!points.allFinite())
    throw ArgumentError("a point to be clustered is not finite; points that are were expected");
  if (const double most = points.size() > 0 ? points.cwiseAbs().maxCoeff() : 0.0; most > kLargestInput) {
    throw ArgumentError(fmt::format("a point to be clustered holds a number of size {}, expected at most {}",
                                    most, kLargestInput));
  }
  if (points.cols() < 1)
    throw ArgumentError("the points to be clustered have no feature, expected at least one");
  if (points.rows() < options.clusters) {
    throw ArgumentError(fmt::format("there are {} points for {} clusters, expected at least as many",
                                    points.rows(), options.clusters));
  }
}

/// Each next centre is a point drawn with the square of its distance to the centres so far.
Eigen::MatrixXd seeded_centres(const Eigen::MatrixXd& points, int clusters, Stream& stream) {
  Eigen::MatrixXd centres(clusters, points.cols());
  const auto draw = [&](double total, const Eigen::VectorXd& weights) {
    double left = stream.uniform() * total;
    for (Eigen::Index n = 0; n < weights.size(); ++n) {
      left -= weights[n];
      if (left < 0.0) return n;
    }
    return weights.size() - 1;
  };
  Eigen::VectorXd distances = Eigen::VectorXd::Ones(points.rows());
  for (int c = 0; c < clusters; ++c) {
    const double total = distances.sum();
    const Eigen::VectorXd weights = total > 0.0 ? distances : Eigen::VectorXd::Ones(points.rows()).eval();
    centres.row(c) = points.row(draw(weights.sum(), weights));
    const Eigen::VectorXd to_this = (points.rowwise() - centres.row(c)).rowwise().squaredNorm();
    distances = c == 0 ? to_this : distances.cwiseMin(to_this).eval();
  }
  return centres;
}

double assign(const Eigen::MatrixXd& points, const Eigen::MatrixXd& centres, std::vector<int>& assignment) {
  double sum = 0.0;
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    Eigen::Index nearest = 0;
    sum += (centres.rowwise() - points.row(n)).rowwise().squaredNorm().minCoeff(&nearest);
    assignment[static_cast<std::size_t>(n)] = static_cast<int>(nearest);
  }
  return sum;
}

/// A cluster without points keeps its centre.
void move_centres(const Eigen::MatrixXd& points, const std::vector<int>& assignment,
                  Eigen::MatrixXd& centres) {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(centres.rows(), centres.cols());
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(centres.rows());
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    sums.row(assignment[static_cast<std::size_t>(n)]) += points.row(n);
    counts[assignment[static_cast<std::size_t>(n)]] += 1.0;
  }
  for (Eigen::Index c = 0; c < centres.rows(); ++c) {
    if (counts[c] > 0.0) centres.row(c) = sums.row(c) / counts[c];
  }
}

bool has_settled(const std::vector<double>& history, double tolerance) {
  if (history.size() < 2) return false;
  const double last = history.back(), before = history[history.size() - 2];
  return std::abs(last - before) <= tolerance * std::max(std::abs(last), 1e-300);
}

std::string ending(bool converged, const std::vector<double>& history) {
  return converged ? fmt::format("settled after {} iterations", history.size())
                   : fmt::format("stopped after {} iterations", history.size());
}

Clusters one_k_means(const Eigen::MatrixXd& points, const ClusterOptions& options, std::uint64_t start) {
  Stream stream(options.seed, start);
  Clusters result;
  result.assignment.resize(static_cast<std::size_t>(points.rows()));
  result.centres = seeded_centres(points, options.clusters, stream);
  for (int iteration = 0; iteration < options.max_iterations && !result.converged; ++iteration) {
    result.objective = assign(points, result.centres, result.assignment);
    move_centres(points, result.assignment, result.centres);
    result.history.push_back(result.objective);
    result.converged = has_settled(result.history, options.tolerance);
  }
  result.message = ending(result.converged, result.history);
  return result;
}

/// The largest cluster becomes number 0; the message says how many have no points.
void number_by_size(Clusters& clusters) {
  const auto count = static_cast<std::size_t>(clusters.centres.rows());
  std::vector<int> sizes(count, 0), order(count), number(count);
  for (const int c : clusters.assignment) ++sizes[static_cast<std::size_t>(c)];
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::greater(), [&](int c) { return sizes[static_cast<std::size_t>(c)]; });
  for (std::size_t k = 0; k < count; ++k) number[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  for (int& c : clusters.assignment) c = number[static_cast<std::size_t>(c)];
  clusters.centres = clusters.centres(order, Eigen::all).eval();
  const auto empty = std::ranges::count(sizes, 0);
  if (empty > 0) clusters.message += fmt::format("; {} of {} clusters have no points", empty, count);
}

/// The mixture's parameters.
struct Mixture {
  Eigen::VectorXd weights;
  Eigen::MatrixXd means;  ///< components x columns
  std::vector<Eigen::MatrixXd> covariances;
};

/// Shares of points in components, points x components. @returns mean log-likelihood
double expect(const Eigen::MatrixXd& points, const Mixture& mixture, Eigen::MatrixXd& shares) {
  const double columns = static_cast<double>(points.cols());
  for (Eigen::Index c = 0; c < mixture.means.rows(); ++c) {
    const Eigen::LLT<Eigen::MatrixXd> factor(mixture.covariances[static_cast<std::size_t>(c)]);
    const Eigen::MatrixXd lower = factor.matrixL();
    const Eigen::MatrixXd centred = (points.rowwise() - mixture.means.row(c)).transpose();
    const Eigen::VectorXd squares =
        lower.triangularView<Eigen::Lower>().solve(centred).colwise().squaredNorm();
    const double log_size =
        lower.diagonal().array().log().sum() + 0.5 * columns * std::log(2.0 * std::numbers::pi);
    shares.col(c) = (std::log(mixture.weights[c]) - log_size) - 0.5 * squares.array();
  }
  double sum = 0.0;
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    const double most = shares.row(n).maxCoeff();
    shares.row(n) = (shares.row(n).array() - most).exp();
    const double total = shares.row(n).sum();
    shares.row(n) /= total;
    sum += most + std::log(total);
  }
  return sum / static_cast<double>(points.rows());
}

/// A component without points keeps its mean and covariance, and the weight of 1e-12 points.
void maximise(const Eigen::MatrixXd& points, const Eigen::MatrixXd& shares, double floor, Mixture& mixture) {
  constexpr double kLeastPoints = 1e-12;
  for (Eigen::Index c = 0; c < shares.cols(); ++c) {
    const double total = shares.col(c).sum();
    mixture.weights[c] = std::max(total, kLeastPoints) / static_cast<double>(points.rows());
    if (total <= kLeastPoints) continue;
    mixture.means.row(c) = shares.col(c).transpose() * points / total;
    const Eigen::MatrixXd centred = points.rowwise() - mixture.means.row(c);
    Eigen::MatrixXd& covariance = mixture.covariances[static_cast<std::size_t>(c)];
    covariance = centred.transpose() * shares.col(c).asDiagonal() * centred / total;
    covariance.diagonal().array() += floor;
  }
}

}  // namespace

Eigen::MatrixXd standardised(const Eigen::MatrixXd& points) {
  Eigen::MatrixXd scaled = points.rowwise() - points.colwise().mean();
  for (Eigen::Index c = 0; c < scaled.cols(); ++c) {
    const double deviation = std::sqrt(scaled.col(c).squaredNorm() / static_cast<double>(scaled.rows()));
    if (deviation > 0.0) scaled.col(c) /= deviation;
  }
  return scaled;
}

Clusters k_means(const Eigen::MatrixXd& points, const ClusterOptions& options) {
  check_clustering(points, options);
  Clusters best;
  for (int start = 0; start < options.restarts; ++start) {
    Clusters here = one_k_means(points, options, static_cast<std::uint64_t>(start));
    if (start == 0 || here.objective < best.objective) best = std::move(here);
  }
  number_by_size(best);
  return best;
}

Clusters gaussian_mixture(const Eigen::MatrixXd& points, const ClusterOptions& options) {
  check_clustering(points, options);
  const Eigen::MatrixXd centred = points.rowwise() - points.colwise().mean();
  const double floor = std::max(1e-6 * centred.squaredNorm() / static_cast<double>(points.size()),
                                std::numeric_limits<double>::min() * 1e10);
  Clusters best;
  for (int start = 0; start < options.restarts; ++start) {
    Clusters here = one_k_means(points, options, static_cast<std::uint64_t>(start));
    here.history.clear();
    here.converged = false;
    Eigen::MatrixXd shares = Eigen::MatrixXd::Zero(points.rows(), options.clusters);
    for (Eigen::Index n = 0; n < points.rows(); ++n)
      shares(n, here.assignment[static_cast<std::size_t>(n)]) = 1.0;
    Mixture mixture;
    mixture.weights.resize(options.clusters);
    mixture.means = here.centres;
    mixture.covariances.assign(static_cast<std::size_t>(options.clusters),
                               floor * Eigen::MatrixXd::Identity(points.cols(), points.cols()));
    for (int iteration = 0; iteration < options.max_iterations && !here.converged; ++iteration) {
      maximise(points, shares, floor, mixture);
      here.objective = expect(points, mixture, shares);
      here.history.push_back(here.objective);
      here.converged = has_settled(here.history, options.tolerance);
    }
    here.centres = mixture.means;
    here.message = ending(here.converged, here.history);
    for (Eigen::Index n = 0; n < points.rows(); ++n) {
      Eigen::Index most = 0;
      shares.row(n).maxCoeff(&most);
      here.assignment[static_cast<std::size_t>(n)] = static_cast<int>(most);
    }
    if (start == 0 || here.objective > best.objective) best = std::move(here);
  }
  number_by_size(best);
  return best;
}

}  // namespace samara::motion
