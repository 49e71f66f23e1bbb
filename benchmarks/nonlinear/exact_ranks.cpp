#include "exact_ranks.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>

#include "samara/models/batch/batch.h"
#include "samara/pgd/axes/axis.h"

namespace samara::benchmarks {

namespace {

constexpr int kNodes = 16;
constexpr int kTimes = 60;

/// A matrix as basis * rest, where as few columns as keep what is left out below `bound` in the Frobenius norm.
struct Cut {
  Eigen::MatrixXd basis, rest;
};

Cut cut(const Eigen::MatrixXd& matrix, double bound) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(matrix * matrix.transpose());
  const Eigen::VectorXd& values = spectrum.eigenvalues();  // ascending
  Eigen::Index left_out = 0;
  double sum = 0.0;
  while (left_out + 1 < values.size() && sum + std::max(values[left_out], 0.0) <= bound * bound)
    sum += std::max(values[left_out++], 0.0);
  Cut result{spectrum.eigenvectors().rightCols(values.size() - left_out), {}};
  result.rest = result.basis.transpose() * matrix;
  return result;
}

/// Columns (first axis, others) x rows become columns (others) x rows (rows, first axis).
Eigen::MatrixXd folded(const Eigen::MatrixXd& matrix) {
  const Eigen::Index rows = matrix.rows(), columns = matrix.cols() / kNodes;
  Eigen::MatrixXd next(rows * kNodes, columns);
  for (Eigen::Index i = 0; i < kNodes; ++i)
    next.middleRows(rows * i, rows) = matrix.middleCols(columns * i, columns);
  return next;
}

Eigen::MatrixXd unfolded(const Eigen::MatrixXd& matrix) {
  const Eigen::Index rows = matrix.rows() / kNodes, columns = matrix.cols();
  Eigen::MatrixXd before(rows, columns * kNodes);
  for (Eigen::Index i = 0; i < kNodes; ++i)
    before.middleCols(columns * i, columns) = matrix.middleRows(rows * i, rows);
  return before;
}

/// The largest rank of the train, and its largest error.
std::pair<Eigen::Index, double> train_svd(const Eigen::MatrixXd& matrix, double bound) {
  const Cut first = cut(matrix, bound);
  const Cut second = cut(folded(first.rest), bound);
  const Cut third = cut(folded(second.rest), bound);
  const Eigen::MatrixXd second_rest = unfolded(third.basis * third.rest);
  const Eigen::MatrixXd first_rest = unfolded(second.basis * second_rest);
  const Eigen::Index rank = std::max({first.basis.cols(), second.basis.cols(), third.basis.cols()});
  return {rank, (first.basis * first_rest - matrix).cwiseAbs().maxCoeff()};
}

}  // namespace

int exact_rank(const codebooks::Plan& plan, double error) {
  const models::ParametricModel model = plan.parametric_model();
  std::vector<Eigen::VectorXd> nodes;
  for (const codebooks::BoxEntry& entry : plan.box)
    nodes.push_back(pgd::Axis::chebyshev({entry.name}, entry.lower, entry.upper, kNodes).nodes());
  const Eigen::Index per_plane = kNodes * kNodes;
  Eigen::MatrixXd points(kNodes * per_plane, 3);
  for (Eigen::Index j = 0; j < points.rows(); ++j)
    points.row(j) << nodes[0][j / per_plane], nodes[1][j / kNodes % kNodes], nodes[2][j % kNodes];
  std::vector<double> times;
  for (int k = 1; k <= kTimes; ++k) times.push_back(plan.end * k / kTimes);
  const models::BatchTrajectories batch = models::integrate_batch(model, points, times, {.step = 2e-4});

  const auto outputs = static_cast<std::size_t>(batch.states.rows());
  Eigen::MatrixXd states = batch.states;
  for (std::size_t s = 0; s < outputs; ++s) {
    auto row = states.row(static_cast<Eigen::Index>(s));
    const auto floor = plan.absolute.find(model.model().info().states[s].name);
    const double range = row.maxCoeff() - row.minCoeff();
    row /= std::max(range, floor == plan.absolute.end() ? 0.0 : floor->second);
  }
  // Outputs and times x the axes, the last one fastest.
  const Eigen::MatrixXd matrix = states.reshaped(states.rows() * kTimes, points.rows());
  double bound = error * std::sqrt(static_cast<double>(matrix.size()));
  while (true) {
    const auto [rank, largest] = train_svd(matrix, bound);
    if (largest <= error) return static_cast<int>(rank);
    bound *= 0.8;
  }
}

}  // namespace samara::benchmarks
