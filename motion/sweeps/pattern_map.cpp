#include "samara/motion/sweeps/pattern_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::motion {

namespace {

/// Of equally near ones the first.
std::vector<Eigen::Index> nearest_rows(const Eigen::MatrixXd& places, const Eigen::VectorXd& place,
                                       Eigen::Index count) {
  const Eigen::VectorXd distances = (places.rowwise() - place.transpose()).rowwise().squaredNorm();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(places.rows()));
  std::iota(order.begin(), order.end(), 0);
  const auto last = order.begin() + count;
  std::partial_sort(order.begin(), last, order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return distances[a] < distances[b] || (distances[a] == distances[b] && a < b);
  });
  order.erase(last, order.end());
  return order;
}

}  // namespace

std::vector<Eigen::Index> drawn_numbers(Eigen::Index count, Eigen::Index most) {
  std::vector<Eigen::Index> numbers(static_cast<std::size_t>(count));
  std::iota(numbers.begin(), numbers.end(), 0);
  if (count <= most) return numbers;
  std::vector<double> drawn;
  for (const Eigen::Index n : numbers) drawn.push_back(Stream(1, static_cast<std::uint64_t>(n)).uniform());
  std::ranges::sort(numbers, [&](Eigen::Index a, Eigen::Index b) {
    return std::pair(drawn[static_cast<std::size_t>(a)], a) <
           std::pair(drawn[static_cast<std::size_t>(b)], b);
  });
  numbers.resize(static_cast<std::size_t>(most));
  std::ranges::sort(numbers);
  return numbers;
}

double room_beside(double lower, double upper) {
  return 1e-9 * std::max({upper - lower, std::abs(lower), std::abs(upper)});
}

PatternMap::PatternMap(const Sweep& sweep, Eigen::Index release) {
  const Eigen::Index releases = sweep.release_count();
  if (release < 0 || release >= releases)
    throw ArgumentError(fmt::format("there is no release {}, expected 0 to {}", release, releases - 1));
  const Eigen::Index count = sweep.fall_count() / releases;
  if (count <= kNeighbours)
    throw ArgumentError(fmt::format("the sweep has {} points, expected at least {}", count, kNeighbours + 1));
  names_ = sweep.names;
  lower_ = sweep.lower;
  upper_ = sweep.upper;
  width_ = (sweep.upper - sweep.lower).unaryExpr([](double w) { return w > 0.0 ? w : 1.0; });
  places_ = (sweep.points.topRows(count).rowwise() - lower_.transpose()).array().rowwise() /
            width_.transpose().array();
  for (Eigen::Index n = 0; n < count; ++n) {
    const auto fall = static_cast<std::size_t>(n * releases + release);
    patterns_.push_back(sweep.labels[fall].pattern);
    if (sweep.status[fall] != FallStatus::inherited) run_.push_back(n);
  }
  for (const auto& axis : sweep.axes) grid_.push_back(static_cast<Eigen::Index>(axis.size()));
  if (std::accumulate(grid_.begin(), grid_.end(), Eigen::Index{1}, std::multiplies()) != count) grid_.clear();
  tree_ = std::make_shared<NearPoints>(places_);
  for (std::size_t k = 0; k < kPatterns; ++k) {
    std::vector<Eigen::Index> own;
    for (Eigen::Index n = 0; n < size(); ++n) {
      if (pattern(n) == static_cast<Pattern>(k)) own.push_back(n);
    }
    trees_[k] = std::make_shared<NearPoints>(places_(own, Eigen::all));
  }
}

Eigen::VectorXd PatternMap::scaled(const Eigen::VectorXd& point) const {
  if (point.size() != lower_.size()) {
    throw ArgumentError(
        fmt::format("the point has {} coordinates, expected {}", point.size(), lower_.size()));
  }
  for (Eigen::Index k = 0; k < point.size(); ++k) {
    const double room = room_beside(lower_[k], upper_[k]);
    if (!(point[k] >= lower_[k] - room && point[k] <= upper_[k] + room)) {
      throw ArgumentError(fmt::format("{} of the point is {}, expected {} to {}: inside the box",
                                      names_[static_cast<std::size_t>(k)], point[k], lower_[k], upper_[k]));
    }
  }
  return (point - lower_).cwiseQuotient(width_);
}

std::vector<Eigen::Index> PatternMap::nearest(const Eigen::VectorXd& place, int count) const {
  const std::span<const double> at(place.data(), static_cast<std::size_t>(place.size()));
  std::array<Eigen::Index, kNeighbours + 1> found = {};
  std::array<double, kNeighbours + 1> squares = {};
  const std::size_t last =
      tree_->nearest(at, std::span(found).first(static_cast<std::size_t>(count)), squares) - 1;
  // Points of a grid lie at equal distances, but for round-off: of equal ones the first come first.
  std::vector<Eigen::Index> order = tree_->within(at, squares[last] * (1.0 + 1e-9) + 1e-300);
  std::ranges::sort(order);
  const double grain = 1e-9 * squares[last] + 1e-300;
  const auto distance = [&](Eigen::Index n) {
    return std::round((places_.row(n) - place.transpose()).squaredNorm() / grain);
  };
  std::ranges::stable_sort(order, {}, distance);
  order.resize(static_cast<std::size_t>(count));
  return order;
}

/// The most frequent label; of equals the one that comes nearer.
MapAnswer PatternMap::answer(const std::vector<Eigen::Index>& nearest) const {
  std::array<int, kPatterns> counts = {};
  for (const Eigen::Index n : nearest) ++counts[static_cast<std::size_t>(pattern(n))];
  MapAnswer best;
  int most = 0;
  for (const Eigen::Index n : nearest) {
    const int count = counts[static_cast<std::size_t>(pattern(n))];
    if (count <= most) continue;
    most = count;
    best.pattern = pattern(n);
  }
  best.probability = static_cast<double>(most) / static_cast<double>(nearest.size());
  return best;
}

double PatternMap::distance_to_other(const Eigen::VectorXd& place, Pattern own) const {
  const std::span<const double> at(place.data(), static_cast<std::size_t>(place.size()));
  double least = std::numeric_limits<double>::infinity(), square = 0.0;
  Eigen::Index found = 0;
  for (std::size_t k = 0; k < kPatterns; ++k) {
    if (k == static_cast<std::size_t>(own) || trees_[k]->nearest(at, {&found, 1}, {&square, 1}) == 0)
      continue;
    least = std::min(least, square);
  }
  return std::sqrt(least);
}

MapAnswer PatternMap::at(const Eigen::VectorXd& point) const {
  const Eigen::VectorXd place = scaled(point);
  MapAnswer found = answer(nearest(place, kNeighbours));
  found.distance_to_border = distance_to_other(place, found.pattern);
  return found;
}

double PatternMap::left_one_out(const std::vector<Eigen::Index>& asked) const {
  constexpr Eigen::Index kMost = 2000;
  const std::vector<Eigen::Index>& points = asked.empty() ? run_ : asked;
  const Eigen::MatrixXd places = places_(run_, Eigen::all);
  const Eigen::Index count = std::min<Eigen::Index>(kNeighbours + 1, places.rows());
  double right = 0.0, all = 0.0;
  for (const Eigen::Index k : drawn_numbers(std::ssize(points), kMost)) {
    const Eigen::Index point = points[static_cast<std::size_t>(k)];
    std::vector<Eigen::Index> around;
    for (const Eigen::Index n : nearest_rows(places, places_.row(point), count))
      around.push_back(run_[static_cast<std::size_t>(n)]);
    if (const auto self = std::ranges::find(around, point); self != around.end()) {
      around.erase(self);
    } else {
      around.pop_back();  // so many others lie at the same place
    }
    right += answer(around).pattern == pattern(point);
    all += 1.0;
  }
  return right / all;
}

std::vector<std::vector<Eigen::Index>> PatternMap::neighbours() const {
  std::vector<std::vector<Eigen::Index>> all(static_cast<std::size_t>(size()));
  const auto join = [&](Eigen::Index a, Eigen::Index b) {
    all[static_cast<std::size_t>(a)].push_back(b);
    all[static_cast<std::size_t>(b)].push_back(a);
  };
  if (grid_.empty()) {
    for (Eigen::Index n = 0; n < size(); ++n) {
      for (const Eigen::Index other : nearest(places_.row(n), kNeighbours + 1)) {
        if (other != n) join(n, other);
      }
    }
    return all;
  }
  Eigen::Index stride = 1;
  for (std::size_t k = grid_.size(); k-- > 0;) {
    for (Eigen::Index n = 0; n < size(); ++n) {
      if ((n / stride) % grid_[k] + 1 < grid_[k]) join(n, n + stride);
    }
    stride *= grid_[k];
  }
  return all;
}

std::vector<MapRegion> PatternMap::regions() const {
  const auto around = neighbours();
  std::vector<bool> seen(patterns_.size(), false);
  std::vector<MapRegion> all;
  for (Eigen::Index first = 0; first < size(); ++first) {
    if (seen[static_cast<std::size_t>(first)]) continue;
    MapRegion region = {pattern(first), 0};
    std::vector<Eigen::Index> open = {first};
    seen[static_cast<std::size_t>(first)] = true;
    while (!open.empty()) {
      const Eigen::Index n = open.back();
      open.pop_back();
      ++region.falls;
      for (const Eigen::Index other : around[static_cast<std::size_t>(n)]) {
        if (seen[static_cast<std::size_t>(other)] || pattern(other) != region.pattern) continue;
        seen[static_cast<std::size_t>(other)] = true;
        open.push_back(other);
      }
    }
    all.push_back(region);
  }
  std::ranges::stable_sort(all, std::greater(), &MapRegion::falls);
  return all;
}

double PatternMap::border_share() const {
  const auto around = neighbours();
  double count = 0.0;
  for (Eigen::Index n = 0; n < size(); ++n) {
    count += std::ranges::any_of(around[static_cast<std::size_t>(n)],
                                 [&](Eigen::Index other) { return pattern(other) != pattern(n); });
  }
  return count / static_cast<double>(size());
}

/// Those of the pattern, in order.
std::vector<Eigen::Index> PatternMap::falls_of(Pattern wanted) const {
  std::vector<Eigen::Index> falls;
  std::set<std::string> there;
  for (Eigen::Index n = 0; n < size(); ++n) {
    if (pattern(n) == wanted) falls.push_back(n);
    there.insert(to_string(pattern(n)));
  }
  if (falls.empty()) {
    throw ArgumentError(fmt::format("{} is 0 of {} points of the box; there are {}", to_string(wanted),
                                    size(), join(std::vector<std::string>(there.begin(), there.end()))));
  }
  return falls;
}

Eigen::VectorXd PatternMap::draw(Pattern wanted, Stream& stream) const {
  const std::vector<Eigen::Index> falls = falls_of(wanted);
  const auto pick = static_cast<std::size_t>(stream.uniform() * static_cast<double>(falls.size()));
  const Eigen::VectorXd place = places_.row(falls[pick]);
  Eigen::VectorXd way = Eigen::VectorXd::Zero(place.size());
  int moving = 0;
  for (Eigen::Index k = 0; k < way.size(); ++k) {
    if (!(upper_[k] > lower_[k])) continue;
    way[k] = stream.normal();
    ++moving;
  }
  const double reach = 0.5 * std::min(1.0, distance_to_other(place, wanted));
  // Evenly in the ball.
  const double radius = reach * std::pow(stream.uniform(), 1.0 / moving);
  const Eigen::VectorXd moved =
      (place + radius / std::max(way.norm(), 1e-300) * way).cwiseMax(0.0).cwiseMin(1.0);
  return lower_ + moved.cwiseProduct(width_);
}

Eigen::VectorXd PatternMap::clamp(Pattern wanted, const Eigen::VectorXd& point) const {
  if (!point.allFinite()) throw ArgumentError("a coordinate of the point is not finite");
  const std::vector<Eigen::Index> falls = falls_of(wanted);
  const Eigen::VectorXd place =
      scaled(point.size() == lower_.size() ? point.cwiseMax(lower_).cwiseMin(upper_).eval() : point);
  const auto is_wanted = [&](const Eigen::VectorXd& there) {
    return answer(nearest(there, kNeighbours)).pattern == wanted;
  };
  const auto in_box = [&](const Eigen::VectorXd& there) { return lower_ + there.cwiseProduct(width_); };
  if (is_wanted(place)) return in_box(place);
  const Eigen::Index from = *std::ranges::min_element(
      falls, {}, [&](Eigen::Index n) { return (places_.row(n) - place.transpose()).squaredNorm(); });
  const Eigen::VectorXd fall = places_.row(from);
  double reached = 0.0, beyond = 1.0;
  while (beyond - reached > 1e-6 && is_wanted(fall)) {
    const double middle = 0.5 * (reached + beyond);
    (is_wanted(fall + middle * (place - fall)) ? reached : beyond) = middle;
  }
  return in_box(fall + reached * (place - fall));
}

}  // namespace samara::motion
