#pragma once

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include <Eigen/Dense>

/// Numbers, columns and matrices that know their rates: what printed equations (printed_equations.h) compute with.
namespace printed {

/// A number, column or matrix with its rate along the motion.
struct Quantity {
  Eigen::MatrixXd value, rate;

  Quantity() : Quantity(0.0) {}
  Quantity(double number)
      : value(Eigen::MatrixXd::Constant(1, 1, number)), rate(Eigen::MatrixXd::Zero(1, 1)) {}
  Quantity(double number, double its_rate)
      : value(Eigen::MatrixXd::Constant(1, 1, number)), rate(Eigen::MatrixXd::Constant(1, 1, its_rate)) {}
  Quantity(Eigen::MatrixXd matrix, Eigen::MatrixXd its_rate)
      : value(std::move(matrix)), rate(std::move(its_rate)) {}

  bool is_number() const { return value.size() == 1; }
  double number() const {
    if (!is_number()) throw std::runtime_error("a column stands where a number is expected");
    return value(0, 0);
  }
  double number_rate() const { return rate(0, 0); }
};

/// Of a bilinear product, the value and its rate.
template <class Product>
Quantity bilinear(const Quantity& a, const Quantity& b, const Product& product) {
  return {product(a.value, b.value), product(a.rate, b.value) + product(a.value, b.rate)};
}

inline Quantity sum(Quantity a, const Quantity& b, double sign) {
  // A number beside a matrix stands for so many times the identity.
  if (a.is_number() && b.value.cols() > 1) {
    const auto one = Eigen::MatrixXd::Identity(b.value.rows(), b.value.cols());
    a = {a.number() * one, a.number_rate() * one};
  }
  if (a.value.rows() != b.value.rows() || a.value.cols() != b.value.cols())
    throw std::runtime_error("a sum of unlike quantities");
  return {a.value + sign * b.value, a.rate + sign * b.rate};
}

inline Eigen::MatrixXd hamilton(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::Vector3d v = a.bottomRows(3), w = b.bottomRows(3);
  Eigen::Vector4d q;
  q << a(0) * b(0) - v.dot(w), a(0) * w + b(0) * v + v.cross(w);
  return q;
}

inline Quantity times(const Quantity& a, const Quantity& b) {
  using Matrix = Eigen::MatrixXd;
  if (a.is_number() || b.is_number()) {
    const Quantity& number = a.is_number() ? a : b;
    const Quantity& other = a.is_number() ? b : a;
    return bilinear(number, other, [](const Matrix& s, const Matrix& m) -> Matrix { return s(0, 0) * m; });
  }
  if (a.value.cols() == b.value.rows())
    return bilinear(a, b, [](const Matrix& m, const Matrix& n) -> Matrix { return m * n; });
  if (a.value.size() == 4 && b.value.size() == 4) return bilinear(a, b, hamilton);
  throw std::runtime_error("a product of quantities that have none");
}

inline Quantity cross(const Quantity& a, const Quantity& b) {
  if (a.value.size() != 3 || b.value.size() != 3)
    throw std::runtime_error("a cross product of other than vectors");
  return bilinear(a, b, [](const Eigen::MatrixXd& v, const Eigen::MatrixXd& w) -> Eigen::MatrixXd {
    return Eigen::Vector3d(v).cross(Eigen::Vector3d(w));
  });
}

/// f(a) with its derivative.
inline Quantity of_number(const Quantity& a, double value, double slope) {
  return {value, slope * a.number_rate()};
}

inline Quantity power(const Quantity& a, double exponent) {
  return of_number(a, std::pow(a.number(), exponent), exponent * std::pow(a.number(), exponent - 1.0));
}

/// Euclidean length of a column, or the absolute value of a number.
inline Quantity length(const Quantity& a) {
  const double size = a.value.norm();
  return {size, size == 0.0 ? 0.0 : (a.value.transpose() * a.rate)(0, 0) / size};
}

inline Quantity column(const std::vector<Quantity>& parts) {
  Eigen::Index rows = 0;
  for (const Quantity& part : parts) rows += part.value.rows();
  Quantity all(Eigen::MatrixXd(rows, 1), Eigen::MatrixXd(rows, 1));
  rows = 0;
  for (const Quantity& part : parts) {
    all.value.middleRows(rows, part.value.rows()) = part.value;
    all.rate.middleRows(rows, part.value.rows()) = part.rate;
    rows += part.value.rows();
  }
  return all;
}

}  // namespace printed
