#pragma once

/// Vectors of three components for laws: any scalar, no branches, nothing else.
namespace samara::models::laws {

template <class S>
struct Vector3 {
  S x = S(0.0);
  S y = S(0.0);
  S z = S(0.0);
};

template <class S>
Vector3<S> vector3(const S* components) {
  return {components[0], components[1], components[2]};
}

template <class S>
void store(const Vector3<S>& u, S* components) {
  components[0] = u.x;
  components[1] = u.y;
  components[2] = u.z;
}

template <class S>
Vector3<S> operator+(const Vector3<S>& u, const Vector3<S>& v) {
  return {u.x + v.x, u.y + v.y, u.z + v.z};
}

template <class S>
Vector3<S> operator-(const Vector3<S>& u, const Vector3<S>& v) {
  return {u.x - v.x, u.y - v.y, u.z - v.z};
}

template <class S>
Vector3<S> operator*(const S& factor, const Vector3<S>& u) {
  return {factor * u.x, factor * u.y, factor * u.z};
}

template <class S>
S dot(const Vector3<S>& u, const Vector3<S>& v) {
  return u.x * v.x + u.y * v.y + u.z * v.z;
}

template <class S>
Vector3<S> cross(const Vector3<S>& u, const Vector3<S>& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

/// diag(d) u
template <class S>
Vector3<S> diagonal_times(const Vector3<S>& d, const Vector3<S>& u) {
  return {d.x * u.x, d.y * u.y, d.z * u.z};
}

/// diag(d)^-1 u, by reciprocals: where d is made of parameters, a loop over steps takes them once.
template <class S>
Vector3<S> diagonal_solve(const Vector3<S>& d, const Vector3<S>& u) {
  return {(S(1.0) / d.x) * u.x, (S(1.0) / d.y) * u.y, (S(1.0) / d.z) * u.z};
}

}  // namespace samara::models::laws
