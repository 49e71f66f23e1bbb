#include "samara/codebooks/fields/direct_reference.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/integrators/linear_system.h"
#include "samara/pgd/linear/sparse_solver.h"

namespace samara::codebooks {

namespace {

using pgd::Axis;
using pgd::AxisRole;
using pgd::ModeOperator;
using pgd::ParametricProblem;
using pgd::SparseMatrix;
using Entries = std::vector<Eigen::Triplet<double>>;

SparseMatrix sparse_of(Eigen::Index rows, Eigen::Index columns, const Entries& entries) {
  SparseMatrix matrix(rows, columns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

SparseMatrix matrix_of(const ModeOperator& part, double scale) {
  Entries entries;
  part.add_to_triplets(entries, 0, 0, scale);
  return sparse_of(part.rows(), part.cols(), entries);
}

/// From nodal values to values at points of an axis: points x nodes.
SparseMatrix interpolation(const Axis& axis, std::span<const double> points) {
  Entries entries;
  pgd::InterpolationStencil stencil = axis.make_stencil();
  for (std::size_t i = 0; i < points.size(); ++i) {
    axis.interpolate(points[i], stencil, false);
    for (Eigen::Index j = 0; j < stencil.value.size(); ++j)
      entries.emplace_back(static_cast<int>(i), stencil.first + static_cast<int>(j), stencil.value[j]);
  }
  return sparse_of(static_cast<Eigen::Index>(points.size()), axis.size(), entries);
}

/// Rows and columns `nodes` of a square matrix.
SparseMatrix between(const SparseMatrix& matrix, const std::vector<int>& nodes) {
  std::vector<int> place(static_cast<std::size_t>(matrix.cols()), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    place[static_cast<std::size_t>(nodes[i])] = static_cast<int>(i);
  Entries inner;
  for (const int node : nodes) {
    for (SparseMatrix::InnerIterator entry(matrix, node); entry; ++entry) {
      const int row = place[static_cast<std::size_t>(entry.row())];
      if (row >= 0) inner.emplace_back(row, place[static_cast<std::size_t>(node)], entry.value());
    }
  }
  const auto size = static_cast<Eigen::Index>(nodes.size());
  return sparse_of(size, size, inner);
}

/// What a term does in time: a multiple of the derivative, or of the identity.
struct TimePart {
  bool is_derivative = false;
  double factor = 1.0;
};

std::optional<TimePart> time_part(const Axis& time, const ModeOperator& part) {
  const double rounding = 1e-12 * part.largest();
  if (part.structure() == ModeOperator::Structure::diagonal) {
    Eigen::VectorXd values = Eigen::VectorXd::Zero(time.size());
    part.add_to_diagonal(values, 1.0);
    if (values.maxCoeff() - values.minCoeff() > rounding) return {};
    return TimePart{false, values[0]};
  }
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(time.size(), time.size());
  part.add_to_dense(values, 1.0);
  const Eigen::MatrixXd constant = values(0, 0) * Eigen::MatrixXd::Identity(time.size(), time.size());
  if ((values - constant).cwiseAbs().maxCoeff() <= rounding) return TimePart{false, values(0, 0)};
  const Eigen::MatrixXd derivative = time.derivative();
  const double factor = values.cwiseProduct(derivative).sum() / derivative.squaredNorm();
  if ((values - factor * derivative).cwiseAbs().maxCoeff() > rounding) return {};
  return TimePart{true, factor};
}

std::size_t place_of(const ParametricProblem& problem, AxisRole role) {
  const auto place = std::ranges::find(problem.axes(), role, &Axis::role);
  return static_cast<std::size_t>(place - problem.axes().begin());
}

/// The terms of a tensor that has one mode.
Eigen::VectorXd sum_of(const pgd::SeparatedTensor& tensor) {
  return tensor.factors[0] * tensor.weights;
}

/// A u = b, without time.
Eigen::VectorXd steady_solution(const ParametricProblem& problem) {
  const Axis& space = problem.axes().front();
  SparseMatrix matrix(space.size(), space.size());
  for (const auto& term : problem.terms().terms) matrix += matrix_of(term.front(), 1.0);
  const Eigen::VectorXd lift = sum_of(problem.lift());
  const Eigen::VectorXd load = sum_of(problem.source()) - matrix * lift;
  const std::vector<int> unknown = problem.unknown_nodes(space.name());
  const SparseMatrix inner = between(matrix, unknown);
  const auto solver = pgd::make_sparse_solver(pgd::SparseSolverKind::automatic, inner);
  Eigen::VectorXd answer(inner.cols());
  if (!solver->factorize(inner) || !solver->solve(load(unknown), answer))
    throw NoResultError("the matrix of the problem is singular at this point");
  Eigen::VectorXd whole = lift;
  whole(unknown) += answer;
  return whole;
}

/// A tensor of space and time at one time: its modes in space, each by its value there.
struct LoadInTime {
  Eigen::MatrixXd in_space;  ///< unknown nodes x terms
  Eigen::MatrixXd in_time;   ///< nodes of time x terms, weights included

  Eigen::VectorXd at(int first, const Eigen::VectorXd& stencil) const {
    return in_space * (in_time.middleRows(first, stencil.size()).transpose() * stencil);
  }
};

/// M v' + K v = g - M l' - K l for what the lift l leaves of the solution, at one time after the other.
void transient_solution(const ParametricProblem& problem, const std::vector<double>& times,
                        const models::LinearIntegrationOptions& options, const FieldReference::Take& take) {
  const std::size_t t = place_of(problem, AxisRole::time), s = place_of(problem, AxisRole::space);
  const Axis &time = problem.axes()[t], &space = problem.axes()[s];
  SparseMatrix mass(space.size(), space.size()), stiffness = mass;
  for (const auto& term : problem.terms().terms) {
    const TimePart part = time_part(time, term[t]).value();
    (part.is_derivative ? mass : stiffness) += matrix_of(term[s], part.factor);
  }
  const std::vector<int> unknown = problem.unknown_nodes(space.name());
  const auto load_of = [&](const pgd::SeparatedTensor& tensor, const Eigen::MatrixXd& in_space) {
    return LoadInTime{in_space(unknown, Eigen::all), tensor.factors[t] * tensor.weights.asDiagonal()};
  };
  const pgd::SeparatedTensor& lift = problem.lift();
  const LoadInTime source = load_of(problem.source(), problem.source().factors[s]);
  const LoadInTime stiff_lift = load_of(lift, stiffness * lift.factors[s]);
  const LoadInTime mass_lift = load_of(lift, mass * lift.factors[s]);

  models::LinearSystem system{between(mass, unknown), between(stiffness, unknown), {}};
  pgd::InterpolationStencil stencil = time.make_stencil();
  system.load = [&](double now, Eigen::Ref<Eigen::VectorXd> load) {
    // The slope of the lift may jump at a border of elements: it is that of the element which holds the time.
    time.interpolate(now, stencil, true);
    load = source.at(stencil.first, stencil.value) - stiff_lift.at(stencil.first, stencil.value) -
           mass_lift.at(stencil.first, stencil.derivative);
  };
  // The solution is known at the beginning of the axis, wherever the times begin.
  std::vector<double> from_start = times;
  const std::size_t later = times.front() > time.lower() ? 1 : 0;
  if (later > 0) from_start.insert(from_start.begin(), time.lower());
  const Eigen::VectorXd start = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(unknown.size()));
  const LoadInTime whole_lift{lift.factors[s], lift.factors[t] * lift.weights.asDiagonal()};
  pgd::InterpolationStencil at_time = time.make_stencil();
  models::integrate_linear(system, start, from_start, options, [&](std::size_t i, const auto& rest) {
    if (i < later) return;
    time.interpolate(from_start[i], at_time, false);
    Eigen::VectorXd whole = whole_lift.at(at_time.first, at_time.value);
    whole(unknown) += rest;
    take(i - later, whole);
  });
}

void check_time(const ParametricProblem& problem) {
  const std::size_t t = place_of(problem, AxisRole::time);
  const Axis& time = problem.axes()[t];
  const std::vector<int> unknown = problem.unknown_nodes(time.name());
  if (static_cast<int>(unknown.size()) != time.size() - 1 || unknown.front() != 1) {
    throw ArgumentError(fmt::format(
        "on axis \"{}\" other nodes are known than the first, which alone was expected", time.name()));
  }
  bool has_derivative = false;
  for (const auto& term : problem.terms().terms) {
    const std::optional<TimePart> part = time_part(time, term[t]);
    if (!part) {
      throw ArgumentError(
          fmt::format("a term on axis \"{}\" is neither its derivative nor constant: a reference of the "
                      "problem's own was expected",
                      time.name()));
    }
    has_derivative = has_derivative || part->is_derivative;
  }
  if (!has_derivative)
    throw ArgumentError(fmt::format("no term has the derivative of axis \"{}\"", time.name()));
}

/// The problem, and what is known of it before the first point.
class DirectSolver {
 public:
  DirectSolver(ParametricProblem problem, double scale, double tolerance)
      : problem_(std::move(problem)),
        options_{.relative_tolerance = tolerance, .absolute_tolerance = 0.01 * tolerance * scale} {
    const auto count = [&](AxisRole role) { return std::ranges::count(problem_.axes(), role, &Axis::role); };
    if (count(AxisRole::space) != 1 || count(AxisRole::time) > 1) {
      throw ArgumentError(
          fmt::format("a problem with {} axes of space and {} of time is not solved point by point, expected "
                      "one of space and at "
                      "most one of time, or a reference of the problem's own",
                      count(AxisRole::space), count(AxisRole::time)));
    }
    has_time_ = count(AxisRole::time) == 1;
    std::vector<double> corner;
    for (const Axis& axis : problem_.axes()) {
      if (axis.role() == AxisRole::space || axis.role() == AxisRole::time) continue;
      parameters_.push_back(axis.name());
      corner.push_back(axis.lower());
    }
    // What is of another kind is found now, and not at the first point: by the terms as they were added, since one
    // may look constant where a parameter is zero.
    if (has_time_) check_time(problem_);
    static_cast<void>(at(corner));
  }

  bool has_time() const { return has_time_; }

  void operator()(std::span<const double> q, const std::vector<double>& times, const Eigen::VectorXd& places,
                  const FieldReference::Take& take) const {
    const ParametricProblem problem = at(q);
    if (has_time_) {
      const Axis& time = problem.axes()[place_of(problem, AxisRole::time)];
      if (times.empty() || !(times.front() >= time.lower())) {
        throw ArgumentError(fmt::format(
            "the first time asked of a reference is {}, expected one from {} on, where axis \"{}\" begins",
            times.empty() ? "none" : fmt::format("{}", times.front()), time.lower(), time.name()));
      }
    }
    const Axis& space = problem.axes()[place_of(problem, AxisRole::space)];
    const SparseMatrix between_nodes =
        interpolation(space, {places.data(), static_cast<std::size_t>(places.size())});
    const auto take_nodal = [&](std::size_t time, const auto& nodal) {
      const Eigen::VectorXd values = between_nodes * nodal;
      take(time, values);
    };
    if (has_time_) return transient_solution(problem, times, options_, take_nodal);
    take_nodal(0, steady_solution(problem));
  }

 private:
  ParametricProblem at(std::span<const double> q) const {
    std::map<std::string, double> point;
    for (std::size_t k = 0; k < parameters_.size(); ++k) point[parameters_[k]] = q[k];
    return problem_.at(point);
  }

  ParametricProblem problem_;
  models::LinearIntegrationOptions options_;
  std::vector<std::string> parameters_;
  bool has_time_ = false;
};

}  // namespace

FieldReference direct_reference(const pgd::ParametricProblem& problem, double scale, double tolerance) {
  require_positive(scale, "scale", "direct_reference");
  require_positive(tolerance, "tolerance", "direct_reference");
  const auto solver = std::make_shared<const DirectSolver>(problem, scale, tolerance);
  FieldReference reference;
  reference.time_by_time = [solver](std::span<const double> q, const std::vector<double>& times,
                                    const Eigen::VectorXd& places,
                                    const FieldReference::Take& take) { (*solver)(q, times, places, take); };
  reference.values = [solver](std::span<const double> q, const std::vector<double>& times,
                              const Eigen::VectorXd& places) {
    const auto rows = static_cast<Eigen::Index>(std::max<std::size_t>(1, times.size()));
    Eigen::MatrixXd all(rows, places.size());
    (*solver)(q, times, places, [&](std::size_t time, const auto& values) {
      all.row(static_cast<Eigen::Index>(time)) = values.transpose();
    });
    return all;
  };
  reference.name = solver->has_time() ? "CVODE (backward differentiation) on the nodes of space; it sees "
                                        "neither their error nor that of data "
                                        "between nodes of time and parameters"
                                      : "the direct solution on the nodes of space; it sees neither their "
                                        "error nor that of data between nodes "
                                        "of parameters";
  reference.tolerance = solver->has_time() ? tolerance : 0.0;
  return reference;
}

}  // namespace samara::codebooks
