#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "samara/models/interface/parametric_model.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/fluid_seen.h"

/// Leaves that fall through a breeze, for tests of realisations and of what they come to.

inline samara::models::ParametricModel leaf(double height = 1.0) {
  return {samara::models::find_model("immersed_body_in_gusts"),
          {{"a", 0.035},
           {"b", 0.02},
           {"c", 1e-4},
           {"density", 1200.0},
           {"C_D90", 0.61},
           {"C_D0", 0.05},
           {"C_T", 1.81},
           {"C_R", 1.21},
           {"C_w", 2.0},
           {"qw(0)", 0.9},
           {"qx(0)", 0.3},
           {"qy(0)", 0.2},
           {"z(0)", height}},
          {}};
}

inline std::shared_ptr<const samara::models::AirSource> breeze(std::uint64_t seed = 7) {
  const auto turbulence = samara::models::uniform_turbulence(0.1, 0.2, {0.5, 0.0, 0.0});
  return samara::models::fluid_seen_in(turbulence, seed, {.C_0 = 6.0, .radius = 0.026});
}

/// A source in which every realisation has a twin.
class Twins final : public samara::models::AirSource {
 public:
  explicit Twins(std::shared_ptr<const samara::models::AirSource> real) : real_(std::move(real)) {}
  std::unique_ptr<samara::models::AirAlongPath> realisation(std::uint64_t number,
                                                            bool mirrored) const override {
    return real_->realisation(number / 2, mirrored);
  }

 private:
  std::shared_ptr<const samara::models::AirSource> real_;
};
