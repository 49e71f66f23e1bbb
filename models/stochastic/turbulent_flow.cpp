#include "samara/models/stochastic/turbulent_flow.h"

#include <cmath>
#include <utility>

#include "samara/base/errors.h"
#include "samara/base/require.h"

namespace samara::models {

namespace {

void check_energy(double k, double epsilon) {
  require_not_negative(k, "k [m^2/s^2]");
  require_positive(epsilon, "epsilon [m^2/s^3]");
}

void check_stream(const Eigen::Vector3d& stream) {
  for (const double component : stream)
    require(std::isfinite(component), "stream [m/s]", component, "a finite number");
}

class FunctionFlow final : public TurbulentFlow {
 public:
  FunctionFlow(std::function<AmbientSample(double, const Eigen::Vector3d&)> mean,
               std::function<Turbulence(double, const Eigen::Vector3d&)> energy, double length)
      : mean_(std::move(mean)), energy_(std::move(energy)), length_(length) {}

  AmbientSample sample(double t, const Eigen::Vector3d& position) const override {
    return mean_(t, position);
  }
  Turbulence turbulence(double t, const Eigen::Vector3d& position) const override {
    return energy_(t, position);
  }
  double length() const override { return length_; }

 private:
  std::function<AmbientSample(double, const Eigen::Vector3d&)> mean_;
  std::function<Turbulence(double, const Eigen::Vector3d&)> energy_;
  double length_;
};

class UniformTurbulence final : public TurbulentFlow {
 public:
  UniformTurbulence(double k, double epsilon, const Eigen::Vector3d& stream, bool decays)
      : k_(k), epsilon_(epsilon), stream_{.velocity = stream}, decays_(decays) {}

  AmbientSample sample(double, const Eigen::Vector3d&) const override { return stream_; }
  Turbulence turbulence(double t, const Eigen::Vector3d&) const override {
    if (decays_) return decaying_energy(k_, epsilon_, t);
    return {.k = k_, .epsilon = epsilon_};
  }
  double length() const override { return 1.0; }  // nothing changes over any way
  bool is_uniform() const override { return true; }

 private:
  double k_, epsilon_;
  AmbientSample stream_;
  bool decays_;
};

}  // namespace

Turbulence decaying_energy(double k_0, double epsilon_0, double t) {
  check_energy(k_0, epsilon_0);
  require_not_negative(t, "t [s]");
  if (k_0 == 0.0) return {};
  constexpr double kGrowth = 1.92 - 1.0;  // C_2 - 1
  const double X = 1.0 + kGrowth * epsilon_0 * t / k_0;
  const double k = k_0 * std::pow(X, -1.0 / kGrowth);
  return {.k = k, .epsilon = epsilon_0 * (k / k_0) / X};
}

std::shared_ptr<const TurbulentFlow> uniform_turbulence(double k, double epsilon,
                                                        const Eigen::Vector3d& stream) {
  check_energy(k, epsilon);
  check_stream(stream);
  return std::make_shared<UniformTurbulence>(k, epsilon, stream, false);
}

std::shared_ptr<const TurbulentFlow> decaying_turbulence(double k_0, double epsilon_0,
                                                         const Eigen::Vector3d& stream) {
  check_energy(k_0, epsilon_0);
  check_stream(stream);
  return std::make_shared<UniformTurbulence>(k_0, epsilon_0, stream, true);
}

std::shared_ptr<const TurbulentFlow> turbulent_flow(
    std::function<AmbientSample(double t, const Eigen::Vector3d& position)> mean,
    std::function<Turbulence(double t, const Eigen::Vector3d& position)> energy, double length) {
  if (!mean) throw ArgumentError("there is no mean flow; a function was expected");
  if (!energy) throw ArgumentError("there is no energy; a function was expected");
  require_positive(length, "the length of the flow");
  return std::make_shared<FunctionFlow>(std::move(mean), std::move(energy), length);
}

}  // namespace samara::models
