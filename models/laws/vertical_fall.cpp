#include <numbers>

#include "samara/models/law_tools/drag_scales.h"
#include "samara/models/law_tools/reynolds.h"
#include "samara/models/laws/law_model.h"

namespace samara::models::laws {

namespace {

struct VerticalFall {
  static constexpr int kStates = 2;
  static constexpr int kParameters = 10;
  enum State { kV, kX };
  enum Parameter { kCD, kDensity, kFluidDensity, kArea, kThickness, kMa, kG, kReDrag, kNu, kLength };

  static ModelInfo info() {
    return {
        .name = "vertical_fall",
        .title = "Broadside vertical fall or rise of a flat body, with buoyancy and added mass",
        .equations =
            "(m + m_a) v' = (m - m_f) g - 1/2 fluid_density C_D area (1 + Re_drag/Re) |v| v,  "
            "x' = v,  Re = length |v|/nu,  "
            "m = density area thickness,  m_f = fluid_density area thickness",
        .frames =
            "v and x are vertical, positive downward; x is depth below the release point; forces along the "
            "third body axis, downward too",
        .source =
            "Newton's second law with added mass (C. E. Brennen, A Review of Added Mass and Fluid Inertial "
            "Forces, Naval Civil Engineering Laboratory CR 82.010, 1982) and quadratic drag; added mass of a "
            "disc broadside 8/3 fluid_density a^3 (H. Lamb, Hydrodynamics, 6th ed., 1932, art. 108)",
        .validity =
            "the body keeps its attitude (broadside) and falls straight; no history force; a Reynolds number "
            "of "
            "about 1e3 or more, where C_D is constant, or as Re_drag follows it; still, unbounded fluid; the "
            "derived m_a is that of a thin circular disc of the same area: give m_a for other outlines",
        .symmetries = {"translation of x"},
        .states = {{.name = "v", .unit = "m/s", .description = "velocity, positive downward"},
                   {.name = "x", .unit = "m", .description = "depth, positive downward"}},
        .parameters = parameters(),
        .affine_in = {"C_D", "g"},
        .force_terms = {{.name = "drag", .description = "against the velocity; takes power"},
                        {.name = "gravity and buoyancy",
                         .description = "weight less that of the displaced fluid"}},
    };
  }

  static std::vector<ParameterInfo> parameters() {
    return {
        {.name = "C_D",
         .unit = "1",
         .description = "drag coefficient on `area`",
         .lower = 0.0,
         .lower_inclusive = true},
        {.name = "density", .unit = "kg/m^3", .description = "density of the solid", .lower = 0.0},
        {.name = "fluid_density",
         .unit = "kg/m^3",
         .default_value = 998.2,
         .description = "density of the fluid; default: water at 20 degrees C and 1 atm (CRC Handbook of "
                        "Chemistry and Physics, 998.2 kg/m^3)",
         .lower = 0.0},
        {.name = "area", .unit = "m^2", .description = "frontal area of the body", .lower = 0.0},
        {.name = "thickness", .unit = "m", .description = "full thickness of the body", .lower = 0.0},
        {.name = "m_a",
         .unit = "kg",
         .derived = "8/3 fluid_density (area/pi)^(3/2)",
         .description = "added mass; default: a thin disc moving broadside",
         .lower = 0.0,
         .lower_inclusive = true},
        {.name = "g",
         .unit = "m/s^2",
         .default_value = 9.81,
         .description = "gravitational acceleration",
         .lower = 0.0,
         .lower_inclusive = true},
        Re_drag("Re = length |v|/nu"),
        viscosity_of_water(),
        derived("length", "m", "2 sqrt(area/pi)", "of Re; default: the diameter of a disc", false),
    };
  }

  /// Inertia of body and fluid, m + m_a [kg].
  template <class S>
  static S inertia(const S* p) {
    return p[kDensity] * p[kArea] * p[kThickness] + p[kMa];
  }

  /// Weight less buoyancy, (m - m_f) g [N], downward. One factor: no cancellation of two large products.
  template <class S>
  static S weight(const S* p) {
    return (p[kDensity] - p[kFluidDensity]) * p[kArea] * p[kThickness] * p[kG];
  }

  /// Drag over v^2 [kg/m].
  template <class S>
  static S drag(const S& C_D, const S* p) {
    return S(0.5) * p[kFluidDensity] * C_D * p[kArea];
  }

  /// Downward [N].
  template <class S>
  static S drag_force(const S& v, const S* p) {
    using std::abs;
    const ReynoldsSpeeds<S> Re = reynolds_speeds(p[kReDrag], S(0.0), p[kNu], p[kLength]);
    return -drag(p[kCD], p) * drag_speed(abs(v), Re.drag) * v;
  }

  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    const S& v = x[kV];
    dxdt[kV] = (weight(p) + drag_force(v, p)) / inertia(p);
    dxdt[kX] = v;
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    const S& v = x[kV];
    terms[0].force[2] = drag_force(v, p);
    terms[1].force[2] = weight(p);
    for (int k = 0; k < 2; ++k) terms[k].power = terms[k].force[2] * v;
  }

  /// Of body and added mass.
  template <class S>
  static S kinetic_energy(const S&, const S* x, const S* p) {
    return S(0.5) * inertia(p) * x[kV] * x[kV];
  }

  template <class S>
  static void complete(const char* given, S* p) {
    using std::sqrt;
    const S a = sqrt(p[kArea] / S(std::numbers::pi));  // radius of the disc of that area
    if (!given[kMa]) p[kMa] = S(8.0 / 3.0) * p[kFluidDensity] * a * a * a;
    if (!given[kLength]) p[kLength] = S(2.0) * a;
  }

  static Scales scales(const double* p) {
    const double m = inertia(p);
    return drag_scales(weight(p) / m, drag(p[kCD], p) / m, drag(kLeastDragCoefficient, p) / m);
  }
};

}  // namespace

std::shared_ptr<const Model> vertical_fall() {
  return std::make_shared<LawModel<VerticalFall>>();
}

}  // namespace samara::models::laws
