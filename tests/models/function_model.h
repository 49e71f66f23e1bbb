#pragma once

#include <cmath>
#include <functional>

#include "samara/models/interface/model.h"

/// A model put together in a test from functions, to spoil it one promise at a time. Derivatives come from
/// central differences.
class FunctionModel final : public samara::models::Model {
 public:
  using Values = std::vector<double>;
  using Rates = std::function<Values(const Values& x, const Values& p)>;
  using Forces = std::function<std::vector<samara::models::Wrench>(const Values& x, const Values& p)>;
  using Energy = std::function<double(const Values& x, const Values& p)>;

  explicit FunctionModel(Rates rates) : rates_(std::move(rates)) {
    info_.name = "function";
    info_.title = "A model of a test";
    info_.equations = "x' = f(x, p)";
    info_.frames = "none";
    info_.source = "the test";
    info_.validity = "the test";
  }

  samara::models::ModelInfo info_;
  Forces forces_;
  Energy energy_;
  /// Puts derived defaults into p where it is not given.
  std::function<void(const std::vector<char>& given, Values& p)> complete_;

  void add_state(const std::string& name, const std::string& unit) {
    info_.states.push_back({.name = name, .unit = unit, .description = "a state"});
  }
  void add_parameter(const std::string& name, const std::string& unit) {
    info_.parameters.push_back({.name = name, .unit = unit, .description = "a parameter", .lower = 0.0});
  }

  const samara::models::ModelInfo& info() const override { return info_; }

  void rhs(double, std::span<const double> x, const samara::models::ParameterValues& p,
           std::span<double> dxdt) const override {
    const Values rates = rates_(Values(x.begin(), x.end()), completed(p));
    std::copy(rates.begin(), rates.end(), dxdt.begin());
  }

  void rhs_with_derivatives(double t, std::span<const double> x, const samara::models::ParameterValues& p,
                            std::span<double> dxdt, Eigen::Ref<Eigen::MatrixXd> df_dx,
                            Eigen::Ref<Eigen::MatrixXd> df_dp) const override {
    rhs(t, x, p, dxdt);
    Values at(x.begin(), x.end());
    for (std::size_t i = 0; i < at.size(); ++i) {
      df_dx.col(static_cast<Eigen::Index>(i)) = difference(at, p, at[i]);
    }
    samara::models::ParameterValues given = p;
    df_dp.setZero();
    for (std::size_t j = 0; j < p.value.size(); ++j) {
      if (p.given[j]) df_dp.col(static_cast<Eigen::Index>(j)) = difference(at, given, given.value[j]);
    }
  }

  void forces(double, std::span<const double> x, const samara::models::ParameterValues& p,
              std::span<samara::models::Wrench> terms) const override {
    if (!forces_) return;
    const auto list = forces_(Values(x.begin(), x.end()), completed(p));
    std::copy(list.begin(), list.end(), terms.begin());
  }

  std::optional<double> kinetic_energy(double, std::span<const double> x,
                                       const samara::models::ParameterValues& p) const override {
    if (!energy_) return std::nullopt;
    return energy_(Values(x.begin(), x.end()), completed(p));
  }

  std::vector<double> completed(const samara::models::ParameterValues& p) const override {
    Values all = p.value;
    if (complete_) complete_(p.given, all);
    return all;
  }

  samara::models::Scales scales(const samara::models::ParameterValues&) const override { return {}; }

 private:
  /// d(rates)/d(variable), where variable is a number within x or p.
  Eigen::VectorXd difference(const Values& x, const samara::models::ParameterValues& p,
                             double& variable) const {
    const double middle = variable;
    const double step = 6e-6 * std::max(1.0, std::abs(middle));
    variable = middle + step;
    const Values above = rates_(x, completed(p));
    variable = middle - step;
    const Values below = rates_(x, completed(p));
    variable = middle;
    Eigen::VectorXd column(static_cast<Eigen::Index>(above.size()));
    for (std::size_t i = 0; i < above.size(); ++i) {
      column[static_cast<Eigen::Index>(i)] = (above[i] - below[i]) / (2.0 * step);
    }
    return column;
  }

  Rates rates_;
};
