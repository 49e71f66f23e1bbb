#include "samara/flow/grid/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"

namespace samara::flow {

namespace {

/// Distance from an ellipsoid: its nearest point is a_i^2 y_i/(t + a_i^2) where t solves
/// sum (a_i y_i/(t + a_i^2))^2 = 1 (D. Eberly, Distance from a point to an ellipse, an ellipsoid, or a
/// hyperellipsoid). The largest root is bracketed, and the sum falls along it.
double ellipsoid_distance(const Eigen::Vector3d& axes, int dimensions, const Eigen::Vector3d& point) {
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  for (int d = 0; d < dimensions; ++d) y(d) = std::abs(point(d));
  const double least = axes.head(dimensions).minCoeff();
  if (axes.head(dimensions).maxCoeff() == least) return y.norm() - least;
  const auto sum_at = [&](double t) {
    double sum = 0.0;
    for (int d = 0; d < dimensions; ++d) {
      const double term = axes(d) * y(d) / (t + axes(d) * axes(d));
      sum += term * term;
    }
    return sum;
  };
  double low = -least * least, high = low;
  for (int d = 0; d < dimensions; ++d) high += axes(d) * y(d);
  for (int d = 0; d < dimensions; ++d) high = std::max(high, axes(d) * y.norm());
  for (int halving = 0; halving < 200 && high - low > 1e-15 * (std::abs(high) + least * least); ++halving) {
    const double middle = 0.5 * (low + high);
    (sum_at(middle) > 1.0 ? low : high) = middle;
  }
  const double t = 0.5 * (low + high);
  double squared = 0.0, on_surface = 0.0;
  bool leaves_plane = false;
  for (int d = 0; d < dimensions; ++d) {
    // Inside, near the plane of the longer axes, the nearest point leaves that plane along the shortest.
    const double scale = t + axes(d) * axes(d);
    if (scale < 1e-12 * least * least) {
      leaves_plane = true;
      continue;
    }
    const double nearest = axes(d) * y(d) / scale;
    squared += std::pow(t * y(d) / scale, 2);
    on_surface += nearest * nearest;
  }
  if (leaves_plane) squared += least * least * std::max(0.0, 1.0 - on_surface);
  return t >= 0.0 ? std::sqrt(squared) : -std::sqrt(squared);
}

double box_distance(const Eigen::Vector3d& half, int dimensions, const Eigen::Vector3d& point) {
  double squared = 0.0;
  double inside = -std::numeric_limits<double>::infinity();
  for (int d = 0; d < dimensions; ++d) {
    const double beyond = std::abs(point(d)) - half(d);
    inside = std::max(inside, beyond);
    squared += std::pow(std::max(beyond, 0.0), 2);
  }
  return inside > 0.0 ? std::sqrt(squared) : inside;
}

/// To the nearest edge; inside where a ray crosses an odd number of edges.
double polygon_distance(const Eigen::Matrix2Xd& corners, const Eigen::Vector3d& point) {
  const Eigen::Vector2d p = point.head<2>();
  double squared = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (Eigen::Index i = 0, before = corners.cols() - 1; i < corners.cols(); before = i++) {
    const Eigen::Vector2d a = corners.col(before), b = corners.col(i);
    const double along = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    squared = std::min(squared, (p - a - along * (b - a)).squaredNorm());
    if ((a.y() > p.y()) != (b.y() > p.y())) {
      const double crossing = a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      if (p.x() < crossing) inside = !inside;
    }
  }
  return inside ? -std::sqrt(squared) : std::sqrt(squared);
}

/// Radius of the widest circle within a polygon, to kThicknessError of it, or 1e-5 of the extent: squares that hold no
/// centre of a wider one are dropped, the others quartered.
double widest_circle(const Eigen::Matrix2Xd& corners) {
  struct Square {
    Eigen::Vector2d centre;
    double half;
    double depth;  ///< of its centre within the polygon
    double most() const { return depth + std::sqrt(2.0) * half; }
    bool operator<(const Square& other) const { return most() < other.most(); }
  };
  const auto square_at = [&](const Eigen::Vector2d& centre, double half) {
    return Square{centre, half, -polygon_distance(corners, {centre.x(), centre.y(), 0.0})};
  };
  const Eigen::Vector2d low = corners.rowwise().minCoeff(), size = corners.rowwise().maxCoeff() - low;
  // In a row along the longer side, so that the middle of a strip is the centre of one.
  const double side = std::max(size.minCoeff(), 1e-3 * size.maxCoeff());
  const auto along = static_cast<int>(std::ceil(size.maxCoeff() / side));
  std::priority_queue<Square> squares;
  double widest = 0.0;
  const auto consider = [&](const Square& square) {
    widest = std::max(widest, square.depth);
    squares.push(square);
  };
  for (int k = 0; k < along; ++k) {
    const Eigen::Vector2d step =
        size.x() > size.y() ? Eigen::Vector2d(k + 0.5, 0.5) : Eigen::Vector2d(0.5, k + 0.5);
    consider(square_at(low + side * step, 0.5 * side));
  }
  while (squares.top().most() > widest + std::max(kThicknessError * widest, 1e-5 * size.maxCoeff())) {
    const Square square = squares.top();
    squares.pop();
    for (const Eigen::Vector2d& to :
         {Eigen::Vector2d(-1, -1), Eigen::Vector2d(-1, 1), Eigen::Vector2d(1, -1), Eigen::Vector2d(1, 1)})
      consider(square_at(square.centre + 0.5 * square.half * to, 0.5 * square.half));
  }
  return widest;
}

/// @throws ArgumentError if two edges of a polygon cross: then it has no inside
void require_simple(const Eigen::Matrix2Xd& corners) {
  const Eigen::Index count = corners.cols();
  const auto side = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
    return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
  };
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2d a = corners.col(i), b = corners.col((i + 1) % count);
    for (Eigen::Index j = i + 2; j < count; ++j) {
      const Eigen::Vector2d c = corners.col(j), d = corners.col((j + 1) % count);
      if (side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0)
        throw ArgumentError(fmt::format(
            "polygon_section: the edges from corners {} and {} cross, expected an outline that does not",
            i + 1, j + 1));
    }
  }
}

Shape ellipsoid_of(const Eigen::Vector3d& axes, int dimensions, const char* kind) {
  Eigen::Vector3d half = axes;
  if (dimensions == 2) half.z() = 0.0;
  return {kind,
          dimensions,
          [axes, dimensions](const Eigen::Vector3d& x) { return ellipsoid_distance(axes, dimensions, x); },
          half,
          2.0 * axes.head(dimensions).minCoeff(),
          (dimensions == 2 ? M_PI : 4.0 / 3.0 * M_PI) * axes.head(dimensions).prod(),
          {axes.data(), axes.data() + dimensions}};
}

Shape box_of(const Eigen::Vector3d& sides, int dimensions, const char* kind) {
  Eigen::Vector3d half = 0.5 * sides;
  if (dimensions == 2) half.z() = 0.0;
  return {kind,
          dimensions,
          [half, dimensions](const Eigen::Vector3d& x) { return box_distance(half, dimensions, x); },
          half,
          sides.head(dimensions).minCoeff(),
          sides.head(dimensions).prod(),
          {sides.x(), sides.y(), sides.z()}};
}

bool is_round(const Shape& shape) {
  return shape.kind == "ellipse" || shape.kind == "ellipsoid";
}

}  // namespace

Shape ellipse_section(double semi_x, double semi_y) {
  require_positive(semi_x, "semi_x", "ellipse_section");
  require_positive(semi_y, "semi_y", "ellipse_section");
  return ellipsoid_of({semi_x, semi_y, 1.0}, 2, "ellipse");
}

Shape rectangle_section(double side_x, double side_y) {
  require_positive(side_x, "side_x", "rectangle_section");
  require_positive(side_y, "side_y", "rectangle_section");
  return box_of({side_x, side_y, 0.0}, 2, "rectangle");
}

Shape baffle_section(double length) {
  require_positive(length, "length", "baffle_section");
  const Eigen::Vector3d half(0.5 * length, 0.0, 0.0);
  return {.kind = "baffle",
          .dimensions = 2,
          .distance = [half](const Eigen::Vector3d& x) { return box_distance(half, 2, x); },
          .half = half,
          .sizes = {length},
          .baffle = true};
}

Shape polygon_section(const Eigen::Matrix2Xd& corners) {
  require(corners.cols() >= 3, "corners", corners.cols(), "at least 3", "polygon_section");
  if (!corners.allFinite()) throw ArgumentError("polygon_section: a corner is not finite");
  double area = 0.0;
  for (Eigen::Index i = 0, before = corners.cols() - 1; i < corners.cols(); before = i++)
    area += 0.5 * (corners(0, before) * corners(1, i) - corners(0, i) * corners(1, before));
  const Eigen::Vector2d low = corners.rowwise().minCoeff(), high = corners.rowwise().maxCoeff();
  require(std::abs(area) > 1e-9 * (high - low).squaredNorm(), "area of the corners", area, "not 0",
          "polygon_section");
  require_simple(corners);
  const Eigen::Vector2d centre = 0.5 * (low + high);
  const Eigen::Matrix2Xd about_centre = corners.colwise() - centre;
  const Eigen::Vector2d half = 0.5 * (high - low);
  Eigen::Matrix3Xd in_space = Eigen::Matrix3Xd::Zero(3, corners.cols());
  in_space.topRows<2>() = about_centre;
  const double radius = widest_circle(about_centre);
  require(radius > 0.0, "radius of the widest circle within", radius, "more than 1e-5 of the extent",
          "polygon_section");
  return {"polygon",
          2,
          [about_centre](const Eigen::Vector3d& x) { return polygon_distance(about_centre, x); },
          {half.x(), half.y(), 0.0},
          2.0 * radius,
          std::abs(area),
          {corners.data(), corners.data() + corners.size()},
          std::move(in_space)};
}

Shape ellipsoid_shape(const Eigen::Vector3d& semi_axes) {
  for (int d = 0; d < 3; ++d) require_positive(semi_axes(d), "semi-axis", "ellipsoid_shape");
  return ellipsoid_of(semi_axes, 3, "ellipsoid");
}

Shape box_shape(const Eigen::Vector3d& sides) {
  for (int d = 0; d < 3; ++d) require_positive(sides(d), "side", "box_shape");
  return box_of(sides, 3, "box");
}

PlacedShape::PlacedShape(Shape shape, const Eigen::Vector3d& place, double angle_of_attack)
    : shape_(std::move(shape)) {
  move_to(place, angle_of_attack);
}

void PlacedShape::move_to(const Eigen::Vector3d& place, double angle_of_attack) {
  if (!place.allFinite() || !std::isfinite(angle_of_attack))
    throw ArgumentError(
        fmt::format("the place ({}, {}, {}) or the angle of attack {} of a body is not finite", place.x(),
                    place.y(), place.z(), angle_of_attack));
  place_ = place;
  cosine_ = std::cos(angle_of_attack);
  sine_ = std::sin(angle_of_attack);
  const Eigen::Vector3d& h = shape_.half;
  const double c = std::abs(cosine_), s = std::abs(sine_);
  if (is_round(shape_)) {
    high_ = {std::hypot(c * h.x(), s * h.y()), std::hypot(s * h.x(), c * h.y()), h.z()};
  } else {
    high_ = {c * h.x() + s * h.y(), s * h.x() + c * h.y(), h.z()};
  }
  low_ = -high_;
  if (shape_.corners.size() == 0) return;
  low_.setConstant(INFINITY);
  high_.setConstant(-INFINITY);
  for (const auto& corner : shape_.corners.colwise()) {
    const Eigen::Vector3d turned(cosine_ * corner.x() + sine_ * corner.y(),
                                 cosine_ * corner.y() - sine_ * corner.x(), corner.z());
    low_ = low_.cwiseMin(turned);
    high_ = high_.cwiseMax(turned);
  }
}

Eigen::Vector3d PlacedShape::in_axes(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d r = point - place_;
  return {cosine_ * r.x() - sine_ * r.y(), sine_ * r.x() + cosine_ * r.y(), r.z()};
}

double PlacedShape::distance(const Eigen::Vector3d& point) const {
  return shape_.distance(in_axes(point));
}

bool PlacedShape::separates(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
  if (!shape_.baffle) return false;
  const Eigen::Vector3d from = in_axes(a), to = in_axes(b);
  if ((from.y() >= 0.0) == (to.y() >= 0.0)) return false;
  const double crossing = from.x() + from.y() / (from.y() - to.y()) * (to.x() - from.x());
  return std::abs(crossing) <= shape_.half.x();
}

double PlacedShape::frontal_size() const {
  const double height = high_.y() - low_.y();
  if (shape_.dimensions == 2) return height;
  return height * 2.0 * shape_.half.z() * (is_round(shape_) ? 0.25 * M_PI : 1.0);
}

}  // namespace samara::flow
