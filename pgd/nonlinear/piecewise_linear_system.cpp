#include "samara/pgd/nonlinear/piecewise_linear_system.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/slab_collocation.h"
#include "samara/pgd/nonlinear/strategy_slab.h"

namespace samara::pgd {

namespace {

constexpr std::size_t kMostAxesWithCorners = 7;
/// Training states whose Jacobians tell which states f depends on.
constexpr Eigen::Index kDependenceSamples = 32;
/// Of the size of a parameter: the step of the slopes of an f that is not affine in it.
constexpr double kDifferenceShare = 1e-3;
/// Weights are exp(-beta (d_i^2 - d_min^2) / fill^2), normalised: d_i the distance to point i, states over
/// their spread, fill the largest distance of a training state to its nearest point.
constexpr double kBeta = 10.0;

/// Corners of the box, and its middle.
Eigen::MatrixXd training_parameters(const std::vector<Axis>& axes) {
  const Eigen::MatrixXd corners = corner_points(axes, kMostAxesWithCorners);
  Eigen::MatrixXd q(corners.rows(), corners.cols() + 1);
  q.leftCols(corners.cols()) = corners;
  for (std::size_t k = 0; k < axes.size(); ++k)
    q(static_cast<Eigen::Index>(k), corners.cols()) = 0.5 * (axes[k].lower() + axes[k].upper());
  return q;
}

/// Of every parameter: its range among training states; if it has none, its value; 1 only at 0.
Eigen::VectorXd sizes_of(const Eigen::MatrixXd& q) {
  Eigen::VectorXd sizes = q.rowwise().maxCoeff() - q.rowwise().minCoeff();
  for (Eigen::Index k = 0; k < sizes.size(); ++k) {
    if (sizes[k] == 0.0) sizes[k] = std::abs(q(k, 0));
    if (sizes[k] == 0.0) sizes[k] = 1.0;
  }
  return sizes;
}

}  // namespace

TrainingStates train_along(const EvolutionProblem& problem, int samples, double tolerance,
                           long& evaluations) {
  const Eigen::VectorXd scales = Eigen::Map<const Eigen::VectorXd>(
      problem.scales.data(), static_cast<Eigen::Index>(problem.scales.size()));
  const SlabCollocation collocation(*problem.system, scales, problem.time.degree());
  const Eigen::Index n = scales.size();
  const int s = problem.time.degree();
  Eigen::MatrixXd q = training_parameters(problem.parameters);
  Eigen::MatrixXd x(n, q.cols());
  for (Eigen::Index j = 0; j < q.cols(); ++j) {
    for (Eigen::Index m = 0; m < n; ++m) {
      const InitialValue& initial = problem.initial[static_cast<std::size_t>(m)];
      x(m, j) = (initial.axis < 0 ? initial.value : q(initial.axis, j)) / scales[m];
    }
  }
  std::vector<double> t;
  std::vector<Eigen::VectorXd> states, parameters;
  const Eigen::VectorXd& borders = problem.time.borders();
  for (int part = 0; part < problem.time.elements() * samples && q.cols() > 0; ++part) {
    const double length = (borders[part / samples + 1] - borders[part / samples]) / samples;
    const double begin = borders[part / samples] + length * (part % samples);
    const SlabPoints solved = collocation.solve({begin, begin + length}, x, q, tolerance);
    evaluations += solved.evaluations;
    std::vector<int> alive;
    for (Eigen::Index j = 0; j < q.cols(); ++j) {
      if (solved.status[static_cast<std::size_t>(j)] != Termination::converged) continue;
      alive.push_back(static_cast<int>(j));
      for (int i = part == 0 ? 0 : 1; i <= s; ++i) {
        t.push_back(begin + length * collocation.time().nodes[i]);
        states.emplace_back(scales.cwiseProduct(solved.values.col(j).segment(n * i, n)));
        parameters.emplace_back(q.col(j));
      }
    }
    x = solved.values(Eigen::all, alive).bottomRows(n).eval();
    q = q(Eigen::all, alive).eval();
  }
  TrainingStates result;
  const auto count = static_cast<Eigen::Index>(t.size());
  result.t = Eigen::Map<const Eigen::VectorXd>(t.data(), count);
  result.x.resize(n, count);
  result.q.resize(q.rows(), count);
  for (Eigen::Index j = 0; j < count; ++j) {
    result.x.col(j) = states[static_cast<std::size_t>(j)];
    result.q.col(j) = parameters[static_cast<std::size_t>(j)];
  }
  return result;
}

PiecewiseLinearSystem::PiecewiseLinearSystem(const EvolutionSystem& system, const TrainingStates& training,
                                             int points) {
  require(points >= 1, "points", points, "1 or more", "PiecewiseLinearSystem");
  if (training.x.cols() < points) {
    throw ArgumentError(
        fmt::format("PiecewiseLinearSystem: {} points of {} training states, expected no more points", points,
                    training.x.cols()));
  }
  const std::vector<Eigen::Index> picked = pick(system, training, points);
  sharpness_ *= kBeta;
  linearise(system, {training.t(picked), training.x(Eigen::all, picked), training.q(Eigen::all, picked)},
            sizes_of(training.q));
}

std::vector<Eigen::Index> PiecewiseLinearSystem::pick(const EvolutionSystem& system,
                                                      const TrainingStates& training, int points) {
  const Eigen::Index n = training.x.rows();
  const Eigen::VectorXd mean = training.x.rowwise().mean();
  const Eigen::VectorXd spread = (training.x.colwise() - mean).cwiseAbs2().rowwise().mean().cwiseSqrt();
  std::vector<Eigen::Index> samples;
  const Eigen::Index stride = std::max<Eigen::Index>(1, training.x.cols() / kDependenceSamples);
  for (Eigen::Index j = 0; j < training.x.cols(); j += stride) samples.push_back(j);
  Eigen::MatrixXd jacobians;
  system.jacobian(training.t(samples), training.x(Eigen::all, samples), training.q(Eigen::all, samples),
                  jacobians);
  jacobian_evaluations_ += static_cast<long>(samples.size());
  inverse_spread_ = Eigen::VectorXd::Zero(n);
  for (Eigen::Index m = 0; m < n; ++m) {
    const bool matters = jacobians.middleRows(n * m, n).cwiseAbs().maxCoeff() > 0.0;
    if (matters && spread[m] > 0.0) inverse_spread_[m] = 1.0 / spread[m];
  }
  const Eigen::MatrixXd scaled = inverse_spread_.asDiagonal() * training.x;
  std::vector<Eigen::Index> picked = {0};
  Eigen::RowVectorXd nearest = (scaled.colwise() - scaled.col(0)).colwise().squaredNorm();
  while (static_cast<int>(picked.size()) < points) {
    Eigen::Index farthest = 0;
    nearest.maxCoeff(&farthest);
    picked.push_back(farthest);
    nearest = nearest.cwiseMin((scaled.colwise() - scaled.col(farthest)).colwise().squaredNorm());
  }
  sharpness_ = 1.0 / std::max(nearest.maxCoeff(), 1e-300);
  return picked;
}

void PiecewiseLinearSystem::linearise(const EvolutionSystem& system, const TrainingStates& points,
                                      const Eigen::VectorXd& sizes) {
  const Eigen::Index n = points.x.rows();
  const Eigen::Index d = points.q.rows();
  centres_ = points.x;
  Eigen::MatrixXd f, jacobians;
  system.rhs(points.t, points.x, points.q, f);
  system.jacobian(points.t, points.x, points.q, jacobians);
  std::vector<Eigen::MatrixXd> f_slopes, jacobian_slopes;
  const bool affine = system.affine_in_parameters();
  for (Eigen::Index k = 0; k < d; ++k) {
    const double step = (affine ? 1.0 : kDifferenceShare) * sizes[k];
    Eigen::MatrixXd q = points.q;
    q.row(k).array() += step;
    Eigen::MatrixXd above, below = f, jacobians_above = jacobians;
    system.rhs(points.t, points.x, q, above);
    if (affine) {
      system.jacobian(points.t, points.x, q, jacobians_above);
    } else {
      q.row(k).array() -= 2.0 * step;
      system.rhs(points.t, points.x, q, below);
    }
    f_slopes.emplace_back((above - below) / (affine ? step : 2.0 * step));
    jacobian_slopes.emplace_back((jacobians_above - jacobians) / step);
  }
  rhs_evaluations_ += (1 + (affine ? d : 2 * d)) * points.x.cols();
  jacobian_evaluations_ += (1 + (affine ? d : 0)) * points.x.cols();
  // The values at q = 0, by going back along the slopes.
  for (Eigen::Index k = 0; k < d; ++k) {
    const auto slope = static_cast<std::size_t>(k);
    f -= f_slopes[slope] * points.q.row(k).asDiagonal();
    jacobians -= jacobian_slopes[slope] * points.q.row(k).asDiagonal();
  }
  f_slopes.insert(f_slopes.begin(), f);
  jacobian_slopes.insert(jacobian_slopes.begin(), jacobians);
  jacobians_ = std::move(jacobian_slopes);
  sources_ = std::move(f_slopes);
  for (std::size_t k = 0; k < sources_.size(); ++k) {
    for (Eigen::Index i = 0; i < centres_.cols(); ++i)
      sources_[k].col(i) -= jacobians_[k].col(i).reshaped(n, n) * centres_.col(i);
  }
}

Eigen::MatrixXd PiecewiseLinearSystem::weights(const Eigen::MatrixXd& x) const {
  const Eigen::MatrixXd centres = inverse_spread_.asDiagonal() * centres_;
  Eigen::MatrixXd result(centres.cols(), x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    const Eigen::VectorXd here = inverse_spread_.cwiseProduct(x.col(j));
    const Eigen::VectorXd distances = (centres.colwise() - here).colwise().squaredNorm().transpose();
    result.col(j) = (-sharpness_ * (distances.array() - distances.minCoeff())).exp();
    result.col(j) /= result.col(j).sum();
  }
  return result;
}

void PiecewiseLinearSystem::rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                                Eigen::MatrixXd& f) const {
  const Eigen::Index n = x.rows();
  const Eigen::MatrixXd weight = weights(x);
  Eigen::MatrixXd jacobians;
  jacobian(t, x, q, jacobians);
  f = sources_[0] * weight;
  for (std::size_t k = 1; k < sources_.size(); ++k)
    f += sources_[k] * weight * q.row(static_cast<Eigen::Index>(k) - 1).asDiagonal();
  for (Eigen::Index j = 0; j < x.cols(); ++j) f.col(j) += jacobians.col(j).reshaped(n, n) * x.col(j);
}

void PiecewiseLinearSystem::jacobian(const Eigen::VectorXd&, const Eigen::MatrixXd& x,
                                     const Eigen::MatrixXd& q, Eigen::MatrixXd& jacobian) const {
  const Eigen::MatrixXd weight = weights(x);
  jacobian = jacobians_[0] * weight;
  for (std::size_t k = 1; k < jacobians_.size(); ++k)
    jacobian += jacobians_[k] * weight * q.row(static_cast<Eigen::Index>(k) - 1).asDiagonal();
}

}  // namespace samara::pgd
