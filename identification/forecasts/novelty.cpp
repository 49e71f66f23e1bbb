#include "samara/identification/forecasts/novelty.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::identification {

namespace {

constexpr Eigen::Index kPlaces = 6;
constexpr std::size_t kNearest = 5, kMostLevel = 2;

double distance_of(const Mirrored& one, const Mirrored& other) {
  const double as_seen = (one.odd - other.odd).squaredNorm(), mirrored = (one.odd + other.odd).squaredNorm();
  return std::sqrt((one.even - other.even).squaredNorm() + std::min(as_seen, mirrored));
}

}  // namespace

Novelty Novelty::fit(std::span<const TrainingMoment> moments, const Components& components) {
  Novelty result;
  result.components_ = components;
  if (moments.empty() || components.level.size() > kMostLevel) return result;
  result.count_ = moments.front().seen.positions.cols();
  for (const int c : components.level) {
    if (c < 0 || c >= result.count_)
      throw ArgumentError(fmt::format("level component {} of {}; a smaller number was expected, 0 or more", c,
                                      result.count_));
  }
  std::vector<double> seen_for;
  for (const TrainingMoment& one : moments) {
    if (const auto recent = recent_motion(one.seen)) seen_for.push_back(recent->seen_for);
  }
  if (seen_for.empty()) return result;
  result.back_ = Eigen::VectorXd::LinSpaced(kPlaces, 1.0, kPlaces) * (way_back(seen_for) / kPlaces);
  for (const TrainingMoment& one : moments) {
    if (auto course = result.course_of(one.seen)) result.known_.push_back({std::move(*course), one.cluster});
  }
  return result;
}

std::optional<Mirrored> Novelty::course_of(const SeenMotion& seen) const {
  if (back_.size() == 0) return {};
  if (seen.positions.cols() != count_)
    throw ArgumentError(
        fmt::format("a motion of {} components, where {} were expected", seen.positions.cols(), count_));
  const auto recent = recent_motion(seen);
  if (!recent || recent->seen_for < kLeastSeen * back_[kPlaces - 1]) return {};
  return LevelFrame(components_, recent->rates.row(0)).split(places_back(seen, back_));
}

double Novelty::distance(const SeenMotion& seen, std::optional<int> without) const {
  const auto course = course_of(seen);
  std::vector<double> nearest;
  for (std::size_t k = 0; course && k < known_.size(); ++k) {
    if (known_[k].cluster != without) nearest.push_back(distance_of(*course, known_[k].places));
  }
  if (nearest.size() < kNearest) return std::numeric_limits<double>::quiet_NaN();
  std::ranges::partial_sort(nearest, nearest.begin() + kNearest);
  double sum = 0.0;
  for (std::size_t k = 0; k < kNearest; ++k) sum += nearest[k];
  return sum / static_cast<double>(kNearest);
}

double Novelty::at(const SeenMotion& seen) const {
  return distance(seen, {});
}

double Novelty::without(int cluster, const SeenMotion& seen) const {
  return distance(seen, cluster);
}

}  // namespace samara::identification
