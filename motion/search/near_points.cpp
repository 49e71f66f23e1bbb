#include "samara/motion/search/near_points.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nanoflann.hpp>

#include "samara/base/errors.h"
#include "samara/base/require.h"

namespace samara::motion {

namespace {

/// What nanoflann puts points into: the nearest, each once, of those nearer than a limit.
class NearestOnce {
 public:
  NearestOnce(std::span<Eigen::Index> found, std::span<double> squares, double within)
      : found_(found), squares_(squares), within_(within) {}

  std::size_t size() const { return count_; }
  bool full() const { return count_ == found_.size(); }
  double worstDist() const { return full() ? squares_[count_ - 1] : within_; }
  /// @returns true: the search goes on
  bool addPoint(double square, std::size_t point) {
    if (!(square < worstDist())) return true;
    const auto index = static_cast<Eigen::Index>(point);
    std::size_t place = 0;
    while (place < count_ && found_[place] != index) ++place;
    if (place < count_ && squares_[place] <= square) return true;
    if (place == count_) {
      if (full()) {
        --place;
      } else {
        ++count_;
      }
    }
    for (; place > 0 && squares_[place - 1] > square; --place) {
      squares_[place] = squares_[place - 1];
      found_[place] = found_[place - 1];
    }
    squares_[place] = square;
    found_[place] = index;
    return true;
  }

 private:
  std::span<Eigen::Index> found_;
  std::span<double> squares_;
  double within_;
  std::size_t count_ = 0;
};

}  // namespace

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

  /// Puts what is nearer into the set, if there can be any.
  virtual void add_nearest(const double* place, NearestOnce& set) const = 0;
  /// Squared distance of a place to the box of all points.
  virtual double square_to_box(const double* place) const = 0;
  virtual std::vector<Eigen::Index> within(const double* place, double square) const = 0;

  Eigen::MatrixXd points;  ///< a column each
};

/// Squared distances, in the way nanoflann asks for them: of two points at once, so that the compiler sees how many
/// coordinates there are.
template <int kDimensions>
struct SquaredDistance {
  using ElementType = double;
  using DistanceType = double;
  using Numbers =
      Eigen::Map<const Eigen::Matrix<double, kDimensions == -1 ? Eigen::Dynamic : kDimensions, 1>>;

  explicit SquaredDistance(const auto& tree) : points(tree.points) {}

  double evalMetric(const double* place, std::size_t point, std::size_t size) const {
    const auto count = static_cast<Eigen::Index>(size);
    return (Numbers(place, count) - Numbers(points.data() + point * size, count)).squaredNorm();
  }
  double accum_dist(double a, double b, std::size_t) const { return (a - b) * (a - b); }

  const Eigen::MatrixXd& points;
};

template <int kDimensions>
struct NearPoints::TreeOf final : NearPoints::Tree {
  using Metric = SquaredDistance<kDimensions>;
  using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, Tree, kDimensions, std::size_t>;

  explicit TreeOf(const Eigen::Ref<const Eigen::MatrixXd>& all)
      : Tree(all), index(static_cast<typename Index::Dimension>(all.cols()), *this) {
    if (points.cols() > 0) index.buildIndex();
  }

  void add_nearest(const double* place, NearestOnce& set) const override {
    index.findNeighbors(set, place, nanoflann::SearchParams());
  }

  double square_to_box(const double* place) const override {
    double sum = 0.0;
    for (std::size_t i = 0; i < index.root_bbox.size(); ++i) {
      const auto& [low, high] = index.root_bbox[i];
      const double gap = std::max({0.0, low - place[i], place[i] - high});
      sum += gap * gap;
    }
    return sum;
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

std::size_t NearPoints::nearest_to_any(std::span<const double> places, std::span<Eigen::Index> found,
                                       std::span<double> squares, double within) const {
  const std::size_t wanted =
      std::min({found.size(), squares.size(), kMost, static_cast<std::size_t>(size())});
  if (wanted == 0) return 0;
  const auto dimensions = static_cast<std::size_t>(tree_->points.rows());
  struct Place {
    const double* at;
    double square;  // to all points, at least
  };
  std::array<Place, kMostPlaces> all;
  const std::size_t count = places.size() / dimensions;
  require(count <= kMostPlaces, "count of places to search about", count, "4 or fewer");
  for (std::size_t k = 0; k < count; ++k) {
    const double* at = places.data() + k * dimensions;
    all[k] = {at, count > 1 ? tree_->square_to_box(at) : 0.0};
  }
  std::ranges::sort(std::span(all).first(count), {}, &Place::square);
  NearestOnce set(found.first(wanted), squares, within);
  for (const Place& place : std::span(all).first(count)) {
    if (place.square < set.worstDist()) tree_->add_nearest(place.at, set);
  }
  return set.size();
}

std::vector<Eigen::Index> NearPoints::within(std::span<const double> place, double square) const {
  if (size() == 0) return {};
  return tree_->within(place.data(), square);
}

}  // namespace samara::motion
