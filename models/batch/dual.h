#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace samara::models {

/// Value and K tangents of forward differentiation over a scalar or a SIMD pack S.
template <class S, int K>
struct Dual {
  S a;                 ///< value
  std::array<S, K> v;  ///< tangents

  Dual() = default;
  Dual(double constant) : a(constant) { v.fill(S(0.0)); }
  /// Variable number k.
  Dual(double value, std::size_t k) : Dual(value) { v[k] = S(1.0); }

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
  friend Dual tan(const Dual& x) {
    using std::tan;
    const S value = tan(x.a);
    return chain(value, S(1.0) + value * value, x);
  }
  friend Dual asin(const Dual& x) {
    using std::asin;
    using std::sqrt;
    return chain(asin(x.a), S(1.0) / sqrt(S(1.0) - x.a * x.a), x);
  }
  friend Dual acos(const Dual& x) {
    using std::acos;
    using std::sqrt;
    return chain(acos(x.a), S(-1.0) / sqrt(S(1.0) - x.a * x.a), x);
  }
  friend Dual atan(const Dual& x) {
    using std::atan;
    return chain(atan(x.a), S(1.0) / (S(1.0) + x.a * x.a), x);
  }
  friend Dual sinh(const Dual& x) {
    using std::cosh;
    using std::sinh;
    return chain(sinh(x.a), cosh(x.a), x);
  }
  friend Dual cosh(const Dual& x) {
    using std::cosh;
    using std::sinh;
    return chain(cosh(x.a), sinh(x.a), x);
  }
  friend Dual tanh(const Dual& x) {
    using std::tanh;
    const S value = tanh(x.a);
    return chain(value, S(1.0) - value * value, x);
  }
  friend Dual pow(const Dual& x, double exponent) {
    using std::pow;
    return chain(pow(x.a, S(exponent)), S(exponent) * pow(x.a, S(exponent - 1.0)), x);
  }
  /// x > 0.
  friend Dual pow(const Dual& x, const Dual& y) { return exp(y * log(x)); }
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
