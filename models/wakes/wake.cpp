#include "samara/models/wakes/wake.h"

#include <numbers>

namespace samara::models::laws {

namespace {

/// Chords: with the memory of a half, nearest to Wagner's function.
constexpr double kWagnersLag = 3.4;

ParameterInfo lag(const char* name, const char* description) {
  return with_default(positive(name, "1", description), kWagnersLag);
}

}  // namespace

Parameters wake_parameters() {
  constexpr double kDegree = std::numbers::pi / 180.0;
  ParameterInfo stall =
      with_default(positive("stall_angle", "rad", "angle of attack at which half of the flow is attached"),
                   14.0 * kDegree);
  stall.upper = 90.0 * kDegree;
  return {
      share("memory_T", 0.5,
            "share of the translational circulation that lags; Wagner: 1/2, quasi-steady: 0"),
      share("memory_R", 0.5, "share of the rotational circulation that lags; Wagner: 1/2, quasi-steady: 0"),
      lag("lag_T", "chords travelled in which it comes within 1/e of its quasi-steady value"),
      lag("lag_R", "chords travelled in which it comes within 1/e of its quasi-steady value"),
      not_negative("C_TA", "1", 0.0, "translational lift that attached flow adds to C_T; measured: 1.65"),
      not_negative("C_DA", "1", 0.0, "drag broadside that attached flow adds; measured: 3.1"),
      stall,
      not_negative("cp_attached", "1", 0.0,
                   "chords of the centre of pressure towards the leading edge, attached; measured: 0.3"),
      not_negative("cp_slope", "1", 0.0, "its decrease per sin(angle of attack)^2; measured: 3"),
      not_negative("cp_separated", "1", 0.0,
                   "chords of the centre of pressure over cos(angle of attack), separated; measured: 0.25"),
  };
}

}  // namespace samara::models::laws
