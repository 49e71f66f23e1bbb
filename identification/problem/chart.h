#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

/// Internal to identification/.
namespace samara::identification {

/// How the unknowns of a block may move: most by adding, positive ones by a factor, an attitude by turning.
/// A step has as many numbers as there are directions to move in: one less than the unknowns for every
/// quaternion.
class Chart {
 public:
  enum class Kind {
    linear,       ///< x + d
    logarithmic,  ///< x exp(d)
    held,         ///< not at all
    /// q times the turn by the vector d in body axes: four unknowns (w, x, y, z), three directions.
    quaternion,
    axis,  ///< the same, by turns about body x and y alone: where body z points; two directions
  };

  Chart() = default;
  /// @param kinds in the order of the unknowns; a quaternion or an axis stands for four of them
  explicit Chart(const std::vector<Kind>& kinds);

  /// The same with one more unknown held, not of a quaternion.
  Chart holding(int unknown) const;

  int size() const { return size_; }
  int directions() const { return directions_; }
  bool is_linear() const;
  bool is_part_of_quaternion(int unknown) const;
  bool is_logarithmic(int unknown) const;
  /// The direction that belongs to an unknown: the first three of a quaternion have one each; its last, and
  /// what is held, none (-1).
  int direction_of(int unknown) const;

  /// y = x moved by `step`; quaternions keep unit length.
  void plus(const double* x, const double* step, double* y) const;
  /// The step that leads from x to y.
  void minus(const double* y, const double* x, double* step) const;

  /// dy/d(step) at no step: size x directions.
  Eigen::MatrixXd plus_jacobian(const double* x) const;
  /// d(step)/dy at y = x: directions x size.
  Eigen::MatrixXd minus_jacobian(const double* x) const;

 private:
  struct Part {
    Kind kind;
    int unknown, direction;  ///< the first of its own
  };
  static int directions_of(Kind kind);
  /// What a part has in the jacobians.
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 4, 4>;
  static Block plus_block(Kind kind, const double* q);
  static Block minus_block(Kind kind, const double* q);
  static bool is_attitude(Kind kind) { return kind == Kind::quaternion || kind == Kind::axis; }
  std::vector<Part> parts_;
  int size_ = 0;
  int directions_ = 0;
};

/// The rotation vector, in body axes, of the turn that leads from one attitude to another, |r| <= pi, and its
/// derivatives. Quaternions (w, x, y, z) of any length but zero; the sign of either does not matter.
struct Turn {
  Eigen::Vector3d vector;
  Eigen::Matrix<double, 3, 4, Eigen::DontAlign> by_from, by_to;
};
Turn turn_between(const double* from, const double* to);

}  // namespace samara::identification
