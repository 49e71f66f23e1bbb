#include "samara/identification/statistics/chains.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace samara::identification {

namespace {

/// Mean over the chains of sum_i (x_i - mean)(x_{i + lag} - mean) / n. @param centred draws x chains
double autocovariance(const Eigen::MatrixXd& centred, Eigen::Index lag) {
  const Eigen::Index n = centred.rows();
  return centred.topRows(n - lag).cwiseProduct(centred.bottomRows(n - lag)).sum() /
         static_cast<double>(n * centred.cols());
}

}  // namespace

ChainSummary summarize_chains(const Eigen::MatrixXd& draws) {
  const Eigen::Index n = draws.rows() / 2;
  Eigen::MatrixXd halves(n, 2 * draws.cols());
  halves << draws.topRows(n), draws.bottomRows(n);
  const Eigen::RowVectorXd means = halves.colwise().mean();
  const Eigen::MatrixXd centred = halves.rowwise() - means;
  const auto chains = static_cast<double>(halves.cols());
  const auto length = static_cast<double>(n);
  const double within = centred.squaredNorm() / (chains * (length - 1.0));
  const double between = (means.array() - means.mean()).square().sum() / (chains - 1.0);
  const double all = (length - 1.0) / length * within + between;
  if (!(within > 0.0)) return {std::numeric_limits<double>::infinity(), 0.0};
  // Sums of neighbouring correlations fall and are positive (C. J. Geyer, Statist. Sci. 7 (1992) 473-483): where they
  // do not, noise begins.
  double sum = 0.0, last = std::numeric_limits<double>::infinity();
  for (Eigen::Index lag = 0; lag + 1 < n; lag += 2) {
    const auto correlation = [&](Eigen::Index k) {
      return 1.0 - (within - autocovariance(centred, k) * length / (length - 1.0)) / all;
    };
    const double pair = std::min(correlation(lag) + correlation(lag + 1), last);
    if (pair <= 0.0) break;
    sum += pair;
    last = pair;
  }
  const double total = chains * length;
  // At most as much more than the draws as their number can tell.
  const double time = std::max(2.0 * sum - 1.0, 1.0 / std::log10(std::max(total, 10.0)));
  return {std::sqrt(all / within), total / time};
}

}  // namespace samara::identification
