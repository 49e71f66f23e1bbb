#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

/// Bodies in a flow, as signed distances: positive in the fluid, negative inside, 0 on the surface.
namespace samara::flow {

/// Of a thickness that was found, as a share of it.
inline constexpr double kThicknessError = 1e-3;

/// A shape in its own axes about its own centre. A section of the plane is a cylinder along z.
struct Shape {
  std::string kind;
  int dimensions = 2;  ///< 2: a section, whose distance does not look at z
  std::function<double(const Eigen::Vector3d&)> distance;
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  ///< half the extents along its axes
  double thickness = 0.0;          ///< where it is thinnest; of a polygon, of the widest circle within
  double volume = 0.0;             ///< of a section: its area
  std::vector<double> sizes = {};  ///< as given, corners of a polygon one after the other
  Eigen::Matrix3Xd corners = {};   ///< of a polygon or a mesh, in its axes: what its turned extents are of
  /// A plate without thickness along x, from -half.x to half.x: it closes faces, and its distance is never negative.
  bool baffle = false;
};

// All throw ArgumentError if a size is not positive and finite.

/// Ellipse with semi-axes along x and y; a circle where they are equal.
Shape ellipse_section(double semi_x, double semi_y);
/// Rectangle with full sides along x and y. A plate is a thin one.
Shape rectangle_section(double side_x, double side_y);
/// A plate of no thickness along x: for bodies thinner than two cells. Its surface is that of the faces it closes.
Shape baffle_section(double length);
/// A simple polygon, corners in either order [2 x n]. @throws ArgumentError also for fewer than three corners, no area,
/// edges that cross, or no circle wider than 1e-5 of its extent within
Shape polygon_section(const Eigen::Matrix2Xd& corners);
/// Ellipsoid with semi-axes along x, y, z.
Shape ellipsoid_shape(const Eigen::Vector3d& semi_axes);
/// Box with full sides along x, y, z.
Shape box_shape(const Eigen::Vector3d& sides);

/// A shape at a place, turned about z: at the angle of attack alpha the chord (the shape's x axis) points along
/// (cos alpha, -sin alpha), nose up in a stream along +x; at 90 deg a plate is broadside on.
class PlacedShape {
 public:
  PlacedShape(Shape shape, const Eigen::Vector3d& place, double angle_of_attack);

  /// To another place and angle.
  void move_to(const Eigen::Vector3d& place, double angle_of_attack);
  double distance(const Eigen::Vector3d& point) const;
  /// Whether a baffle lies between two points.
  bool separates(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;
  const Shape& shape() const { return shape_; }
  const Eigen::Vector3d& place() const { return place_; }
  /// Half the extents of a box along the axes of the domain, about its place, that holds it.
  Eigen::Vector3d half_extent() const { return low_.cwiseAbs().cwiseMax(high_); }
  /// What it takes of a stream along x: the extent along y of a section; in space the area of its shadow, of a
  /// mesh that of the box about its turned corners.
  double frontal_size() const;

 private:
  Eigen::Vector3d in_axes(const Eigen::Vector3d& point) const;

  Shape shape_;
  Eigen::Vector3d place_;
  double cosine_, sine_;
  Eigen::Vector3d low_, high_;  ///< ends of what it takes along the axes of the domain, about its place
};

}  // namespace samara::flow
