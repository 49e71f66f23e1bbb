#include <array>
#include <numbers>

#include <catch2/catch.hpp>

#include "bodies_in_flow.h"
#include "planar_references.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using std::numbers::pi;

namespace {

/// The thin falling plate in its own units (fluid density, semi-chord and U are one), as an immersed body.
///
/// Forces of the immersed body are those of the planar law on a span of A/l = pi b/2; mass, added mass,
/// inertia and damping are given as those of the plane on this span, whatever the semi-axis b along it.
std::map<std::string, double> thin_plate(double I_star, double b) {
  const double span = pi * b / 2.0;
  const double A = 1.4, B = 1.0, mu1 = 0.2, mu2 = 0.2;
  return {{"a", 1.0},
          {"b", b},
          {"c", 0.01},
          {"density", 1.0},
          {"fluid_density", 1.0},
          {"g", 1.0 / I_star},  // so that (m - m_f) g is pi per unit span
          {"mass", pi * I_star * span},
          {"displaced_mass", 0.0},
          {"I_y", pi * I_star / 4.0 * span},
          {"M_x", 0.0},
          {"M_z", pi * span},
          {"J_y", pi / 8.0 * span},
          {"C_D0", A - B},
          {"C_D90", A + B},
          {"C_T", 1.2},
          {"C_R", pi},
          {"C_w", 15.0 / 8.0 * pi * pi * mu2},  // 1/2 C_w 8/15 = pi mu2 on the span
          {"linear_damping_y", pi * mu1 * span},
          {"speed_floor", 1e-9},
          {"rate_floor", 1e-9}};
}

}  // namespace

TEST_CASE("an immersed body with the masses of the plane follows the planar falling plate") {
  // Chord along body x, normal along body z; the planar angle turns x towards z: a rotation about -y.
  BodyState start;
  start.q = Eigen::AngleAxisd(-pi / 4.0, Eigen::Vector3d::UnitY());
  start.u = {0.001, 0.0, 0.001};
  start.w = {0.0, -0.001, 0.0};
  struct Case {
    double b;
    PlanarReference reference;
  };
  std::vector<Case> cases = {{0.3, kPlanarReferences[4]}, {2.5, kPlanarReferences[7]}};
  for (const PlanarReference& reference : kPlanarReferences) cases.push_back({1.0, reference});
  for (const auto& [b, reference] : cases) {
    INFO("b = " << b << ", I* = " << reference.I_star << ", t = " << reference.t);
    const BodyState end(
        motion(find_model("immersed_body"), thin_plate(reference.I_star, b), start, {reference.t}).row(0));
    const auto& [vx, vy, w, theta, x, y] = reference.state;
    CHECK(end.u.x() == Approx(vx).margin(1e-6));
    CHECK(end.u.z() == Approx(vy).margin(1e-6));
    CHECK(-end.w.y() == Approx(w).margin(1e-6));
    CHECK(end.R()(2, 0) == Approx(std::sin(theta)).margin(1e-6));
    CHECK(end.R()(0, 0) == Approx(std::cos(theta)).margin(1e-6));
    CHECK(end.position.x() == Approx(x).margin(1e-6));
    CHECK(end.position.z() == Approx(y).margin(1e-6));
  }
}
