#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace samara::models {

/// Value and K tangents of forward differentiation over a scalar or a SIMD pack S: what ceres::Jet is for
/// doubles, without Eigen inside, which packs do not fit into. It has what laws use and no more.
template <class S, int K>
struct Dual {
  S a;                 ///< value
  std::array<S, K> v;  ///< tangents

  Dual() = default;
  explicit Dual(double constant) : a(constant) { v.fill(S(0.0)); }

  /// A value whose tangents are those of `x` times `slope`.
  static Dual chain(const S& value, const S& slope, const Dual& x) {
    Dual f;
    f.a = value;
    for (std::size_t k = 0; k < K; ++k) f.v[k] = slope * x.v[k];
    return f;
  }

  Dual& operator+=(const Dual& y) { return *this = *this + y; }
  Dual& operator-=(const Dual& y) { return *this = *this - y; }
  Dual& operator*=(const Dual& y) { return *this = *this * y; }
  Dual& operator/=(const Dual& y) { return *this = *this / y; }

  friend Dual operator-(const Dual& x) {
    Dual f;
    f.a = -x.a;
    for (std::size_t k = 0; k < K; ++k) f.v[k] = -x.v[k];
    return f;
  }
  friend Dual operator+(const Dual& x, const Dual& y) {
    Dual f;
    f.a = x.a + y.a;
    for (std::size_t k = 0; k < K; ++k) f.v[k] = x.v[k] + y.v[k];
    return f;
  }
  friend Dual operator-(const Dual& x, const Dual& y) {
    Dual f;
    f.a = x.a - y.a;
    for (std::size_t k = 0; k < K; ++k) f.v[k] = x.v[k] - y.v[k];
    return f;
  }
  friend Dual operator*(const Dual& x, const Dual& y) {
    Dual f;
    f.a = x.a * y.a;
    for (std::size_t k = 0; k < K; ++k) f.v[k] = x.v[k] * y.a + x.a * y.v[k];
    return f;
  }
  friend Dual operator/(const Dual& x, const Dual& y) {
    Dual f;
    const S inverse = S(1.0) / y.a;
    f.a = x.a / y.a;
    for (std::size_t k = 0; k < K; ++k) f.v[k] = (x.v[k] - f.a * y.v[k]) * inverse;
    return f;
  }

  friend Dual sqrt(const Dual& x) {
    using std::sqrt;
    const S root = sqrt(x.a);
    return chain(root, S(0.5) / root, x);
  }
  friend Dual sin(const Dual& x) {
    using std::cos;
    using std::sin;
    return chain(sin(x.a), cos(x.a), x);
  }
  friend Dual cos(const Dual& x) {
    using std::cos;
    using std::sin;
    return chain(cos(x.a), -sin(x.a), x);
  }
  friend Dual exp(const Dual& x) {
    using std::exp;
    const S value = exp(x.a);
    return chain(value, value, x);
  }
  friend Dual log(const Dual& x) {
    using std::log;
    return chain(log(x.a), S(1.0) / x.a, x);
  }
  friend Dual abs(const Dual& x) {
    using std::abs;
    using std::copysign;
    return chain(abs(x.a), copysign(S(1.0), x.a), x);
  }
  friend Dual atan2(const Dual& y, const Dual& x) {
    using std::atan2;
    const S inverse = S(1.0) / (x.a * x.a + y.a * y.a);
    Dual f;
    f.a = atan2(y.a, x.a);
    for (std::size_t k = 0; k < K; ++k) f.v[k] = (x.a * y.v[k] - y.a * x.v[k]) * inverse;
    return f;
  }
};

}  // namespace samara::models
