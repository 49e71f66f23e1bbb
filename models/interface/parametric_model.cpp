#include "samara/models/interface/parametric_model.h"

#include <algorithm>
#include <cmath>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/number_text.h"
#include "samara/base/text.h"
#include "samara/base/unit_labels.h"

namespace samara::models {

namespace {

std::string initial_name(const StateInfo& state) {
  return state.name + "(0)";
}

/// The coordinate of that name.
/// @throws ArgumentError naming the nearest.
FreeCoordinate find_coordinate(const ModelInfo& info, const std::string& name) {
  std::vector<std::string> known;
  for (std::size_t j = 0; j < info.parameters.size(); ++j) {
    const ParameterInfo& parameter = info.parameters[j];
    if (parameter.name == name) return {name, parameter.unit, false, static_cast<int>(j)};
    known.push_back(parameter.name);
  }
  for (std::size_t i = 0; i < info.states.size(); ++i) {
    const StateInfo& state = info.states[i];
    if (initial_name(state) == name) return {name, state.unit, true, static_cast<int>(i)};
    known.push_back(initial_name(state));
  }
  throw ArgumentError("model " + in_quotes(info.name) + " has no parameter or initial value " +
                      in_quotes(name) + suggestion(name, known));
}

std::string with_unit(double value, const std::string& unit) {
  return number_text(value) + unit_suffix(unit);
}

/// @throws ArgumentError if the value is not finite or outside the parameter's meaning.
void check_value(const ModelInfo& info, const FreeCoordinate& coordinate, double value) {
  if (!std::isfinite(value)) {
    throw ArgumentError(in_quotes(coordinate.name) + " is " + number_text(value) +
                        "; a finite number was expected");
  }
  if (coordinate.is_initial) return;
  const ParameterInfo& parameter = info.parameters[static_cast<std::size_t>(coordinate.index)];
  if (in_meaning(parameter, value)) return;
  throw ArgumentError(in_quotes(coordinate.name) + " is " + with_unit(value, parameter.unit) + "; a value " +
                      meaning_text(parameter) + " was expected");
}

/// @throws ArgumentError naming every parameter that has no value and no way to get one.
void check_complete(const ModelInfo& info, const ParameterValues& p) {
  std::vector<std::string> missing;
  for (std::size_t j = 0; j < info.parameters.size(); ++j) {
    const ParameterInfo& parameter = info.parameters[j];
    if (p.given[j] || parameter.default_value || !parameter.derived.empty()) continue;
    missing.push_back(in_quotes(parameter.name) + (parameter.unit == "1" ? "" : " [" + parameter.unit + "]"));
  }
  if (missing.empty()) return;
  throw ArgumentError("model " + in_quotes(info.name) + " needs a value of " + join(missing) +
                      "; give it, or leave it free");
}

}  // namespace

ParametricModel::ParametricModel(std::shared_ptr<const Model> model,
                                 const std::map<std::string, double>& fixed,
                                 const std::vector<std::string>& free)
    : model_(std::move(model)), fixed_(fixed) {
  if (!model_) throw ArgumentError("a parametric model needs a model; a null pointer was given");
  const ModelInfo& info = model_->info();
  ParameterValues base;
  base.value.assign(info.parameters.size(), 0.0);
  base.given.assign(info.parameters.size(), 0);
  for (const StateInfo& state : info.states) base_initial_.push_back(state.default_initial);

  for (const auto& [name, value] : fixed_) {
    const FreeCoordinate coordinate = find_coordinate(info, name);
    check_value(info, coordinate, value);
    const auto index = static_cast<std::size_t>(coordinate.index);
    (coordinate.is_initial ? base_initial_ : base.value)[index] = value;
    if (!coordinate.is_initial) base.given[index] = 1;
  }
  for (const std::string& name : free) {
    const FreeCoordinate coordinate = find_coordinate(info, name);
    if (fixed_.contains(name)) {
      throw ArgumentError(in_quotes(name) + " is both fixed, at " +
                          with_unit(fixed_.at(name), coordinate.unit) +
                          ", and free; one of the two was expected");
    }
    if (std::ranges::count(free_, name, &FreeCoordinate::name) > 0) {
      throw ArgumentError(in_quotes(name) + " is listed twice among the free coordinates; once was expected");
    }
    if (!coordinate.is_initial) {
      base.given[static_cast<std::size_t>(coordinate.index)] = 1;
      free_parameters_.push_back(coordinate.index);
    }
    free_.push_back(coordinate);
  }
  check_complete(info, base);
  base_ = std::make_shared<const ParameterValues>(std::move(base));
}

ParametricModel::Workspace ParametricModel::make_workspace() const {
  const auto parameters = static_cast<Eigen::Index>(base_->value.size());
  return {.p = *base_,
          .df_dp = Eigen::MatrixXd::Zero(state_count(), parameters),
          .complete = *base_,
          .q = std::vector<double>(free_.size()),
          .base = nullptr,
          .tangents = {},
          .has_tangents = Workspace::Tangents::unknown};
}

void ParametricModel::parameter_values(std::span<const double> q, ParameterValues& p) const {
  p = *base_;  // same sizes: copies without allocating
  for (std::size_t j = 0; j < free_.size(); ++j) {
    if (!free_[j].is_initial) p.value[static_cast<std::size_t>(free_[j].index)] = q[j];
  }
}

void ParametricModel::complete(std::span<const double> q, Workspace& workspace) const {
  if (workspace.base == base_ && std::ranges::equal(q, workspace.q)) return;
  parameter_values(q, workspace.p);
  workspace.complete.value.resize(base_->value.size());
  workspace.complete.given.assign(base_->value.size(), 1);
  model_->complete_into(workspace.p, workspace.complete.value);
  workspace.q.assign(q.begin(), q.end());
  workspace.base = base_;
  workspace.has_tangents = Workspace::Tangents::unknown;
}

void ParametricModel::rhs(double t, std::span<const double> x, std::span<const double> q,
                          std::span<double> dxdt, Workspace& workspace) const {
  complete(q, workspace);
  model_->rhs(t, x, workspace.complete, dxdt);
}

void ParametricModel::rhs_with_derivatives(double t, std::span<const double> x, std::span<const double> q,
                                           std::span<double> dxdt, RhsDerivatives& derivatives,
                                           Workspace& workspace) const {
  using Tangents = Workspace::Tangents;
  complete(q, workspace);
  derivatives.df_dx.resize(state_count(), state_count());
  derivatives.df_dq.resize(state_count(), free_count());
  if (workspace.has_tangents == Tangents::unknown) {
    const auto columns = static_cast<Eigen::Index>(free_parameters_.size());
    workspace.tangents.resize(static_cast<Eigen::Index>(base_->value.size()), columns);
    const bool has = model_->completion_tangents(workspace.p, free_parameters_, workspace.tangents);
    workspace.has_tangents = has ? Tangents::known : Tangents::none;
  }
  const bool known = workspace.has_tangents == Tangents::known;
  if (known) {
    model_->rhs_with_tangents(t, x, workspace.complete.value, workspace.tangents, dxdt, derivatives.df_dx,
                              workspace.df_dp.leftCols(workspace.tangents.cols()));
  } else {
    model_->rhs_with_derivatives(t, x, workspace.p, dxdt, derivatives.df_dx, workspace.df_dp);
  }
  Eigen::Index next = 0;  // of the parameters among the free coordinates
  for (std::size_t j = 0; j < free_.size(); ++j) {
    auto column = derivatives.df_dq.col(static_cast<Eigen::Index>(j));
    if (free_[j].is_initial) {
      column.setZero();
    } else {
      column = workspace.df_dp.col(known ? next++ : free_[j].index);
    }
  }
}

namespace {

/// Points that are completed at a time, so that their parameters stay in the cache.
constexpr Eigen::Index kPointsTogether = 256;

}  // namespace

Eigen::MatrixXd ParametricModel::complete_at_points(const Eigen::Ref<const Eigen::MatrixXd>& q) const {
  const auto parameters = static_cast<Eigen::Index>(base_->value.size());
  Eigen::MatrixXd all(parameters, q.cols());
  ParameterValues p = *base_;
  for (Eigen::Index j = 0; j < q.cols(); ++j) {
    if (j > 0 && q.col(j) == q.col(j - 1)) {
      all.col(j) = all.col(j - 1);
      continue;
    }
    for (std::size_t k = 0; k < free_.size(); ++k) {
      if (!free_[k].is_initial)
        p.value[static_cast<std::size_t>(free_[k].index)] = q(static_cast<Eigen::Index>(k), j);
    }
    model_->complete_into(p, {all.col(j).data(), static_cast<std::size_t>(parameters)});
  }
  return all;
}

void ParametricModel::rhs_at_points(const Eigen::Ref<const Eigen::VectorXd>& t,
                                    const Eigen::Ref<const Eigen::MatrixXd>& x,
                                    const Eigen::Ref<const Eigen::MatrixXd>& q,
                                    Eigen::Ref<Eigen::MatrixXd> dxdt) const {
  for (Eigen::Index first = 0; first < x.cols(); first += kPointsTogether) {
    const Eigen::Index count = std::min(kPointsTogether, x.cols() - first);
    const Eigen::MatrixXd p = complete_at_points(q.middleCols(first, count));
    model_->rhs_at_points(t.segment(first, count), x.middleCols(first, count), p,
                          dxdt.middleCols(first, count));
  }
}

void ParametricModel::jacobians_at_points(const Eigen::Ref<const Eigen::VectorXd>& t,
                                          const Eigen::Ref<const Eigen::MatrixXd>& x,
                                          const Eigen::Ref<const Eigen::MatrixXd>& q,
                                          Eigen::Ref<Eigen::MatrixXd> jacobians) const {
  for (Eigen::Index first = 0; first < x.cols(); first += kPointsTogether) {
    const Eigen::Index count = std::min(kPointsTogether, x.cols() - first);
    const Eigen::MatrixXd p = complete_at_points(q.middleCols(first, count));
    model_->jacobians_at_points(t.segment(first, count), x.middleCols(first, count), p,
                                jacobians.middleCols(first, count));
  }
}

void ParametricModel::initial(std::span<const double> q, std::span<double> x0) const {
  std::ranges::copy(base_initial_, x0.begin());
  for (std::size_t j = 0; j < free_.size(); ++j) {
    if (free_[j].is_initial) x0[static_cast<std::size_t>(free_[j].index)] = q[j];
  }
}

ParameterValues ParametricModel::parameter_values(std::span<const double> q) const {
  ParameterValues p;
  parameter_values(q, p);
  return p;
}

std::vector<double> ParametricModel::parameters(std::span<const double> q) const {
  return model_->completed(parameter_values(q));
}

Scales ParametricModel::scales(std::span<const double> q) const {
  return model_->scales(parameter_values(q));
}

void ParametricModel::check(std::span<const double> q) const {
  if (q.size() != free_.size()) {
    std::vector<std::string> names;
    for (const FreeCoordinate& coordinate : free_) names.push_back(coordinate.name);
    throw ArgumentError(std::to_string(q.size()) + " values were given for the " +
                        std::to_string(free_.size()) + " free coordinates" +
                        (names.empty() ? "" : " (" + join(names) + ")"));
  }
  for (std::size_t j = 0; j < q.size(); ++j) check_value(model_->info(), free_[j], q[j]);
  const std::string problem = model_->problem(parameter_values(q));
  if (!problem.empty()) throw ArgumentError("model " + in_quotes(model_->info().name) + ": " + problem);
  check_attitude(q);
}

void ParametricModel::check_attitude(std::span<const double> q) const {
  const ModelInfo& info = model_->info();
  for (const StateGroup& group : info.groups) {
    if (group.kind != StateGroupKind::quaternion) continue;
    std::vector<double> x0(info.states.size());
    initial(q, x0);
    double norm = 0.0;
    for (int i = 0; i < 4; ++i) norm = std::hypot(norm, x0[static_cast<std::size_t>(group.first + i)]);
    if (norm > 0.0 && std::isfinite(norm)) continue;
    throw ArgumentError("the initial quaternion from " +
                        in_quotes(initial_name(info.states[static_cast<std::size_t>(group.first)])) +
                        " on has the length " + number_text(norm) + "; a positive one was expected");
  }
}

}  // namespace samara::models
