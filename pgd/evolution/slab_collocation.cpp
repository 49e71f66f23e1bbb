#include "samara/pgd/evolution/slab_collocation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/LU>

#include "samara/base/parallel.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/axes/lagrange.h"

namespace samara::pgd {

namespace {

constexpr Eigen::Index kChunk = 64;  ///< points that are iterated together: their states stay in the cache
constexpr int kMaxPicard = 30;
constexpr int kMaxNewton = 12;
/// Corrections that shrink by less than this from one iteration to the next are handed to Newton.
constexpr double kSlowest = 0.7;
/// Corrections larger than this many scales belong to no solution.
constexpr double kLargest = 1e8;

}  // namespace

SlabTime::SlabTime(int points) {
  const Axis axis = Axis::radau({"t", "1", AxisRole::time}, 0.0, 1.0, 1, points);
  nodes = axis.nodes();
  // On [-1, 1] the derivative of a polynomial that vanishes at the start; its inverse integrates.
  integration = 0.5 * axis.element_basis().differentiation().bottomRightCorner(points, points).inverse();
  at_halves.resize(2 * points, points + 1);
  Eigen::VectorXd row(points + 1);
  for (int i = 0; i < 2 * points; ++i) {
    const double place = 0.5 * nodes[1 + i % points] + (i < points ? 0.0 : 0.5);
    axis.element_basis().values(2.0 * place - 1.0, row);
    at_halves.row(i) = row;
  }
}

Eigen::MatrixXd collocation_matrix(const Eigen::MatrixXd& integration,
                                   const Eigen::Ref<const Eigen::MatrixXd>& jacobians) {
  const Eigen::Index s = integration.rows();
  const auto n = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(jacobians.rows()))));
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n * s, n * s);
  for (Eigen::Index j = 0; j < s; ++j) {
    const auto jacobian = jacobians.col(j).reshaped(n, n);
    for (Eigen::Index i = 0; i < s; ++i) matrix.block(i * n, j * n, n, n) -= integration(i, j) * jacobian;
  }
  return matrix;
}

int SlabPoints::first_failed() const {
  const auto it =
      std::find_if(status.begin(), status.end(), [](Termination s) { return s != Termination::converged; });
  return it == status.end() ? -1 : static_cast<int>(it - status.begin());
}

SlabCollocation::SlabCollocation(const EvolutionSystem& system, Eigen::VectorXd scales, int time_points)
    : system_(system), scales_(std::move(scales)), time_(time_points) {}

/// Points that are iterated together on one element. Columns p * s + i of `x` hold point p at Radau point i,
/// in SI units.
struct SlabCollocation::Chunk {
  Chunk(const Eigen::MatrixXd& all_q, SlabPoints& slab) : parameters(all_q), answer(slab) {}

  const Eigen::MatrixXd& parameters;  ///< of all points
  SlabPoints& answer;                 ///< values and status of all points; the sums below are its own
  int element = 0;
  double begin = 0.0, length = 0.0;
  Eigen::VectorXd t;
  Eigen::MatrixXd start, x, q, f;
  std::vector<int> point;          ///< which points are still iterated, as columns of the answer
  std::vector<double> correction;  ///< last one of every point
  std::vector<int> failed;         ///< points that Picard leaves to Newton
  long evaluations = 0, iterations = 0;
  double contraction = 0.0;
};

/// Fills the working matrices for the given points: their starts are where the element before has ended.
void SlabCollocation::load(Chunk& chunk, const std::vector<int>& points) const {
  const int s = time_.points();
  const auto count = static_cast<Eigen::Index>(points.size());
  chunk.point = points;
  chunk.t = (chunk.begin + chunk.length * time_.nodes.tail(s).array()).matrix().replicate(count, 1);
  chunk.start.resize(states(), count);
  chunk.x.resize(states(), count * s);
  chunk.q.resize(chunk.parameters.rows(), count * s);
  for (Eigen::Index p = 0; p < count; ++p) {
    const int point = points[static_cast<std::size_t>(p)];
    chunk.start.col(p) = scales_.cwiseProduct(
        chunk.answer.values.col(point).segment(Eigen::Index{states()} * s * chunk.element, states()));
    chunk.x.middleCols(p * s, s) = chunk.start.col(p).replicate(1, s);
    chunk.q.middleCols(p * s, s) = chunk.parameters.col(point).replicate(1, s);
  }
  chunk.correction.assign(points.size(), std::numeric_limits<double>::infinity());
}

/// The solution of a point at the Radau points of the present element.
void SlabCollocation::store(Chunk& chunk, int point, const Eigen::Ref<const Eigen::MatrixXd>& x) const {
  const int s = time_.points();
  const Eigen::Index first = Eigen::Index{states()} * (s * chunk.element + 1);
  chunk.answer.values.col(point).segment(first, Eigen::Index{states()} * s) =
      (scales_.cwiseInverse().asDiagonal() * x).reshaped();
  chunk.answer.status[static_cast<std::size_t>(point)] = Termination::converged;
}

void SlabCollocation::picard(Chunk& chunk, double tolerance) const {
  const int s = time_.points();
  const Eigen::Index n = states();
  const Eigen::MatrixXd integration = chunk.length * time_.integration.transpose();
  const Eigen::VectorXd weight = scales_.cwiseInverse();
  Eigen::MatrixXd next(n, s);
  for (int iteration = 0; iteration < kMaxPicard && !chunk.point.empty(); ++iteration) {
    const auto active = static_cast<Eigen::Index>(chunk.point.size());
    system_.rhs(chunk.t.head(active * s), chunk.x.leftCols(active * s), chunk.q.leftCols(active * s),
                chunk.f);
    chunk.evaluations += active * s;
    chunk.iterations += active;
    Eigen::Index kept = 0;
    for (Eigen::Index p = 0; p < active; ++p) {
      next.noalias() = chunk.f.middleCols(p * s, s) * integration;
      next.colwise() += chunk.start.col(p);
      const double correction =
          (weight.asDiagonal() * (next - chunk.x.middleCols(p * s, s))).cwiseAbs().maxCoeff();
      const auto column = chunk.point[static_cast<std::size_t>(p)];
      const double before = chunk.correction[static_cast<std::size_t>(p)];
      const double ratio = iteration > 0 ? correction / before : 1.0;
      const bool finite = std::isfinite(correction) && next.allFinite();
      if (finite && iteration > 0 && correction > tolerance)
        chunk.contraction = std::max(chunk.contraction, ratio);
      // What is left of a contracting iteration is about ratio / (1 - ratio) of its last correction. A state that stays
      // where it is has no ratio.
      if (finite && (correction == 0.0 || (ratio < 0.5 && correction * ratio <= 0.5 * tolerance))) {
        store(chunk, column, next);
        continue;
      }
      if (!finite || correction > kLargest || (iteration > 4 && ratio > kSlowest)) {
        chunk.failed.push_back(column);
        continue;
      }
      chunk.x.middleCols(kept * s, s) = next;
      if (kept != p) {
        chunk.start.col(kept) = chunk.start.col(p);
        chunk.q.middleCols(kept * s, s) = chunk.q.middleCols(p * s, s);
      }
      chunk.correction[static_cast<std::size_t>(kept)] = correction;
      chunk.point[static_cast<std::size_t>(kept++)] = column;
    }
    chunk.point.resize(static_cast<std::size_t>(kept));
  }
  chunk.failed.insert(chunk.failed.end(), chunk.point.begin(), chunk.point.end());
}

/// Newton's iteration of one point, whose start and parameters stand in the first columns of the chunk.
void SlabCollocation::newton(Chunk& chunk, double tolerance) const {
  const int s = time_.points();
  const Eigen::Index n = states();
  const Eigen::MatrixXd integration = chunk.length * time_.integration;
  const auto column = chunk.point.front();
  Termination& status = chunk.answer.status[static_cast<std::size_t>(column)];
  Eigen::MatrixXd x = chunk.start.col(0).replicate(1, s);
  Eigen::MatrixXd jacobians;
  status = Termination::no_contraction;
  for (int iteration = 0; iteration < kMaxNewton; ++iteration) {
    const auto t = chunk.t.head(s);
    const auto q = chunk.q.leftCols(s);
    system_.rhs(t, x, q, chunk.f);
    system_.jacobian(t, x, q, jacobians);
    chunk.evaluations += 2L * s;
    ++chunk.iterations;
    if (!chunk.f.leftCols(s).allFinite() || !jacobians.allFinite()) {
      status = Termination::not_finite;
      return;
    }
    Eigen::MatrixXd residual = chunk.f.leftCols(s) * integration.transpose() - x;
    residual.colwise() += chunk.start.col(0);
    const Eigen::VectorXd step =
        collocation_matrix(integration, jacobians).partialPivLu().solve(Eigen::VectorXd(residual.reshaped()));
    x += step.reshaped(n, s);
    const double correction =
        (scales_.cwiseInverse().asDiagonal() * step.reshaped(n, s)).cwiseAbs().maxCoeff();
    if (!(correction < kLargest)) {
      status = Termination::not_finite;
      return;
    }
    if (correction > tolerance) continue;
    store(chunk, column, x);
    return;
  }
}

/// Solves the element at the points loaded; those that have failed before are left alone.
void SlabCollocation::solve_element(Chunk& chunk, double tolerance) const {
  picard(chunk, tolerance);
  for (const int point : std::exchange(chunk.failed, {})) {
    load(chunk, {point});
    newton(chunk, tolerance);
  }
}

SlabPoints SlabCollocation::solve(const std::vector<double>& borders, const Eigen::MatrixXd& start,
                                  const Eigen::MatrixXd& q, double tolerance) const {
  const Eigen::Index points = start.cols();
  const auto elements = static_cast<int>(borders.size()) - 1;
  SlabPoints answer;
  answer.values = Eigen::MatrixXd::Constant(Eigen::Index{states()} * (elements * time_.points() + 1), points,
                                            std::numeric_limits<double>::quiet_NaN());
  answer.values.topRows(states()) = start;
  answer.status.assign(static_cast<std::size_t>(points), Termination::converged);
  const Eigen::Index chunks = (points + kChunk - 1) / kChunk;
  std::vector<Chunk> work(static_cast<std::size_t>(chunks), Chunk(q, answer));
  parallel_for(chunks, [&](Eigen::Index c) {
    Chunk& chunk = work[static_cast<std::size_t>(c)];
    for (int e = 0; e < elements; ++e) {
      std::vector<int> columns;
      for (Eigen::Index p = c * kChunk; p < std::min(points, (c + 1) * kChunk); ++p) {
        if (answer.status[static_cast<std::size_t>(p)] == Termination::converged)
          columns.push_back(static_cast<int>(p));
      }
      chunk.element = e;
      chunk.begin = borders[static_cast<std::size_t>(e)];
      chunk.length = borders[static_cast<std::size_t>(e) + 1] - chunk.begin;
      load(chunk, columns);
      solve_element(chunk, tolerance);
    }
  });
  for (const Chunk& chunk : work) {
    answer.evaluations += chunk.evaluations;
    answer.iterations += chunk.iterations;
    answer.contraction = std::max(answer.contraction, chunk.contraction);
  }
  return answer;
}

}  // namespace samara::pgd
