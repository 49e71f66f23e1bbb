#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

/// A coordinate that is counted from a front. Some boxes have one: a card turns over one way or the other, and where it
/// is undecided all states change within a thousandth of the box. A front that moves with the other coordinates has
/// high ranks and needs nodes everywhere. Counted from it, it stands still.
///
/// With the coordinate X and the place of the front G(others) on [-1, 1] for the ends of the box, the axis of the field
/// holds V = (X - G) / (1 - G X): 0 at the front, and the ends of the box are where they were.
/// The idea is that of registration: Taddei, SIAM J. Sci. Comput. 42 (2020) A997.
namespace samara::codebooks {

class FrontMap {
 public:
  static constexpr std::size_t kMostOthers = 4;  ///< coordinates that the place of the front depends on
  static constexpr int kMostCoefficients = 16;   ///< along one of them
  static constexpr int kMostTogether = 512;      ///< products of coefficients of all of them

  /// A coordinate that the place of the front depends on, by Chebyshev polynomials over its interval.
  struct Other {
    int coordinate = 0;  ///< place among the numbers of a point
    double lower = 0.0;
    double upper = 0.0;
    int coefficients = 1;
  };

  /// @param coordinate place among the numbers of a point  @param lower,upper ends of its box
  /// @param place coefficients of G, products of those of the others, the first of them fastest
  /// @throws ArgumentError for an empty interval, one other twice or the coordinate itself, more of them or of their
  ///   coefficients than above, a wrong number of coefficients, or ones that are not finite or may let the front leave
  ///   the box
  FrontMap(int coordinate, double lower, double upper, std::vector<Other> others, Eigen::VectorXd place);

  int coordinate() const { return coordinate_; }
  double lower() const { return lower_; }
  double upper() const { return upper_; }
  const std::vector<Other>& others() const { return others_; }
  const Eigen::VectorXd& place() const { return place_; }

  /// Where the front is, in the unit of the coordinate. @param x a point, whose own coordinate is not looked at
  double front_at(const double* x) const;
  /// The point of the axis for a point of the box.
  double to_axis(const double* x) const;
  /// The coordinate for a point whose number `coordinate()` is that of the axis.
  double from_axis(const double* x) const;

  /// Of to_axis(), by the coordinate first and then the others.
  struct Derivatives {
    std::array<double, 1 + kMostOthers> first = {};
    std::array<std::array<double, 1 + kMostOthers>, 1 + kMostOthers> second = {};
  };
  /// @returns to_axis(x)
  double to_axis(const double* x, Derivatives& derivatives) const;

  /// The same map of points that have `by` numbers more in front, or fewer.
  FrontMap shifted(int by) const;
  /// Of points without one of the numbers, which stands still. @param place of the number, not the coordinate's
  FrontMap restricted(int place, double value) const;

 private:
  struct Place;
  bool stays_inside() const;
  Place place_at(const double* x, bool with_derivatives) const;
  double scaled(double x) const { return 2.0 * (x - lower_) / (upper_ - lower_) - 1.0; }
  double unscaled(double v) const { return lower_ + 0.5 * (upper_ - lower_) * (v + 1.0); }

  int coordinate_;
  double lower_, upper_;
  std::vector<Other> others_;
  Eigen::VectorXd place_;
};

}  // namespace samara::codebooks
