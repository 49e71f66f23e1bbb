#include "samara/models/laws/ambient_policies.h"
#include "samara/models/laws/sphere_flight.h"

namespace samara::models::laws {

namespace {

/// Kirchhoff's equation for a sphere in a fluid that accelerates: with v_r = v - w_air,
///   (m + m_a) v_r' = F(v_r) + m_f Dw_air/Dt - m dw_air/dt - m_a (grad w_air)^T v_r.
struct SphereFlightInGusts {
  static constexpr int kStates = SphereFlight::kStates;
  static constexpr int kGust = SphereFlight::kParameters;
  static constexpr int kParameters = kGust + GustRamp::kParameters;
  enum Term { kAmbient = SphereFlight::kTerms, kTerms };

  static ModelInfo info() {
    ModelInfo info = SphereFlight::info();
    info.name = "sphere_flight_in_gusts";
    info.title = "Spinning sphere in flight, in a fluid that changes in time";
    info.equations =
        "(m + m_a) v_r' = -1/2 rho A (C_D (1 + Re_drag/Re) + spin_drag S) V v_r + 1/2 rho A C_M r w_r x "
        "v_r/(1 + magnus_saturation S) + (m - m_f) (0, 0, -g) + m_f a_f - m dw_air/dt - m_a W^T v_r;  "
        "v_r = v - w_air;  "
        "(x, y, z)' = v;  w' = -spin_decay w_r;  w_r = w - (gust_spin_x, gust_spin_y, gust_spin_z);  "
        "V = sqrt(|v_r|^2 + speed_floor^2);  S = sqrt(r^2 |w_r|^2 + speed_floor^2)/V;  "
        "Re = diameter V/nu;  A = pi r^2;  r = diameter/2;  rho = fluid_density;  m = mass;  "
        "m_a = added_mass;  m_f = displaced_mass;  "
        "w_air = (gust_x, gust_y, gust_z) + (t - gust_start) (gust_rate_x, gust_rate_y, gust_rate_z);  "
        "a_f = (gust_rate_x, gust_rate_y, gust_rate_z) - W v_r;  "
        "W has the rows (gust_gradient_xx, gust_gradient_xy, gust_gradient_xz) and so on";
    info.validity +=
        ". The fluid changes little over the diameter. Realisations (samara simulate --realisations) set "
        "the gust step by step; by itself it is one ramp in time";
    // No rotation about z: the gust would have to turn with the state.
    info.symmetries = translations();
    append(info.parameters, GustRamp::parameters());
    info.force_terms.push_back({.name = "ambient acceleration",
                                .description =
                                    "pressure gradient of the undisturbed fluid, m_f D w_air/Dt, "
                                    "less m times the rate of w_air along the path, and -m_a W^T v_r "
                                    "by its gradient W"});
    return info;
  }

  template <class S>
  static Ambient<S> air_at(const S& t, const S* x, const S* p) {
    return GustRamp().at(t, vector3(x + SphereFlight::kPosition), vector3(x + SphereFlight::kV), p + kGust);
  }

  template <class S>
  static std::array<Load<S>, kTerms> loads(const Vector3<S>& v_r, const Vector3<S>& w_r,
                                           const Ambient<S>& air, const S* p) {
    const std::array<Load<S>, SphereFlight::kTerms> still = SphereFlight::loads(v_r, w_r, p);
    std::array<Load<S>, kTerms> all;
    for (std::size_t k = 0; k < still.size(); ++k) all[k] = still[k];
    all[kAmbient].force = p[SphereFlight::kDisplacedMass] * air.material_rate -
                          p[SphereFlight::kMass] * air.path_rate -
                          p[SphereFlight::kAddedMass] * air.gradient.transposed_times(v_r);
    return all;
  }

  template <class S>
  static void rhs(const S& t, const S* x, const S* p, S* dxdt) {
    const Ambient<S> air = air_at(t, x, p);
    const Vector3<S> v = vector3(x + SphereFlight::kV);
    Load<S> sum;
    for (const Load<S>& load : loads(v - air.velocity, vector3(x + SphereFlight::kW) - air.rotation, air, p))
      sum = sum + load;
    store(v, dxdt + SphereFlight::kPosition);
    const S mass = p[SphereFlight::kMass] + p[SphereFlight::kAddedMass];
    store((S(1.0) / mass) * sum.force + air.path_rate, dxdt + SphereFlight::kV);
    store((S(1.0) / p[SphereFlight::kInertia]) * sum.torque, dxdt + SphereFlight::kW);
  }

  template <class S>
  static void forces(const S& t, const S* x, const S* p, LawWrench<S>* terms) {
    const Ambient<S> air = air_at(t, x, p);
    const Vector3<S> v_r = vector3(x + SphereFlight::kV) - air.velocity;
    const Vector3<S> w = vector3(x + SphereFlight::kW);
    const std::array<Load<S>, kTerms> all = loads(v_r, w - air.rotation, air, p);
    for (std::size_t k = 0; k < all.size(); ++k) terms[k] = wrench(all[k], v_r, w);
  }

  template <class S>
  static S kinetic_energy(const S& t, const S* x, const S* p) {
    const Vector3<S> v_r = vector3(x + SphereFlight::kV) - air_at(t, x, p).velocity;
    const Vector3<S> w = vector3(x + SphereFlight::kW);
    return S(0.5) * ((p[SphereFlight::kMass] + p[SphereFlight::kAddedMass]) * dot(v_r, v_r) +
                     p[SphereFlight::kInertia] * dot(w, w));
  }

  template <class S>
  static void complete(const char* given, S* p) {
    SphereFlight::complete(given, p);
  }

  static Scales scales(const double* p) { return SphereFlight::scales(p); }
};

}  // namespace

std::shared_ptr<const Model> sphere_flight_in_gusts() {
  return std::make_shared<LawModel<SphereFlightInGusts>>();
}

}  // namespace samara::models::laws
