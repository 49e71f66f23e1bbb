#include "samara/motion/search/near_points.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nanoflann.hpp>

#include "samara/base/errors.h"

namespace samara::motion {

/// What nanoflann asks of points.
struct NearPoints::Tree {
  explicit Tree(const Eigen::Ref<const Eigen::MatrixXd>& all) : points(all.transpose()) {}
  virtual ~Tree() = default;

  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points.cols()); }
  double kdtree_get_pt(std::size_t point, std::size_t dimension) const {
    return points(static_cast<Eigen::Index>(dimension), static_cast<Eigen::Index>(point));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

  virtual std::size_t nearest(const double* place, std::size_t count, std::size_t* found, double* squares,
                              double slack) const = 0;
  virtual std::vector<Eigen::Index> within(const double* place, double square) const = 0;

  Eigen::MatrixXd points;  ///< a column each
};

template <int kDimensions>
struct NearPoints::TreeOf final : NearPoints::Tree {
  using Metric = nanoflann::L2_Simple_Adaptor<double, Tree, double, std::size_t>;
  using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, Tree, kDimensions, std::size_t>;

  explicit TreeOf(const Eigen::Ref<const Eigen::MatrixXd>& all)
      : Tree(all), index(static_cast<typename Index::Dimension>(all.cols()), *this) {
    if (points.cols() > 0) index.buildIndex();
  }

  std::size_t nearest(const double* place, std::size_t count, std::size_t* found, double* squares,
                      double slack) const override {
    nanoflann::KNNResultSet<double, std::size_t> set(count);
    set.init(found, squares);
    index.findNeighbors(set, place, nanoflann::SearchParams(32, static_cast<float>(slack)));
    return set.size();
  }

  std::vector<Eigen::Index> within(const double* place, double square) const override {
    std::vector<std::pair<std::size_t, double>> pairs;
    index.radiusSearch(place, square, pairs, nanoflann::SearchParams(32, 0.0F, false));
    std::vector<Eigen::Index> all;
    for (const auto& pair : pairs) all.push_back(static_cast<Eigen::Index>(pair.first));
    return all;
  }

  Index index;
};

NearPoints::NearPoints(const Eigen::Ref<const Eigen::MatrixXd>& points) {
  if (!points.allFinite() || points.cols() == 0)
    throw ArgumentError(
        fmt::format("{} points of {} coordinates were to be searched, expected finite ones of 1 or more",
                    points.rows(), points.cols()));
  // Reduced states in the plane and in space have these.
  if (points.cols() == 5) {
    tree_ = std::make_unique<TreeOf<5>>(points);
  } else if (points.cols() == 9) {
    tree_ = std::make_unique<TreeOf<9>>(points);
  } else {
    tree_ = std::make_unique<TreeOf<-1>>(points);
  }
}

NearPoints::~NearPoints() = default;
NearPoints::NearPoints(NearPoints&&) noexcept = default;
NearPoints& NearPoints::operator=(NearPoints&&) noexcept = default;

Eigen::Index NearPoints::size() const {
  return tree_->points.cols();
}

std::size_t NearPoints::nearest(std::span<const double> place, std::span<Eigen::Index> found,
                                std::span<double> squares, double slack) const {
  std::array<std::size_t, kMost> points;
  const std::size_t wanted =
      std::min({found.size(), squares.size(), kMost, static_cast<std::size_t>(size())});
  if (wanted == 0) return 0;
  const std::size_t count = tree_->nearest(place.data(), wanted, points.data(), squares.data(), slack);
  for (std::size_t k = 0; k < count; ++k) found[k] = static_cast<Eigen::Index>(points[k]);
  return count;
}

std::vector<Eigen::Index> NearPoints::within(std::span<const double> place, double square) const {
  if (size() == 0) return {};
  return tree_->within(place.data(), square);
}

}  // namespace samara::motion
