#pragma once

#include <functional>

#include "samara/models/interface/parametric_model.h"

/// x' = f(t, x, p) with one state x and one parameter p (default 1), for tests that need an equation of their
/// own.
class ScalarModel final : public samara::models::Model {
 public:
  using Function = std::function<double(double t, double x, double p)>;

  ScalarModel(Function f, Function df_dx, Function df_dp)
      : f_(std::move(f)), df_dx_(std::move(df_dx)), df_dp_(std::move(df_dp)) {
    info_.name = "scalar";
    info_.title = "A scalar equation of a test";
    info_.equations = "x' = f(t, x, p)";
    info_.frames = "none";
    info_.source = "the test";
    info_.validity = "the test";
    info_.states = {{.name = "x", .unit = "1", .description = "the state"}};
    info_.parameters = {{.name = "p", .unit = "1", .default_value = 1.0, .description = "the parameter"}};
  }

  /// For tests that spoil it.
  samara::models::ModelInfo& mutable_info() { return info_; }

  const samara::models::ModelInfo& info() const override { return info_; }

  void rhs(double t, std::span<const double> x, const samara::models::ParameterValues& p,
           std::span<double> dxdt) const override {
    dxdt[0] = f_(t, x[0], completed(p)[0]);
  }

  void rhs_with_derivatives(double t, std::span<const double> x, const samara::models::ParameterValues& p,
                            std::span<double> dxdt, Eigen::Ref<Eigen::MatrixXd> df_dx,
                            Eigen::Ref<Eigen::MatrixXd> df_dp) const override {
    const double value = completed(p)[0];
    dxdt[0] = f_(t, x[0], value);
    df_dx(0, 0) = df_dx_(t, x[0], value);
    df_dp(0, 0) = p.given[0] ? df_dp_(t, x[0], value) : 0.0;
  }

  std::vector<double> completed(const samara::models::ParameterValues& p) const override {
    return {p.given[0] ? p.value[0] : 1.0};
  }

  samara::models::Scales scales(const samara::models::ParameterValues&) const override { return {}; }

 private:
  Function f_, df_dx_, df_dp_;
  samara::models::ModelInfo info_;
};

/// x' = f(t, x), for tests that ask for no derivatives by p.
inline std::shared_ptr<const samara::models::Model> scalar_model(
    std::function<double(double, double)> f, std::function<double(double, double)> df_dx) {
  return std::make_shared<ScalarModel>([f](double t, double x, double) { return f(t, x); },
                                       [df_dx](double t, double x, double) { return df_dx(t, x); },
                                       [](double, double, double) { return 0.0; });
}

/// x' = -x^2 from x(0) = 1: x = 1/(1 + t).
inline samara::models::ParametricModel hyperbola() {
  return {scalar_model([](double, double x) { return -x * x; }, [](double, double x) { return -2.0 * x; }),
          {{"x(0)", 1.0}},
          {}};
}
