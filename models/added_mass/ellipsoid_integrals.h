#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

/// Added mass of an ellipsoid for any scalar with derivatives (double, Dual<double, N>).
///
/// The integrals over the outside of the ellipsoid (H. Lamb, Hydrodynamics, 6th ed., 1932, art. 114;
/// semi-axes a, b, c in any order, Delta = sqrt((a^2+s)(b^2+s)(c^2+s)))
///
///   A    = abc Int_0^inf ds / ((a^2+s) Delta)            B, C by cyclic permutation, A + B + C = 2
///   D_bc = abc Int_0^inf ds / ((b^2+s) (c^2+s) Delta)    = (C-B)/(b^2-c^2)
///
/// are symmetric integrals of Carlson's kind and are found by duplication (B. C. Carlson, Numerical
/// computation of real or complex elliptic integrals, Numer. Algorithms 10, 1995, 13-26; DLMF 19.36(i)):
/// every step adds a positive term and brings the three arguments four times closer together, until a short
/// series ends it. The same argument, applied to the difference of two of Carlson's R_D, gives D_bc without a
/// difference (`rd_slope`), so that nothing here cancels, whether axes are nearly equal or a million times
/// apart.
///
/// Branches look at values only: not for SIMD packs.
namespace samara::models::added_mass {

template <class S>
double scalar_part(const S& s) {
  if constexpr (std::is_arithmetic_v<S>) {
    return s;
  } else {
    return s.a;
  }
}

/// Carlson's function R_{-k}(b; z) = k Int_0^inf prod_i (s + z_i)^(-b_i) ds, k = b_1 + b_2 + b_3 - 1, for
/// nearly equal arguments: Taylor's series about their weighted mean, whose terms of degree N are k/(k+N)
/// times the coefficients of t^N in prod_i (1 - t Z_i)^(-b_i), Z_i = 1 - z_i/mean. Cut off after degree 7.
template <class S>
S carlson_series(const double (&b)[3], const S (&z)[3]) {
  using std::sqrt;
  const double c = b[0] + b[1] + b[2];
  const double k = c - 1.0;
  const S mean = (S(b[0]) * z[0] + S(b[1]) * z[1] + S(b[2]) * z[2]) / S(c);
  S s[8];  // s[n] = sum_i b_i Z_i^n / n; s[1] = 0 by the choice of the mean
  for (S& s_n : s) s_n = S(0.0);
  for (int i = 0; i < 3; ++i) {
    const S Z = (mean - z[i]) / mean;
    S power = Z;
    for (int n = 2; n < 8; ++n) {
      power = power * Z;
      s[n] = s[n] + S(b[i] / n) * power;
    }
  }
  const S terms[] = {S(1.0),
                     S(0.0),
                     s[2],
                     s[3],
                     s[4] + S(0.5) * s[2] * s[2],
                     s[5] + s[2] * s[3],
                     s[6] + s[2] * s[4] + S(0.5) * s[3] * s[3] + s[2] * s[2] * s[2] / S(6.0),
                     s[7] + s[2] * s[5] + s[3] * s[4] + S(0.5) * s[2] * s[2] * s[3]};
  S sum = S(0.0);
  for (int n = 7; n >= 0; --n) sum = sum + S(k / (k + n)) * terms[n];
  // mean^(-k) with k = 3/2 or 5/2.
  S scale = sqrt(mean) * mean;
  if (k > 2.0) scale = scale * mean;
  return sum / scale;
}

/// Whether three arguments are so close that the series errs by less than round-off: its first neglected
/// term is of the order 0.005^8 = 4e-19, and its derivative by an argument 0.005^7 = 8e-17.
template <class S>
bool nearly_equal(const S (&z)[3]) {
  const auto [least, greatest] = std::minmax({scalar_part(z[0]), scalar_part(z[1]), scalar_part(z[2])});
  return greatest - least < 0.005 * least;
}

/// Arguments as far apart as doubles can be take about 20 steps; NaN must not take more.
inline constexpr int kMostSteps = 40;

/// One step of duplication: lambda, and the roots of the arguments before it.
template <class S>
struct Duplication {
  S root[3];
  S lambda;

  explicit Duplication(const S (&z)[3]) {
    using std::sqrt;
    for (int i = 0; i < 3; ++i) root[i] = sqrt(z[i]);
    lambda = root[0] * root[1] + root[1] * root[2] + root[2] * root[0];
  }
  void apply(S (&z)[3]) const {
    for (S& z_i : z) z_i = S(0.25) * (z_i + lambda);
  }
};

/// Carlson's R_D(x, y, z) = 3/2 Int_0^inf ds / ((z+s) sqrt((x+s)(y+s)(z+s))), for positive arguments.
template <class S>
S carlson_rd(const S& x, const S& y, const S& z) {
  S v[3] = {x, y, z};
  S sum = S(0.0);
  double weight = 1.0;
  for (int n = 0; n < kMostSteps && !nearly_equal(v); ++n) {
    const Duplication<S> step(v);
    sum = sum + S(3.0 * weight) / (step.root[2] * (v[2] + step.lambda));
    weight *= 0.25;
    step.apply(v);
  }
  return sum + S(weight) * carlson_series<S>({0.5, 0.5, 1.5}, v);
}

/// (R_D(x,y,z) - R_D(x,z,y)) / (y-z) = 3/2 Int_0^inf ds / ((y+s)(z+s) sqrt((x+s)(y+s)(z+s))).
///
/// Duplication adds 3/(root(z)(z+lambda)) to R_D(x,y,z); the difference of two of these divided by y-z is
/// 3 (y + root(yz) + z + lambda) / ((root(y)+root(z)) root(yz) (y+lambda)(z+lambda)), and y-z itself shrinks
/// by four.
template <class S>
S rd_slope(const S& x, const S& y, const S& z) {
  S v[3] = {x, y, z};
  S sum = S(0.0);
  double weight = 1.0;
  for (int n = 0; n < kMostSteps && !nearly_equal(v); ++n) {
    const Duplication<S> step(v);
    const S root_yz = step.root[1] * step.root[2];
    const S& lambda = step.lambda;
    sum = sum + S(3.0 * weight) * (v[1] + root_yz + v[2] + lambda) /
                    ((step.root[1] + step.root[2]) * root_yz * (v[1] + lambda) * (v[2] + lambda));
    weight /= 16.0;
    step.apply(v);
  }
  return sum + S(0.6 * weight) * carlson_series<S>({0.5, 1.5, 1.5}, v);
}

/// A, B, C of the file comment, for positive semi-axes.
template <class S>
void ellipsoid_shape_integrals(const S& a, const S& b, const S& c, S* ABC) {
  const S factor = S(2.0 / 3.0) * a * b * c;
  const S a2 = a * a, b2 = b * b, c2 = c * c;
  ABC[0] = factor * carlson_rd(b2, c2, a2);
  ABC[1] = factor * carlson_rd(c2, a2, b2);
  ABC[2] = factor * carlson_rd(a2, b2, c2);
}

/// J_x/m_f, the added inertia about the axis of a:
///
///   J_x/m_f = 1/5 (b^2-c^2)^2 D_bc / (2 - (b^2+c^2) D_bc),    2 - (b^2+c^2) D_bc = A + 2 (B - c^2 D_bc),
///
/// where B - c^2 D_bc = abc Int s ds / ((b^2+s)(c^2+s) Delta) = C - b^2 D_bc loses less than a digit if the
/// smaller axis is taken for c.
template <class S>
S ellipsoid_added_inertia_about_a(const S& a, const S& b, const S& c, const S& A, const S& B, const S& C) {
  const S D = S(2.0 / 3.0) * a * b * c * rd_slope<S>(a * a, b * b, c * c);
  const S rest = scalar_part(c) < scalar_part(b) ? B - c * c * D : C - b * b * D;
  const S difference = (b - c) * (b + c);
  return S(0.2) * difference * difference * D / (A + S(2.0) * rest);
}

/// Added mass and added inertia about the three axes, over the mass m_f = 4/3 pi fluid_density abc of the
/// displaced fluid: mass_over_mf dimensionless, inertia_over_mf in the unit of the semi-axes squared; three
/// numbers each. Semi-axes positive, in any order.
template <class S>
void ellipsoid_added_mass(const S& a, const S& b, const S& c, S* mass_over_mf, S* inertia_over_mf) {
  S ABC[3];
  ellipsoid_shape_integrals(a, b, c, ABC);
  const auto& [A, B, C] = ABC;
  mass_over_mf[0] = A / (B + C);
  mass_over_mf[1] = B / (C + A);
  mass_over_mf[2] = C / (A + B);
  inertia_over_mf[0] = ellipsoid_added_inertia_about_a(a, b, c, A, B, C);
  inertia_over_mf[1] = ellipsoid_added_inertia_about_a(b, c, a, B, C, A);
  inertia_over_mf[2] = ellipsoid_added_inertia_about_a(c, a, b, C, A, B);
}

}  // namespace samara::models::added_mass
