#include <numbers>

#include "samara/models/law_tools/drag_scales.h"
#include "samara/models/law_tools/reynolds.h"
#include "samara/models/laws/law_model.h"

namespace samara::models::laws {

namespace {

struct QuadraticDragFall {
  static constexpr int kStates = 1;
  static constexpr int kParameters = 8;
  enum Parameter { kCD, kFluidDensity, kG, kArea, kMass, kReDrag, kNu, kLength };

  static ModelInfo info() {
    return {
        .name = "quadratic_drag_fall",
        .title = "Vertical speed alone of a heavy body in a light fluid (vertical_fall: with the height)",
        .equations =
            "u' = -(fluid_density C_D area / (2 mass)) (1 + Re_drag/Re) |u| u - g,  "
            "Re = length |u|/nu",
        .frames = "u is the vertical velocity, positive upward; forces along the third body axis, upward too",
        .source =
            "dissertation, eq. (6.20), which prints u^2 for -|u| u and so holds for u <= 0; from rest "
            "u = -u_T tanh(g t / u_T) with u_T = sqrt(2 mass g / (fluid_density C_D area))",
        .validity =
            "neither buoyancy nor added mass (vertical_fall has both, and the height): bodies much denser "
            "than the fluid; C_D constant, or as Re_drag "
            "follows Re; no rotation",
        .states = {{.name = "u", .unit = "m/s", .description = "vertical velocity, positive upward"}},
        .parameters = parameters(),
        .affine_in = {"C_D", "g"},
        .force_terms = {{.name = "drag", .description = "against the velocity; takes power"},
                        {.name = "gravity", .description = "weight"}},
    };
  }

  static std::vector<ParameterInfo> parameters() {
    return {
        {.name = "C_D",
         .unit = "1",
         .description = "drag coefficient on `area`",
         .lower = 0.0,
         .lower_inclusive = true},
        {.name = "fluid_density",
         .unit = "kg/m^3",
         .default_value = 1.23,
         .description = "density of the fluid; default: air, as in dissertation chapter 6",
         .lower = 0.0},
        {.name = "g",
         .unit = "m/s^2",
         .default_value = 9.81,
         .description = "gravitational acceleration; default as in dissertation chapter 6",
         .lower = 0.0,
         .lower_inclusive = true},
        {.name = "area",
         .unit = "m^2",
         .default_value = 0.5,
         .description = "reference area of the drag; default as in dissertation chapter 6",
         .lower = 0.0},
        {.name = "mass",
         .unit = "kg",
         .default_value = 0.1,
         .description = "mass of the body; default as in dissertation chapter 6",
         .lower = 0.0},
        Re_drag("Re = length |u|/nu"),
        viscosity_of_air(),
        derived("length", "m", "2 sqrt(area/pi)", "of Re; default: the diameter of a disc", false),
    };
  }

  /// k in u' = -k |u| u - g [1/m].
  template <class S>
  static S drag_per_mass(const S& C_D, const S* p) {
    return p[kFluidDensity] * C_D * p[kArea] / (S(2.0) * p[kMass]);
  }

  /// Drag over mass, upward [m/s^2].
  template <class S>
  static S drag(const S& u, const S* p) {
    using std::abs;
    const ReynoldsSpeeds<S> Re = reynolds_speeds(p[kReDrag], S(0.0), p[kNu], p[kLength]);
    return -drag_per_mass(p[kCD], p) * drag_speed(abs(u), Re.drag) * u;
  }

  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    dxdt[0] = drag(x[0], p) - p[kG];
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    const S& u = x[0];
    terms[0].force[2] = p[kMass] * drag(u, p);
    terms[1].force[2] = -p[kMass] * p[kG];
    for (int k = 0; k < 2; ++k) terms[k].power = terms[k].force[2] * u;
  }

  template <class S>
  static S kinetic_energy(const S&, const S* x, const S* p) {
    return S(0.5) * p[kMass] * x[0] * x[0];
  }

  template <class S>
  static void complete(const char* given, S* p) {
    using std::sqrt;
    if (!given[kLength]) p[kLength] = S(2.0) * sqrt(p[kArea] / S(std::numbers::pi));
  }

  static Scales scales(const double* p) {
    return drag_scales(p[kG], drag_per_mass(p[kCD], p), drag_per_mass(kLeastDragCoefficient, p));
  }
};

}  // namespace

std::shared_ptr<const Model> quadratic_drag_fall() {
  return std::make_shared<LawModel<QuadraticDragFall>>();
}

}  // namespace samara::models::laws
