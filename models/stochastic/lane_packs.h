#pragma once

#include <algorithm>
#include <cstddef>

#include <Eigen/Core>

#include "samara/models/batch/law_kernel.h"
#include "samara/models/law_tools/attitude.h"

/// Rows of lanes in the registers of the machine, for sources that are compiled for it and for nothing else: a
/// scalar S is a number of one lane (double), or of as many as a register holds (Pack). Both do the same operations,
/// so that a lane has the same bits in either.
namespace samara::models {

/// How many lanes rows have for `width` bodies: one, or whole registers.
inline Eigen::Index whole_packs(int width) {
  constexpr int kSize = LaneLayout<Pack>::kWidth;
  return width == 1 ? 1 : (width + kSize - 1) / kSize * kSize;
}

/// Calls run(S) for S of one lane or a pack, whichever rows of so many lanes are made of.
template <class Run>
void with_scalar_of(Eigen::Index lanes, const Run& run) {
  lanes == 1 ? run(double()) : run(Pack());
}

/// The numbers of S from a row, where that has `count` lanes from there on, which may be fewer.
template <class S>
S load_some(const double* from, std::ptrdiff_t count) {
  constexpr std::ptrdiff_t kWidth = LaneLayout<S>::kWidth;
  if (count >= kWidth) return LaneLayout<S>::load(from);
  double numbers[kWidth] = {};
  std::copy_n(from, count, numbers);
  return LaneLayout<S>::load(numbers);
}

template <class S>
void store_some(const S& value, double* to, std::ptrdiff_t count) {
  constexpr std::ptrdiff_t kWidth = LaneLayout<S>::kWidth;
  if (count >= kWidth) return LaneLayout<S>::store(value, to);
  double numbers[kWidth];
  LaneLayout<S>::store(value, numbers);
  std::copy_n(numbers, count, to);
}

/// A row of whole packs.
template <class S, class Row>
S of_row(const Row& row, Eigen::Index lane, Eigen::Index column = 0) {
  return LaneLayout<S>::load(row.data() + column * row.rows() + lane);
}
template <class S, class Row>
void to_row(const S& value, Row& row, Eigen::Index lane, Eigen::Index column = 0) {
  LaneLayout<S>::store(value, row.data() + column * row.rows() + lane);
}

template <class S, class Rows>
laws::Vector3<S> of_rows(const Rows& rows, Eigen::Index lane, Eigen::Index first = 0) {
  return {of_row<S>(rows, lane, first), of_row<S>(rows, lane, first + 1), of_row<S>(rows, lane, first + 2)};
}
template <class S, class Rows>
void to_rows(const laws::Vector3<S>& value, Rows& rows, Eigen::Index lane, Eigen::Index first = 0) {
  to_row(value.x, rows, lane, first);
  to_row(value.y, rows, lane, first + 1);
  to_row(value.z, rows, lane, first + 2);
}

template <class S, class Rows>
laws::Rotation<S> rotation_of(const Rows& rows, Eigen::Index lane) {
  return {of_rows<S>(rows, lane, 0), of_rows<S>(rows, lane, 3), of_rows<S>(rows, lane, 6)};
}
template <class S, class Rows>
void to_rows(const laws::Rotation<S>& value, Rows& rows, Eigen::Index lane) {
  to_rows(value.x_axis, rows, lane, 0);
  to_rows(value.y_axis, rows, lane, 3);
  to_rows(value.z_axis, rows, lane, 6);
}

/// A vector or a matrix that all lanes share.
template <class S>
laws::Vector3<S> for_all(const Eigen::Vector3d& u) {
  return {S(u[0]), S(u[1]), S(u[2])};
}
template <class S>
laws::Vector3<S> times(const Eigen::Matrix3d& A, const laws::Vector3<S>& u) {
  const auto row = [&](int i) { return S(A(i, 0)) * u.x + S(A(i, 1)) * u.y + S(A(i, 2)) * u.z; };
  return {row(0), row(1), row(2)};
}

inline double chosen(bool first, double a, double b) {
  return first ? a : b;
}
inline Pack chosen(const Pack::mask_type& first, const Pack& a, Pack b) {
  std::experimental::where(first, b) = a;
  return b;
}
template <class M, class S>
laws::Vector3<S> chosen(const M& first, const laws::Vector3<S>& a, const laws::Vector3<S>& b) {
  return {chosen(first, a.x, b.x), chosen(first, a.y, b.y), chosen(first, a.z, b.z)};
}

inline bool is_any(bool mask) {
  return mask;
}
inline bool is_any(const Pack::mask_type& mask) {
  return std::experimental::any_of(mask);
}

/// Whether all three are finite: zero times anything else is not a number.
template <class S>
auto all_finite(const laws::Vector3<S>& u) {
  const S zero = S(0.0) * u.x + S(0.0) * u.y + S(0.0) * u.z;
  return zero == S(0.0);
}

}  // namespace samara::models
