// A model of your own: a small sphere that sinks slowly, by Stokes' drag. Checked, then integrated.
#include <cstdio>
#include <numbers>

#include "samara/models/checks/check_model.h"
#include "samara/models/integrators/integrate.h"

using namespace samara::models;

class StokesFall final : public Model {
 public:
  const ModelInfo& info() const override { return info_; }

  void rhs(double, std::span<const double> x, const ParameterValues& p,
           std::span<double> dxdt) const override {
    dxdt[0] = x[1];
    dxdt[1] = (weight(p) - drag(p) * x[1]) / mass(p);
  }

  void rhs_with_derivatives(double t, std::span<const double> x, const ParameterValues& p,
                            std::span<double> dxdt, Eigen::Ref<Eigen::MatrixXd> df_dx,
                            Eigen::Ref<Eigen::MatrixXd> df_dp) const override {
    rhs(t, x, p, dxdt);
    df_dx << 0.0, 1.0, 0.0, -drag(p) / mass(p);
    df_dp.setZero();  // by mass, weight, radius, viscosity: all of them must be given
    df_dp(1, 0) = -dxdt[1] / mass(p);
    df_dp(1, 1) = 1.0 / mass(p);
    df_dp(1, 2) = -drag(p) / p.value[2] * x[1] / mass(p);
    df_dp(1, 3) = -drag(p) / p.value[3] * x[1] / mass(p);
  }

  void forces(double, std::span<const double> x, const ParameterValues& p,
              std::span<Wrench> terms) const override {
    terms[0].force.z() = -drag(p) * x[1];
    terms[1].force.z() = weight(p);
    for (Wrench& term : terms) term.power = term.force.z() * x[1];
  }

  std::optional<double> kinetic_energy(double, std::span<const double> x,
                                       const ParameterValues& p) const override {
    return 0.5 * mass(p) * x[1] * x[1];
  }

  std::vector<double> completed(const ParameterValues& p) const override { return p.value; }

  Scales scales(const ParameterValues& p) const override {
    const double time = mass(p) / drag(p);
    const double velocity = weight(p) / drag(p);
    return {.length = velocity * time, .time = time, .velocity = velocity};
  }

 private:
  static double mass(const ParameterValues& p) { return p.value[0]; }
  static double weight(const ParameterValues& p) { return p.value[1]; }
  static double drag(const ParameterValues& p) { return 6.0 * std::numbers::pi * p.value[2] * p.value[3]; }

  const ModelInfo info_ = {
      .name = "stokes_fall",
      .title = "A small sphere sinking slowly",
      .equations = "z' = v,  mass v' = weight - 6 pi viscosity radius v",
      .frames = "z is vertical, positive downward",
      .source = "G. G. Stokes, Trans. Cambridge Phil. Soc. 9 (1851) part II, 8-106",
      .validity = "Reynolds numbers far below 1; neither added mass nor history force",
      .symmetries = {"translation of z"},
      .states = {{.name = "z", .unit = "m", .description = "depth"},
                 {.name = "v", .unit = "m/s", .description = "velocity, positive downward"}},
      .parameters = {{.name = "mass", .unit = "kg", .description = "of the sphere", .lower = 0.0},
                     {.name = "weight", .unit = "N", .description = "less buoyancy", .lower = 0.0},
                     {.name = "radius", .unit = "m", .description = "of the sphere", .lower = 0.0},
                     {.name = "viscosity", .unit = "Pa s", .description = "of the fluid", .lower = 0.0}},
      .affine_in = {"weight", "viscosity"},
      .force_terms = {{.name = "drag", .description = "Stokes"}, {.name = "weight"}},
  };
};

int main() {
  const auto model = std::make_shared<StokesFall>();
  const samara::Check check = check_model(*model);
  for (const std::string& finding : check.findings) std::printf("%s\n", finding.c_str());
  std::printf("%zu findings\n", check.findings.size());

  const ParametricModel bead(model, {{"mass", 1e-9}, {"weight", 5e-9}, {"radius", 5e-5}}, {"viscosity"});
  const double viscosity = 1e-3, end = 0.01;
  const Trajectory fall = integrate(bead, {&viscosity, 1}, {&end, 1}, {}, true);
  std::printf("after 10 ms: v = %.4f mm/s, dv/dviscosity = %.4f mm/s per Pa s\n", 1e3 * fall.states(0, 1),
              1e3 * fall.sensitivities[0](0, 1));
  return check.passed() && fall.is_usable() ? 0 : 1;
}
