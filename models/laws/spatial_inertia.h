#pragma once

#include "samara/models/laws/rigid_body.h"

/// Inertia of a body, with or without the fluid it sets in motion, as a symmetric 6x6 matrix on (u, w).
namespace samara::models::laws {

template <class S>
struct SpatialInertia {
  S entry[6][6] = {};

  /// Adds `value` at (i, j) and (j, i).
  void add(int i, int j, const S& value) {
    entry[i][j] = entry[i][j] + value;
    if (i != j) entry[j][i] = entry[j][i] + value;
  }

  /// Adds to the linear momentum, and to its moment, what a mass of centre r has: P = m (u + w x r) and r x m
  /// u.
  void add_linear_mass(const S& m, const Vector3<S>& r) {
    for (int i = 0; i < 3; ++i) add(i, i, m);
    add(0, 4, m * r.z);
    add(0, 5, -m * r.y);
    add(1, 3, -m * r.z);
    add(1, 5, m * r.x);
    add(2, 3, m * r.y);
    add(2, 4, -m * r.x);
  }

  /// Adds a point mass m at r: L = r x P too.
  void add_mass(const S& m, const Vector3<S>& r) {
    add_linear_mass(m, r);
    const Vector3<S> m_r = m * r;
    add(3, 3, m_r.y * r.y + m_r.z * r.z);
    add(4, 4, m_r.x * r.x + m_r.z * r.z);
    add(5, 5, m_r.x * r.x + m_r.y * r.y);
    add(3, 4, -m_r.x * r.y);
    add(3, 5, -m_r.x * r.z);
    add(4, 5, -m_r.y * r.z);
  }

  /// Adds moments of inertia xx, yy, zz and, as they stand in the tensor, entries xy, xz, yz.
  void add_rotational(const S* I) {
    for (int i = 0; i < 3; ++i) add(3 + i, 3 + i, I[i]);
    add(3, 4, I[3]);
    add(3, 5, I[4]);
    add(4, 5, I[5]);
  }

  /// Whether every motion has a positive energy: the pivots of L D L^T.
  bool is_positive_definite() const {
    double L[6][6], D[6];
    for (int j = 0; j < 6; ++j) {
      D[j] = entry[j][j];
      for (int k = 0; k < j; ++k) D[j] -= L[j][k] * L[j][k] * D[k];
      if (!(D[j] > 0.0)) return false;
      for (int i = j + 1; i < 6; ++i) {
        L[i][j] = entry[i][j];
        for (int k = 0; k < j; ++k) L[i][j] -= L[i][k] * L[j][k] * D[k];
        L[i][j] /= D[j];
      }
    }
    return true;
  }

  /// Linear and angular momentum at (u, w), as the force and the torque of a Load.
  Load<S> momentum(const Vector3<S>& u, const Vector3<S>& w) const {
    const S v[6] = {u.x, u.y, u.z, w.x, w.y, w.z};
    S product[6];
    for (int i = 0; i < 6; ++i) {
      product[i] = entry[i][0] * v[0];
      for (int j = 1; j < 6; ++j) product[i] = product[i] + entry[i][j] * v[j];
    }
    return {vector3(product), vector3(product + 3)};
  }

  /// The rates (u', w') under a load: the inverse times it, by the factorisation L D L^T, for which a
  /// positive definite matrix needs no pivots.
  Load<S> solve(const Load<S>& load) const {
    S L[6][6], D[6], y[6];
    store(load.force, y);
    store(load.torque, y + 3);
    for (int j = 0; j < 6; ++j) {
      D[j] = entry[j][j];
      for (int k = 0; k < j; ++k) D[j] = D[j] - L[j][k] * L[j][k] * D[k];
      for (int i = j + 1; i < 6; ++i) {
        L[i][j] = entry[i][j];
        for (int k = 0; k < j; ++k) L[i][j] = L[i][j] - L[i][k] * L[j][k] * D[k];
        L[i][j] = L[i][j] / D[j];
        y[i] = y[i] - L[i][j] * y[j];
      }
    }
    for (int i = 5; i >= 0; --i) {
      y[i] = y[i] / D[i];
      for (int k = i + 1; k < 6; ++k) y[i] = y[i] - L[k][i] * y[k];
    }
    return {vector3(y), vector3(y + 3)};
  }
};

/// What the body's own motion adds to dP/dt = F and dL/dt = T in body axes: P x w and L x w + P x u.
template <class S>
Load<S> gyroscopic_load(const Load<S>& momentum, const Vector3<S>& u, const Vector3<S>& w) {
  return {cross(momentum.force, w), cross(momentum.torque, w) + cross(momentum.force, u)};
}

}  // namespace samara::models::laws
