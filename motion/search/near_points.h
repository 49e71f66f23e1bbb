#pragma once

#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

/// The nearest of many points, by a k-d tree (nanoflann).
namespace samara::motion {

class NearPoints {
 public:
  /// Most points that are asked for at once.
  static constexpr std::size_t kMost = 128;

  /// @param points a point a row, all finite. @throws ArgumentError otherwise
  explicit NearPoints(const Eigen::Ref<const Eigen::MatrixXd>& points);
  ~NearPoints();
  NearPoints(NearPoints&&) noexcept;
  NearPoints& operator=(NearPoints&&) noexcept;

  Eigen::Index size() const;

  /// The nearest ones, the nearest first. In 5 and 9 dimensions it does not allocate.
  /// @param found, squares as many as are wanted, kMost at most: numbers of points, squares of their distances
  /// @param within only those at a squared distance below this
  /// @returns how many there are
  std::size_t nearest(std::span<const double> place, std::span<Eigen::Index> found, std::span<double> squares,
                      double within = std::numeric_limits<double>::infinity()) const {
    return nearest_to_any(place, found, squares, within);
  }
  /// The same for several places, such as the copies of one: the points that are nearest to any of them, each once.
  /// @param places kMostPlaces at most, one after the other
  std::size_t nearest_to_any(std::span<const double> places, std::span<Eigen::Index> found,
                             std::span<double> squares,
                             double within = std::numeric_limits<double>::infinity()) const;
  static constexpr std::size_t kMostPlaces = 4;

  /// All at a squared distance below `square`, in any order.
  std::vector<Eigen::Index> within(std::span<const double> place, double square) const;

 private:
  struct Tree;
  template <int kDimensions>
  struct TreeOf;
  std::unique_ptr<Tree> tree_;
};

}  // namespace samara::motion
