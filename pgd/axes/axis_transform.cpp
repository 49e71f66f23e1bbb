#include "samara/pgd/axes/axis_transform.h"

#include <array>
#include <cmath>

#include "samara/pgd/axes/enum_names.h"

namespace samara::pgd {

namespace {
constexpr std::array kTransformNames = {"none", "log", "reciprocal", "square_root"};
}

double transformed_distance(Transform transform, double a, double x) {
  // x - a is exact for close a and x, so no form below subtracts two values of T.
  switch (transform) {
    case Transform::none:
      return x - a;
    case Transform::logarithm:
      return std::log1p((x - a) / a);
    case Transform::reciprocal:
      return (x - a) / a / x;
    case Transform::square_root:
      return x == a ? 0.0 : (x - a) / (std::sqrt(x) + std::sqrt(a));
  }
  throw ArgumentError("no such transform");
}

double transformed_advance(Transform transform, double a, double distance) {
  switch (transform) {
    case Transform::none:
      return a + distance;
    case Transform::logarithm:
      // Near a, a small step keeps the digits of its own; far below a, the sum would lose those of x.
      return std::abs(distance) < 0.5 ? a + a * std::expm1(distance) : a * std::exp(distance);
    case Transform::reciprocal:
      return a / (1.0 - a * distance);
    case Transform::square_root:
      return a + distance * (2.0 * std::sqrt(a) + distance);
  }
  throw ArgumentError("no such transform");
}

double transform_slope(Transform transform, double x) {
  switch (transform) {
    case Transform::none:
      return 1.0;
    case Transform::logarithm:
      return 1.0 / x;
    case Transform::reciprocal:
      return 1.0 / x / x;
    case Transform::square_root:
      return 0.5 / std::sqrt(x);
  }
  throw ArgumentError("no such transform");
}

bool in_domain(Transform transform, double x) {
  switch (transform) {
    case Transform::none:
      return true;
    case Transform::logarithm:
    case Transform::reciprocal:
      return x > 0.0;
    case Transform::square_root:
      return x >= 0.0;
  }
  throw ArgumentError("no such transform");
}

std::string to_string(Transform transform) {
  return kTransformNames.at(static_cast<std::size_t>(transform));
}
Transform transform_from_string(const std::string& name) {
  return from_name<Transform>("transform", name, kTransformNames);
}

}  // namespace samara::pgd
