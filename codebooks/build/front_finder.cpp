#include "samara/codebooks/build/front_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "samara/base/errors.h"
#include "samara/pgd/tensors/random.h"

namespace samara::codebooks {

namespace {

using Eigen::Index;

/// Of the polynomial, in each other coordinate: those of 3, 5 and 9 nodes lie in each other.
constexpr int kFewestNodes = 3, kMostNodes = 9;
constexpr Index kCheckLines = 24;
/// Of the width of the front: what is aimed at, and what is still of use, as elements follow the rest.
constexpr double kLittleError = 0.1, kMostError = 2.0;
/// Of the half interval: a front nearer to its ends is not counted from.
constexpr double kFarthest = 0.9;

/// The front on a line, on [-1, 1].
struct Section {
  double place = 0.0;
  double width = 0.0;
};

/// Not where values are constant, either.
bool is_inside(const Section& section) {
  return section.width > 0.0 && std::abs(section.place) <= kFarthest;
}

class FrontSearch {
 public:
  FrontSearch(Index coordinate, const LineNodes::Values& values, const FrontFinderOptions& options)
      : coordinate_(coordinate),
        values_(values),
        options_(options),
        middle_(0.5 * (options.lower + options.upper)),
        half_(0.5 * (options.upper - options.lower)) {
    for (Index k = 0; k < middle_.size(); ++k) {
      if (k != coordinate) others_.push_back(k);
    }
    counts_.assign(others_.size(), kFewestNodes);
  }

  std::optional<FrontMap> run() {
    if (others_.empty() || others_.size() > FrontMap::kMostOthers || !is_affordable(kCheckLines)) return {};
    const Eigen::MatrixXd lines = check_lines();
    const std::vector<Section> sections = sections_of(lines);
    if (!std::ranges::all_of(sections, is_inside)) return {};
    std::optional<FrontMap> best;
    for (double least = kMostError; least > kLittleError;) {
      const std::vector<std::vector<int>> fresh = fresh_points();
      if (!is_affordable(static_cast<Index>(fresh.size()))) break;
      if (!look_at(fresh)) return {};
      std::optional<FrontMap> map = map_of(coefficients());
      double error = 0.0;
      for (Index j = 0; map && j < lines.cols(); ++j) {
        const auto line = static_cast<std::size_t>(j);
        const double place = (map->front_at(lines.col(j).data()) - middle_[coordinate_]) / half_[coordinate_];
        error = std::max(error, std::abs(place - sections[line].place) / sections[line].width);
      }
      if (map && error <= least) {
        least = error;
        best = std::move(map);
      }
      if (!raise_degree()) break;
    }
    return best;
  }

 private:
  static constexpr Index kSamples = 65;  ///< of a window
  static constexpr int kZooms = 3, kCentrings = 2;
  static constexpr long kPointsOfLine = kSamples * (kZooms + kCentrings);

  bool is_affordable(Index lines) const { return points_ + lines * kPointsOfLine <= options_.max_points; }

  Eigen::MatrixXd check_lines() const {
    pgd::Random random(options_.seed);
    Eigen::MatrixXd lines(middle_.size(), kCheckLines);
    for (double& x : lines.reshaped()) x = 2.0 * random.uniform() - 1.0;
    return middle_.replicate(1, kCheckLines) + half_.asDiagonal() * lines;
  }

  /// Grid point by grid point, the first other coordinate fastest: places among kMostNodes per coordinate.
  std::vector<std::vector<int>> grid() const {
    std::vector<std::vector<int>> points(1);
    for (const int count : counts_) {
      std::vector<std::vector<int>> more;
      for (int i = 0; i < count; ++i) {
        for (std::vector<int> point : points) {
          point.push_back(i * (kMostNodes - 1) / (count - 1));
          more.push_back(std::move(point));
        }
      }
      points = std::move(more);
    }
    return points;
  }

  /// Those of the grid whose lines were not looked at.
  std::vector<std::vector<int>> fresh_points() const {
    std::vector<std::vector<int>> fresh;
    for (std::vector<int>& point : grid()) {
      if (!places_.contains(point)) fresh.push_back(std::move(point));
    }
    return fresh;
  }

  /// @returns whether the front is there, on all lines
  bool look_at(const std::vector<std::vector<int>>& fresh) {
    const auto count = static_cast<Index>(fresh.size());
    Eigen::MatrixXd lines = middle_.replicate(1, count);
    for (Index j = 0; j < count; ++j) {
      for (std::size_t k = 0; k < others_.size(); ++k) {
        const double angle = std::numbers::pi * fresh[static_cast<std::size_t>(j)][k] / (kMostNodes - 1);
        lines(others_[k], j) += half_[others_[k]] * std::cos(angle);
      }
    }
    const std::vector<Section> sections = sections_of(lines);
    for (std::size_t j = 0; j < fresh.size(); ++j) places_[fresh[j]] = sections[j].place;
    return std::ranges::all_of(sections, is_inside);
  }

  std::vector<Section> sections_of(const Eigen::MatrixXd& lines) {
    constexpr Index kTogether = 16;
    std::vector<Section> sections;
    for (Index first = 0; first < lines.cols(); first += kTogether) {
      for (const Section& section :
           sections_together(lines.middleCols(first, std::min(kTogether, lines.cols() - first))))
        sections.push_back(section);
    }
    return sections;
  }

  /// The steepest place, by windows each within the last; then the centre of what is steep about it, which no other
  /// peak within the front takes the place of.
  std::vector<Section> sections_together(const Eigen::MatrixXd& lines) {
    constexpr double kZoom = 16.0, kWidths = 4.0;
    const auto count = static_cast<std::size_t>(lines.cols());
    std::vector<Section> sections(count);
    std::vector<double> reach(count, 1.0), steepest(count, 0.0);
    std::vector<Eigen::VectorXd> ranges(count);
    for (int round = 0; round < kZooms + kCentrings; ++round) {
      const Eigen::MatrixXd windows = windows_about(sections, reach);
      const Eigen::MatrixXd values = values_in(lines, windows);
      for (std::size_t j = 0; j < count; ++j) {
        const auto line = static_cast<Index>(j);
        const auto own = values.middleCols(line * kSamples, kSamples);
        const double step = (windows(1, line) - windows(0, line)) / (kSamples - 1);
        const Eigen::MatrixXd slopes = (own.rightCols(kSamples - 1) - own.leftCols(kSamples - 1)) / step;
        const auto place_of = [&](double cell) { return windows(0, line) + (cell + 0.5) * step; };
        if (round == 0) ranges[j] = own.rowwise().maxCoeff() - own.rowwise().minCoeff();
        if (round < kZooms) {
          Index row = 0, cell = 0;
          const double slope = slopes.cwiseAbs().maxCoeff(&row, &cell);
          sections[j].place = place_of(static_cast<double>(cell));
          if (slope > steepest[j]) {
            steepest[j] = slope;
            sections[j].width = ranges[j][row] / slope;
          }
          reach[j] /= kZoom;
        } else {
          const Eigen::RowVectorXd squares = slopes.colwise().squaredNorm();
          const auto cells =
              Eigen::RowVectorXd::LinSpaced(kSamples - 1, 0.0, static_cast<double>(kSamples - 2));
          sections[j].place = place_of(squares.dot(cells) / squares.sum());
        }
        if (round + 1 >= kZooms) reach[j] = kWidths * sections[j].width;
      }
    }
    return sections;
  }

  /// Ends, a column per line.
  static Eigen::MatrixXd windows_about(const std::vector<Section>& sections,
                                       const std::vector<double>& reach) {
    Eigen::MatrixXd windows(2, static_cast<Index>(sections.size()));
    for (std::size_t j = 0; j < sections.size(); ++j) {
      windows(0, static_cast<Index>(j)) = std::max(-1.0, sections[j].place - reach[j]);
      windows(1, static_cast<Index>(j)) = std::min(1.0, sections[j].place + reach[j]);
    }
    return windows;
  }

  Eigen::MatrixXd values_in(const Eigen::MatrixXd& lines, const Eigen::MatrixXd& windows) {
    Eigen::MatrixXd points(lines.rows(), lines.cols() * kSamples);
    for (Index j = 0; j < lines.cols(); ++j) {
      points.middleCols(j * kSamples, kSamples) = lines.col(j).replicate(1, kSamples);
      const auto places = Eigen::RowVectorXd::LinSpaced(kSamples, windows(0, j), windows(1, j)).array();
      points.block(coordinate_, j * kSamples, 1, kSamples) =
          middle_[coordinate_] + half_[coordinate_] * places;
    }
    points_ += points.cols();
    return values_(points);
  }

  /// Of the polynomial through the places on the grid.
  Eigen::VectorXd coefficients() const {
    const std::vector<std::vector<int>> points = grid();
    Eigen::VectorXd result(static_cast<Index>(points.size()));
    for (std::size_t j = 0; j < points.size(); ++j) result[static_cast<Index>(j)] = places_.at(points[j]);
    Index before = 1;
    for (const int count : counts_) {
      const Eigen::MatrixXd transform = chebyshev_transform(count);
      for (Index block = 0; block < result.size(); block += before * count) {
        Eigen::Map<Eigen::MatrixXd> slab(result.data() + block, before, count);
        slab = (slab * transform.transpose()).eval();
      }
      before *= count;
    }
    return result;
  }

  std::optional<FrontMap> map_of(const Eigen::VectorXd& place) const {
    std::vector<FrontMap::Other> others;
    for (std::size_t k = 0; k < others_.size(); ++k) {
      const Index coordinate = others_[k];
      others.push_back(
          {static_cast<int>(coordinate), options_.lower[coordinate], options_.upper[coordinate], counts_[k]});
    }
    try {
      return FrontMap(static_cast<int>(coordinate_), options_.lower[coordinate_], options_.upper[coordinate_],
                      std::move(others), place);
    } catch (const ArgumentError&) {
      return std::nullopt;  // it leaves the box between the lines
    }
  }

  /// Where the last coefficients are largest.  @returns whether there may be more
  bool raise_degree() {
    const Eigen::VectorXd all = coefficients().cwiseAbs();
    double largest = 0.0;
    int* raised = nullptr;
    Index before = 1;
    for (int& count : counts_) {
      double last = 0.0;
      for (Index n = 0; n < all.size(); ++n) last += (n / before) % count == count - 1 ? all[n] : 0.0;
      before *= count;
      const Index more = all.size() / count * (2 * count - 1);
      if (count == kMostNodes || more > FrontMap::kMostTogether || last <= largest) continue;
      largest = last;
      raised = &count;
    }
    if (raised != nullptr) *raised = 2 * *raised - 1;
    return raised != nullptr;
  }

  const Index coordinate_;
  const LineNodes::Values& values_;
  const FrontFinderOptions& options_;
  const Eigen::VectorXd middle_, half_;
  std::vector<Index> others_;
  std::vector<int> counts_;  ///< nodes per other coordinate
  std::map<std::vector<int>, double> places_;
  long points_ = 0;
};

}  // namespace

std::optional<FrontMap> find_front(Index coordinate, const LineNodes::Values& values,
                                   const FrontFinderOptions& options) {
  return FrontSearch(coordinate, values, options).run();
}

}  // namespace samara::codebooks
