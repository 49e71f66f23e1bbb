#include "samara/pgd/linear/parametric_problem.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/linear/mode_system.h"

namespace samara::pgd {

namespace {

/// Rows and columns `nodes` of a square matrix.
SparseMatrix restricted(const SparseMatrix& matrix, const std::vector<int>& nodes) {
  std::vector<int> place(static_cast<std::size_t>(matrix.rows()), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    place[static_cast<std::size_t>(nodes[i])] = static_cast<int>(i);
  std::vector<Eigen::Triplet<double>> inner;
  for (const int node : nodes) {
    for (SparseMatrix::InnerIterator it(matrix, node); it; ++it) {
      const int row = place[static_cast<std::size_t>(it.row())];
      if (row >= 0) inner.emplace_back(row, place[static_cast<std::size_t>(node)], it.value());
    }
  }
  const auto kept = static_cast<Eigen::Index>(nodes.size());
  SparseMatrix result(kept, kept);
  result.setFromTriplets(inner.begin(), inner.end());
  return result;
}

/// The same of an operator.
ModeOperator restricted(const ModeOperator& part, const std::vector<int>& nodes) {
  const int n = part.rows();
  const int kept = static_cast<int>(nodes.size());
  if (kept == n) return part;
  if (part.structure() == ModeOperator::Structure::dense) {
    const Eigen::MatrixXd whole = part.apply(Eigen::MatrixXd::Identity(n, n));
    return ModeOperator::dense(whole(nodes, nodes));
  }
  if (part.structure() == ModeOperator::Structure::diagonal) {
    Eigen::VectorXd values = Eigen::VectorXd::Zero(n);
    part.add_to_diagonal(values, 1.0);
    return ModeOperator::diagonal(values(nodes));
  }
  return ModeOperator::sparse(restricted(sparse_sum({part}, Eigen::VectorXd::Ones(1)), nodes));
}

std::vector<std::string> names_of(const std::vector<Axis>& axes) {
  std::vector<std::string> names;
  for (const Axis& axis : axes) names.push_back(axis.name());
  return names;
}

void check_size(const Axis& axis, Eigen::Index size, const char* what) {
  if (size == axis.size()) return;
  throw ArgumentError(
      fmt::format("a {} on axis \"{}\" has size {}, expected {}", what, axis.name(), size, axis.size()));
}

void check_finite(const Axis& axis, bool is_finite, const char* what) {
  if (is_finite) return;
  throw ArgumentError(fmt::format("a {} on axis \"{}\" has an entry that is not finite", what, axis.name()));
}

void check_part(const Axis& axis, const ModeOperator& part, const char* what) {
  check_size(axis, part.rows(), what);
  check_size(axis, part.cols(), what);
  check_finite(axis, part.all_finite(), what);
}

void check_part(const Axis& axis, const Eigen::VectorXd& part, const char* what) {
  check_size(axis, part.size(), what);
  check_finite(axis, part.allFinite(), what);
}

/// The numbers of a part that multiplies nodal values one by one.
Eigen::VectorXd diagonal_of(const Axis& axis, const ModeOperator& part) {
  if (part.structure() != ModeOperator::Structure::diagonal)
    throw ArgumentError(fmt::format(
        "a term on axis \"{}\" is no diagonal: it has no value at one point of the axis", axis.name()));
  Eigen::VectorXd values = Eigen::VectorXd::Zero(axis.size());
  part.add_to_diagonal(values, 1.0);
  return values;
}

void check_scale(double scale, const char* what) {
  if (!std::isfinite(scale))
    throw ArgumentError(fmt::format("the scale of a {} is {}, expected a finite number", what, scale));
}

}  // namespace

ParametricProblem::ParametricProblem(std::vector<Axis> axes)
    : axes_(std::move(axes)),
      rhs_(SeparatedTensor::zero(sizes_of(axes_))),
      lift_(rhs_),
      known_(axes_.size()),
      norms_(axes_.size()) {
  if (axes_.empty()) throw ArgumentError("a parametric problem has no axes, expected at least one");
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    if (position(axes_[k].name()) != k)
      throw ArgumentError(fmt::format("two axes have the name \"{}\"", axes_[k].name()));
  }
}

std::size_t ParametricProblem::position(const std::string& axis) const {
  const std::vector<std::string> names = names_of(axes_);
  const auto it = std::find(names.begin(), names.end(), axis);
  if (it == names.end())
    throw ArgumentError(fmt::format("there is no axis \"{}\"{}", axis, suggestion(axis, names)));
  return static_cast<std::size_t>(it - names.begin());
}

void ParametricProblem::add_term(const std::map<std::string, ModeOperator>& parts, double scale) {
  check_scale(scale, "term");
  for (const auto& [name, part] : parts) check_part(axes_[position(name)], part, "term");
  std::vector<ModeOperator> term;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const auto given = parts.find(axes_[k].name());
    ModeOperator part = given != parts.end() ? given->second
                        : is_weak(k)         ? ModeOperator::sparse(axes_[k].mass())
                                             : ModeOperator::identity(axes_[k].size());
    // The scale goes to one mode; on a nodal one it leaves the parts of weak axes equal from term to term.
    if (k + 1 == axes_.size() && scale != 1.0)
      part = part.row_scaled(Eigen::VectorXd::Constant(part.rows(), scale));
    term.push_back(std::move(part));
  }
  op_.terms.push_back(std::move(term));
}

void ParametricProblem::add_source(const std::map<std::string, Eigen::VectorXd>& parts, double scale) {
  check_scale(scale, "source");
  for (const auto& [name, part] : parts) check_part(axes_[position(name)], part, "source");
  std::vector<Eigen::VectorXd> columns;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const auto given = parts.find(axes_[k].name());
    columns.push_back(given != parts.end() ? given->second
                      : is_weak(k)         ? axes_[k].weights()
                                           : Eigen::VectorXd::Ones(axes_[k].size()));
  }
  rhs_.append(SeparatedTensor::product(std::move(columns)), scale);
}

void ParametricProblem::know(const std::string& axis, std::vector<int> nodes) {
  const std::size_t k = position(axis);
  for (const int node : nodes) {
    if (node < 0 || node >= axes_[k].size()) {
      throw ArgumentError(
          fmt::format("axis \"{}\" has no node {}, expected 0 to {}", axis, node, axes_[k].size() - 1));
    }
    known_[k].push_back(node);
  }
}

void ParametricProblem::measure(const std::string& axis, const SparseMatrix& norm) {
  const std::size_t k = position(axis);
  check_part(axes_[k], ModeOperator::sparse(norm), "norm");
  norms_[k] = norm;
}

void ParametricProblem::add_to_lift(const std::map<std::string, Eigen::VectorXd>& values, double scale) {
  check_scale(scale, "lift");
  for (const auto& [name, part] : values) check_part(axes_[position(name)], part, "lift");
  std::vector<Eigen::VectorXd> columns;
  for (const Axis& axis : axes_) {
    const auto given = values.find(axis.name());
    columns.push_back(given != values.end() ? given->second : Eigen::VectorXd::Ones(axis.size()));
  }
  lift_.append(SeparatedTensor::product(std::move(columns)), scale);
}

std::vector<int> ParametricProblem::unknown_nodes(std::size_t k) const {
  std::vector<bool> is_known(static_cast<std::size_t>(axes_[k].size()), false);
  for (const int node : known_[k]) is_known[static_cast<std::size_t>(node)] = true;
  std::vector<int> nodes;
  for (int i = 0; i < axes_[k].size(); ++i) {
    if (!is_known[static_cast<std::size_t>(i)]) nodes.push_back(i);
  }
  if (nodes.empty())
    throw ArgumentError(
        fmt::format("all nodes of axis \"{}\" are known: nothing is left to solve for", axes_[k].name()));
  return nodes;
}

ParametricProblem ParametricProblem::at(const std::map<std::string, double>& point) const {
  std::vector<Eigen::VectorXd> weights(axes_.size());  // of interpolation; empty: the axis is left
  for (const auto& [name, x] : point) weights[position(name)] = interpolation_weights(position(name), x);
  std::vector<Axis> rest;
  for (std::size_t k = 0; k < axes_.size(); ++k)
    if (weights[k].size() == 0) rest.push_back(axes_[k]);
  if (rest.empty()) throw ArgumentError("a parametric problem at a point of all its axes: one must be left");
  ParametricProblem result(std::move(rest));
  for (const std::vector<ModeOperator>& term : op_.terms) {
    double scale = 1.0;
    std::map<std::string, ModeOperator> parts;
    for (std::size_t k = 0; k < axes_.size(); ++k) {
      if (weights[k].size() == 0) {
        parts.emplace(axes_[k].name(), term[k]);
      } else {
        scale *= weights[k].dot(diagonal_of(axes_[k], term[k]));
      }
    }
    result.add_term(parts, scale);
  }
  for (const bool is_lift : {false, true}) {
    const SeparatedTensor& whole = is_lift ? lift_ : rhs_;
    for (int r = 0; r < whole.rank(); ++r) {
      double scale = whole.weights[r];
      std::map<std::string, Eigen::VectorXd> parts;
      for (std::size_t k = 0; k < axes_.size(); ++k) {
        if (weights[k].size() == 0) {
          parts.emplace(axes_[k].name(), whole.factors[k].col(r));
        } else {
          scale *= weights[k].dot(whole.factors[k].col(r));
        }
      }
      if (is_lift) {
        result.add_to_lift(parts, scale);
      } else {
        result.add_source(parts, scale);
      }
    }
  }
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    if (weights[k].size() > 0) continue;
    result.known_[result.position(axes_[k].name())] = known_[k];
    result.norms_[result.position(axes_[k].name())] = norms_[k];
  }
  return result;
}

Eigen::VectorXd ParametricProblem::interpolation_weights(std::size_t k, double x) const {
  const Axis& axis = axes_[k];
  if (is_weak(k) || !known_[k].empty()) {
    throw ArgumentError(
        fmt::format("a parametric problem at a point of axis \"{}\", which {}; one without was expected",
                    axis.name(), is_weak(k) ? "is weak" : "has known nodes"));
  }
  if (!axis.contains(x)) {
    throw ArgumentError(fmt::format("{} is {}, expected a point of its axis, from {} to {}", axis.name(), x,
                                    axis.lower(), axis.upper()));
  }
  InterpolationStencil stencil = axis.make_stencil();
  axis.interpolate(x, stencil, false);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(axis.size());
  weights.segment(stencil.first, stencil.value.size()) = stencil.value;
  return weights;
}

LinearProblem ParametricProblem::assemble() const {
  if (op_.terms.empty()) throw ArgumentError("a parametric problem has no term, expected at least one");
  LinearProblem problem;
  SeparatedTensor rhs = rhs_;
  if (lift_.rank() > 0) rhs.append(op_.apply(lift_), -1.0);
  problem.op.terms.resize(op_.terms.size());
  problem.rhs.weights = rhs.weights;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const std::vector<int> nodes = unknown_nodes(k);
    for (std::size_t i = 0; i < op_.terms.size(); ++i)
      problem.op.terms[i].push_back(restricted(op_.terms[i][k], nodes));
    problem.rhs.factors.emplace_back(rhs.factors[k](nodes, Eigen::all));
    problem.row_weights.emplace_back(is_weak(k) ? Eigen::VectorXd()
                                                : Eigen::VectorXd(axes_[k].weights()(nodes)));
    problem.row_norms.push_back(norms_[k].size() > 0 ? restricted(norms_[k], nodes) : SparseMatrix());
  }
  problem.rhs.normalise();
  return problem;
}

SeparatedTensor ParametricProblem::complete(const SeparatedTensor& unknown) const {
  if (unknown.factors.size() != axes_.size()) {
    throw ArgumentError(
        fmt::format("the solution has {} modes, the problem {} axes", unknown.factors.size(), axes_.size()));
  }
  SeparatedTensor whole;
  whole.weights = unknown.weights;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const std::vector<int> nodes = unknown_nodes(k);
    if (unknown.factors[k].rows() != static_cast<Eigen::Index>(nodes.size())) {
      throw ArgumentError(fmt::format("the solution does not have {} unknown nodes on axis \"{}\"",
                                      nodes.size(), axes_[k].name()));
    }
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(axes_[k].size(), unknown.rank());
    factor(nodes, Eigen::all) = unknown.factors[k];
    whole.factors.push_back(std::move(factor));
  }
  whole.append(lift_);
  whole.normalise();
  return whole;
}

}  // namespace samara::pgd
