#pragma once

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "samara/models/interface/parametric_model.h"
#include "samara/models/laws/registry.h"

/// A card in air (7 cm x 4 cm x 0.2 mm), released obliquely with some spin; smoothed at 2 cm/s and 1 rad/s,
/// the defaults. Over 0.3 s neighbouring trajectories stay together: the motion is not yet a chaotic one.
inline std::map<std::string, double> card_values() {
  return {{"a", 0.035},
          {"b", 0.02},
          {"c", 1e-4},
          {"density", 1200.0},
          {"C_D0", 0.05},
          {"C_D90", 0.61},
          {"C_T", 1.81},
          {"C_R", 1.21},
          {"C_w", 2.0},
          {"qw(0)", std::cos(0.15)},
          {"qx(0)", std::sin(0.15) * std::cos(0.6)},
          {"qy(0)", std::sin(0.15) * std::sin(0.6)},
          {"qz(0)", 0.0},
          {"ux(0)", 0.05},
          {"uy(0)", 0.05},
          {"uz(0)", -0.1},
          {"wx(0)", 1.0},
          {"wy(0)", 2.0},
          {"wz(0)", 3.0}};
}

inline samara::models::ParametricModel falling_card(const std::vector<std::string>& free) {
  std::map<std::string, double> fixed = card_values();
  for (const std::string& name : free) fixed.erase(name);
  return {samara::models::find_model("immersed_body"), fixed, free};
}

/// A model seen without its kernels.
class PlainModel final : public samara::models::Model {
 public:
  explicit PlainModel(std::shared_ptr<const samara::models::Model> model) : model_(std::move(model)) {}

  const samara::models::ModelInfo& info() const override { return model_->info(); }
  void rhs(double t, std::span<const double> x, const samara::models::ParameterValues& p,
           std::span<double> dxdt) const override {
    model_->rhs(t, x, p, dxdt);
  }
  void rhs_with_derivatives(double t, std::span<const double> x, const samara::models::ParameterValues& p,
                            std::span<double> dxdt, Eigen::Ref<Eigen::MatrixXd> df_dx,
                            Eigen::Ref<Eigen::MatrixXd> df_dp) const override {
    model_->rhs_with_derivatives(t, x, p, dxdt, df_dx, df_dp);
  }
  std::vector<double> completed(const samara::models::ParameterValues& p) const override {
    return model_->completed(p);
  }
  samara::models::Scales scales(const samara::models::ParameterValues& p) const override {
    return model_->scales(p);
  }

 private:
  std::shared_ptr<const samara::models::Model> model_;
};
