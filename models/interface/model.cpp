#include "samara/models/interface/model.h"

#include <algorithm>
#include <cmath>

#include "samara/base/errors.h"
#include "samara/base/number_text.h"
#include "samara/base/unit_labels.h"

namespace samara::models {

bool Model::completion_tangents(const ParameterValues&, std::span<const int>,
                                Eigen::Ref<Eigen::MatrixXd>) const {
  return false;
}

void Model::rhs_with_tangents(double, std::span<const double>, std::span<const double>,
                              const Eigen::Ref<const Eigen::MatrixXd>&, std::span<double>,
                              Eigen::Ref<Eigen::MatrixXd>, Eigen::Ref<Eigen::MatrixXd>) const {}

void Model::forces(double, std::span<const double>, const ParameterValues&, std::span<Wrench>) const {}

void Model::outputs(double, std::span<const double>, const ParameterValues&, std::span<double>) const {}

void Model::outputs_with_derivatives(double, std::span<const double>, const ParameterValues&,
                                     std::span<double>, Eigen::Ref<Eigen::VectorXd>,
                                     Eigen::Ref<Eigen::MatrixXd>, Eigen::Ref<Eigen::MatrixXd>) const {}

std::optional<double> Model::kinetic_energy(double, std::span<const double>, const ParameterValues&) const {
  return std::nullopt;
}

namespace {

/// Parameters of a point, all given.
void take_point(const Eigen::Ref<const Eigen::MatrixXd>& p, Eigen::Index point, ParameterValues& values) {
  values.value.assign(p.col(point).begin(), p.col(point).end());
  values.given.assign(values.value.size(), 1);
}

std::span<const double> column_of(const Eigen::Ref<const Eigen::MatrixXd>& matrix, Eigen::Index j) {
  return {matrix.col(j).data(), static_cast<std::size_t>(matrix.rows())};
}

}  // namespace

void Model::rhs_at_points(const Eigen::Ref<const Eigen::VectorXd>& t,
                          const Eigen::Ref<const Eigen::MatrixXd>& x,
                          const Eigen::Ref<const Eigen::MatrixXd>& p,
                          Eigen::Ref<Eigen::MatrixXd> dxdt) const {
  ParameterValues values;
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    take_point(p, j, values);
    rhs(t[j], column_of(x, j), values, {dxdt.col(j).data(), static_cast<std::size_t>(dxdt.rows())});
  }
}

void Model::jacobians_at_points(const Eigen::Ref<const Eigen::VectorXd>& t,
                                const Eigen::Ref<const Eigen::MatrixXd>& x,
                                const Eigen::Ref<const Eigen::MatrixXd>& p,
                                Eigen::Ref<Eigen::MatrixXd> jacobians) const {
  ParameterValues values;
  std::vector<double> f(static_cast<std::size_t>(x.rows()));
  Eigen::MatrixXd df_dx(x.rows(), x.rows()), df_dp(x.rows(), p.rows());
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    take_point(p, j, values);
    rhs_with_derivatives(t[j], column_of(x, j), values, f, df_dx, df_dp);
    jacobians.col(j) = df_dx.reshaped();
  }
}

void Model::complete_into(const ParameterValues& p, std::span<double> all) const {
  std::ranges::copy(completed(p), all.begin());
}

AffineSplit affine_split(const Model& model, double t, std::span<const double> x, const ParameterValues& p) {
  const ModelInfo& info = model.info();
  const auto states = static_cast<Eigen::Index>(info.states.size());
  AffineSplit split;
  split.names = info.affine_in;
  split.constant.resize(states);
  split.slopes.resize(states, static_cast<Eigen::Index>(split.names.size()));
  ParameterValues zero = {model.completed(p), std::vector<char>(info.parameters.size(), 1)};
  std::vector<Eigen::Index> places;
  for (const std::string& name : split.names) {
    const auto place = std::ranges::find(info.parameters, name, &ParameterInfo::name);
    if (place == info.parameters.end()) {
      throw ArgumentError("model \"" + info.name + "\" is said to be affine in \"" + name +
                          "\", which is none of its parameters");
    }
    places.push_back(place - info.parameters.begin());
    zero.value[static_cast<std::size_t>(places.back())] = 0.0;
  }
  Eigen::MatrixXd df_dx(states, states);
  Eigen::MatrixXd df_dp(states, static_cast<Eigen::Index>(info.parameters.size()));
  model.rhs_with_derivatives(t, x, zero, {split.constant.data(), static_cast<std::size_t>(states)}, df_dx,
                             df_dp);
  split.slopes = df_dp(Eigen::all, places);
  return split;
}

double state_scale(const StateInfo& state, const Scales& scales) {
  if (state.scale) return *state.scale;
  if (state.unit == "m") return scales.length;
  if (state.unit == "m/s") return scales.velocity;
  if (state.unit == "rad/s" || state.unit == "1/s") return 1.0 / scales.time;
  return 1.0;
}

bool has_scale(const StateInfo& state) {
  return state.scale || state.unit == "m" || state.unit == "m/s" || state.unit == "rad/s" ||
         state.unit == "1/s";
}

bool in_meaning(const ParameterInfo& parameter, double value) {
  return (parameter.lower_inclusive ? value >= parameter.lower : value > parameter.lower) &&
         value <= parameter.upper;
}

std::string meaning_text(const ParameterInfo& parameter) {
  const std::string unit = unit_suffix(parameter.unit);
  const bool below = std::isfinite(parameter.lower);
  if (below && std::isfinite(parameter.upper)) {
    return (parameter.lower_inclusive ? "from " : "above ") + number_text(parameter.lower) +
           (parameter.lower_inclusive ? " to " : ", up to ") + number_text(parameter.upper) + unit;
  }
  if (below) return (parameter.lower_inclusive ? ">= " : "> ") + number_text(parameter.lower) + unit;
  if (std::isfinite(parameter.upper)) return "<= " + number_text(parameter.upper) + unit;
  return "";
}

double held_start(const StateInfo& state, const std::map<std::string, double>& held) {
  const auto value = held.find(state.name + "(0)");
  return value == held.end() ? state.default_initial : value->second;
}

std::string Model::problem(const ParameterValues&) const {
  return "";
}

std::string time_unit(const ModelInfo& info) {
  const auto dimensionless = [](const auto& item) { return item.unit == "1"; };
  const bool all = std::all_of(info.states.begin(), info.states.end(), dimensionless) &&
                   std::all_of(info.parameters.begin(), info.parameters.end(), dimensionless);
  return all ? "1" : "s";
}

ForceUnits force_units(const ModelInfo& info) {
  if (time_unit(info) == "1") return {"1", "1", "1", "1"};
  if (info.per_span) return {"N/m", "N", "W/m", "J/m"};
  return {"N", "N m", "W", "J"};
}

}  // namespace samara::models
