#include "samara/identification/statistics/cluster_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace samara::identification {

namespace {

/// What is left of a leverage of one: a cluster alone decides, and nothing is known of its scatter.
constexpr double kLeastRest = 1e-6;

/// (1 - M)^-1/2 u
Eigen::VectorXd corrected(const Eigen::MatrixXd& leverage, const Eigen::VectorXd& u) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(leverage);
  const Eigen::VectorXd rest = (1.0 - eigen.eigenvalues().array()).max(kLeastRest).sqrt();
  return eigen.eigenvectors() * (eigen.eigenvectors().transpose() * u).cwiseQuotient(rest);
}

}  // namespace

double effective_clusters(const Eigen::VectorXd& shares) {
  const double sum = shares.sum();
  return sum > 0.0 ? sum * sum / shares.squaredNorm() : 0.0;
}

double error_degrees(double effective_clusters, int clusters) {
  const bool is_pooled = clusters > 2 && effective_clusters < kFewClusters;
  return std::max(1.0, (is_pooled ? clusters : effective_clusters) - 1.0);
}

ClusterErrors cluster_errors(const std::vector<ClusterTerms>& clusters, const Eigen::MatrixXd& priors) {
  const Eigen::Index n = priors.rows();
  const auto count = static_cast<Eigen::Index>(clusters.size());
  ClusterErrors result;
  result.shares.setZero(n, count);
  result.covariance.setConstant(n, n, std::numeric_limits<double>::quiet_NaN());
  Eigen::MatrixXd hessian = priors;
  for (const ClusterTerms& cluster : clusters) hessian += cluster.hessian;
  const Eigen::LLT<Eigen::MatrixXd> factor(hessian);
  if (n == 0 || factor.info() != Eigen::Success) return result;
  const auto L = factor.matrixL();
  // L^-1 A L^-T
  const auto whitened = [&](const Eigen::MatrixXd& A) -> Eigen::MatrixXd {
    return L.solve(L.solve(A).transpose());
  };
  const Eigen::MatrixXd back = L.solve(Eigen::MatrixXd::Identity(n, n)).transpose();  // L^-T
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd leverages = scatter;
  for (Eigen::Index c = 0; c < count; ++c) {
    const ClusterTerms& cluster = clusters[static_cast<std::size_t>(c)];
    const Eigen::MatrixXd leverage = whitened(cluster.hessian);
    const Eigen::VectorXd v = corrected(leverage, L.solve(cluster.score));
    scatter += v * v.transpose();
    leverages += leverage;
    const Eigen::VectorXd information = (back * leverage).cwiseProduct(back).rowwise().sum();
    result.shares.col(c) = information.cwiseQuotient(back.rowwise().squaredNorm()).cwiseMax(0.0);
  }
  const Eigen::MatrixXd of_priors = back * whitened(priors) * back.transpose();
  result.covariance = back * scatter * back.transpose() + of_priors;
  const double phi = scatter.trace() / std::max(leverages.trace(), std::numeric_limits<double>::min());
  const Eigen::MatrixXd pooled = phi * (back * leverages * back.transpose()) + of_priors;
  Eigen::VectorXd widening = Eigen::VectorXd::Ones(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double few = effective_clusters(result.shares.row(k).transpose());
    const double variance = result.covariance(k, k);
    if (count <= 2 || few >= kFewClusters || !(pooled(k, k) > variance && variance > 0.0)) continue;
    widening[k] = std::sqrt(pooled(k, k) / variance);
  }
  result.covariance = widening.asDiagonal() * result.covariance * widening.asDiagonal();
  return result;
}

}  // namespace samara::identification
