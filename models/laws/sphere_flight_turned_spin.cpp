#include "samara/models/laws/sphere_flight.h"

namespace samara::models::laws {

namespace {

/// The spin as a second camera saw it: its axes are turned against the world's.
struct SphereFlightTurnedSpin : SphereFlight {
  static constexpr int kSpinFrame = SphereFlight::kParameters;
  static constexpr int kParameters = kSpinFrame + 3;

  static ModelInfo info() {
    ModelInfo info = SphereFlight::info();
    info.name = "sphere_flight_turned_spin";
    info.title = "Spinning sphere in flight, its spin given in axes of its own";
    info.equations +=
        ";  everywhere but in w': R w for w, R the turn by (spin_frame_x, spin_frame_y, spin_frame_z)";
    info.frames =
        "world: z up; the spin in axes that the turn R takes to the world's; all other vectors in world "
        "axes, "
        "forces and torques too";
    // No rotation about z: the axes of the spin would have to turn with the state.
    info.symmetries = {"translation of x", "translation of y", "translation of z"};
    for (const char* name : {"spin_frame_x", "spin_frame_y", "spin_frame_z"}) {
      info.parameters.push_back(any_value(name, "rad", 0.0, "axis times angle of the turn R"));
    }
    return info;
  }

  /// Rodrigues' formula. The floor under the angle, 1e-8 rad, changes R by 1e-16.
  template <class S>
  static Vector3<S> turned(const Vector3<S>& w, const S* p) {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const Vector3<S> axis = vector3(p + kSpinFrame);
    const S angle = sqrt(dot(axis, axis) + S(1e-16));
    const S half = sin(S(0.5) * angle) / angle;
    const Vector3<S> across = cross(axis, w);
    return w + (sin(angle) / angle) * across + (S(2.0) * half * half) * cross(axis, across);
  }

  template <class S>
  static std::array<S, kStates> in_world(const S* x, const S* p) {
    std::array<S, kStates> y;
    std::copy_n(x, kStates, y.data());
    store(turned(vector3(x + kW), p), y.data() + kW);
    return y;
  }

  template <class S>
  static void rhs(const S& t, const S* x, const S* p, S* dxdt) {
    SphereFlight::rhs(t, in_world(x, p).data(), p, dxdt);
    store(-p[kSpinDecay] * vector3(x + kW), dxdt + kW);
  }

  template <class S>
  static void forces(const S& t, const S* x, const S* p, LawWrench<S>* terms) {
    SphereFlight::forces(t, in_world(x, p).data(), p, terms);
  }
};

}  // namespace

std::shared_ptr<const Model> sphere_flight_turned_spin() {
  return std::make_shared<LawModel<SphereFlightTurnedSpin>>();
}

}  // namespace samara::models::laws
