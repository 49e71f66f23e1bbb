#include "samara/identification/statistics/autoregression.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

constexpr double kUnsaid = std::numeric_limits<double>::quiet_NaN();
constexpr int kCubicFrames = 9;    ///< through which speeds are taken
constexpr std::size_t kParts = 5;  ///< of the clusters
constexpr double kPenalties[] = {1.0, 3.0, 10.0, 30.0, 100.0, 1000.0};

std::vector<int> others_of(const Components& components, Eigen::Index count) {
  std::vector<int> others;
  for (int c = 0; c < count; ++c) {
    if (std::ranges::count(components.level, c) == 0) others.push_back(c);
  }
  return others;
}

/// What the newest frames show.
struct Recent {
  Eigen::RowVectorXd last = {};
  Eigen::MatrixXd places = {};  ///< as seen from the last, the newest first: kPlaces - 1 x components
  Eigen::MatrixXd rates = {};   ///< d_1, d_2, d_3, as displacements in one frame: 3 x components
  Eigen::VectorXd speeds = {};  ///< bounded features before they are bounded: speeds, then known numbers
};

/// Those that show every component.
std::vector<Eigen::Index> complete_frames(const SeenMotion& seen) {
  std::vector<Eigen::Index> frames;
  for (Eigen::Index k = 0; k < seen.times.size(); ++k) {
    if (seen.positions.row(k).allFinite()) frames.push_back(k);
  }
  return frames;
}

/// Places at even intervals back from the newest, between frames on straight lines.
std::optional<Recent> recent_of(const SeenMotion& seen, const Eigen::VectorXd& known,
                                const Components& components) {
  const std::vector<Eigen::Index> frames = complete_frames(seen);
  if (frames.size() < 4) return {};
  const Eigen::VectorXd times = seen.times(frames);
  const Eigen::MatrixXd positions = seen.positions(frames, Eigen::all);
  const double interval = median_interval(times);
  const Eigen::Index newest = times.size() - 1;
  Recent recent{.last = positions.row(newest)};
  recent.places.resize(Autoregression::kPlaces - 1, positions.cols());
  Eigen::Index after = newest;
  for (Eigen::Index k = 0; k < recent.places.rows(); ++k) {
    // A motion seen for less goes on backwards as it was first seen: the oldest two frames.
    const double at = times[newest] - static_cast<double>(k + 1) * interval;
    while (after > 1 && times[after - 1] >= at) --after;
    const double part = (at - times[after - 1]) / (times[after] - times[after - 1]);
    recent.places.row(k) =
        positions.row(after - 1) + part * (positions.row(after) - positions.row(after - 1)) - recent.last;
  }
  recent.rates = recent_rates(seen);
  const std::vector<int> others = others_of(components, positions.cols());
  const bool has_level = !components.level.empty();
  recent.speeds.resize(std::ssize(others) + (has_level ? 1 : 0) + known.size());
  Eigen::Index place = 0;
  for (const int c : others) recent.speeds[place++] = recent.rates(0, c);
  if (has_level) recent.speeds[place++] = recent.rates(0, components.level).squaredNorm();
  recent.speeds.tail(known.size()) = known;
  return recent;
}

}  // namespace

Eigen::MatrixXd recent_rates(const SeenMotion& seen) {
  const std::vector<Eigen::Index> frames = complete_frames(seen);
  if (frames.size() < 4) return Eigen::MatrixXd::Constant(3, seen.positions.cols(), kUnsaid);
  const Eigen::VectorXd times = seen.times(frames);
  const Eigen::Index count = std::min<Eigen::Index>(kCubicFrames, times.size());
  Eigen::MatrixXd powers(count, 4);
  powers.col(0).setOnes();
  const Eigen::ArrayXd since = (times.tail(count).array() - times[times.size() - 1]) / median_interval(times);
  for (Eigen::Index k = 1; k < 4; ++k) powers.col(k) = powers.col(k - 1).array() * since;
  const Eigen::MatrixXd positions = seen.positions(frames, Eigen::all);
  return powers.colPivHouseholderQr().solve(positions.bottomRows(count)).bottomRows(3);
}

namespace {

/// The terms whose weights are sought.
struct Terms {
  Eigen::MatrixXd level = {};                ///< terms x level components
  std::vector<Eigen::VectorXd> others = {};  ///< of each of the others; the first is the constant
};

Terms terms_of(const Recent& recent, const Eigen::VectorXd& middle, const Eigen::VectorXd& width,
               const Components& components) {
  const Eigen::VectorXd z = ((recent.speeds - middle).array() / width.array()).tanh();
  const Eigen::Index places = recent.places.rows(), bounded = z.size();
  const auto varying = [&](int c, Eigen::Ref<Eigen::VectorXd> terms) {
    for (Eigen::Index i = 0; i < bounded; ++i) terms.segment<3>(3 * i) = z[i] * recent.rates.col(c);
  };
  Terms terms;
  terms.level.resize(places + 3 * bounded, std::ssize(components.level));
  for (std::size_t k = 0; k < components.level.size(); ++k) {
    const int c = components.level[k];
    Eigen::VectorXd column(places + 3 * bounded);
    column.head(places) = recent.places.col(c);
    varying(c, column.tail(3 * bounded));
    terms.level.col(static_cast<Eigen::Index>(k)) = column;
  }
  for (const int c : others_of(components, recent.last.size())) {
    const Eigen::Index products = bounded * (bounded + 1) / 2;
    Eigen::VectorXd column(1 + places + 3 * bounded + bounded + products);
    column[0] = 1.0;
    column.segment(1, places) = recent.places.col(c);
    varying(c, column.segment(1 + places, 3 * bounded));
    column.segment(1 + places + 3 * bounded, bounded) = z;
    Eigen::Index place = column.size() - products;
    for (Eigen::Index i = 0; i < bounded; ++i)
      for (Eigen::Index j = 0; j <= i; ++j) column[place++] = z[i] * z[j];
    terms.others.push_back(std::move(column));
  }
  return terms;
}

/// A row for each number that is to be met.
struct Equations {
  Eigen::MatrixXd terms = {};
  Eigen::VectorXd wanted = {};
};

/// Least squares with weights of the rows and a penalty on weights of terms, each in its own size.
/// @param free the first term is not penalised
Eigen::VectorXd solve_weighted(const Equations& equations, const Eigen::VectorXd& rows, double penalty,
                               bool free) {
  const Eigen::VectorXd sizes =
      ((equations.terms.array().square().colwise() * rows.array()).colwise().sum() / rows.sum())
          .sqrt()
          .transpose()
          .max(std::numeric_limits<double>::min());
  const Eigen::MatrixXd scaled = equations.terms * sizes.cwiseInverse().asDiagonal();
  Eigen::MatrixXd normal = scaled.transpose() * rows.asDiagonal() * scaled;
  normal.diagonal().array() += penalty;
  if (free) normal(0, 0) -= penalty;
  const Eigen::VectorXd right = scaled.transpose() * (rows.cwiseProduct(equations.wanted));
  return normal.ldlt().solve(right).cwiseQuotient(sizes);
}

}  // namespace

struct Autoregression::Steps {
  static Eigen::RowVectorXd moved_by(const Terms& terms, const Weights& weights,
                                     const Components& components);
  static Weights solve(const std::vector<Terms>& terms, const Eigen::MatrixXd& moved,
                       const Components& components, double penalty);
  static std::vector<Weights> solve_without(const std::vector<Terms>& terms, const Eigen::MatrixXd& moved,
                                            const std::vector<std::size_t>& parts,
                                            const Components& components, double penalty);
};

Eigen::RowVectorXd Autoregression::Steps::moved_by(const Terms& terms, const Weights& weights,
                                                   const Components& components) {
  const auto count = std::ssize(components.level) + std::ssize(terms.others);
  Eigen::RowVectorXd moved(count);
  if (!components.level.empty()) moved(components.level) = weights.level.transpose() * terms.level;
  const std::vector<int> others = others_of(components, count);
  for (std::size_t k = 0; k < others.size(); ++k)
    moved[others[k]] = weights.own.col(static_cast<Eigen::Index>(k)).dot(terms.others[k]);
  return moved;
}

/// @param moved from the last place seen to the next, measured
Autoregression::Weights Autoregression::Steps::solve(const std::vector<Terms>& terms,
                                                     const Eigen::MatrixXd& moved,
                                                     const Components& components, double penalty) {
  constexpr int kReweightings = 4;
  constexpr double kHuber = 1.5;  // median distances
  const Eigen::Index count = moved.rows(), levels = std::ssize(components.level);
  const std::vector<int> others = others_of(components, moved.cols());
  Equations level{Eigen::MatrixXd(count * levels, terms.front().level.rows()),
                  Eigen::VectorXd(count * levels)};
  std::vector<Equations> own(others.size());
  for (std::size_t o = 0; o < own.size(); ++o) own[o].terms.resize(count, terms.front().others[o].size());
  for (Eigen::Index k = 0; k < count; ++k) {
    const Terms& one = terms[static_cast<std::size_t>(k)];
    level.terms.middleRows(k * levels, levels) = one.level.transpose();
    level.wanted.segment(k * levels, levels) = moved(k, components.level).transpose();
    for (std::size_t o = 0; o < own.size(); ++o) own[o].terms.row(k) = one.others[o].transpose();
  }
  for (std::size_t o = 0; o < own.size(); ++o) own[o].wanted = moved.col(others[o]);
  Eigen::VectorXd rows = Eigen::VectorXd::Ones(count);
  Weights solved;
  for (int turn = 0; turn < kReweightings; ++turn) {
    if (levels > 0) {
      Eigen::VectorXd of_levels(count * levels);
      for (Eigen::Index k = 0; k < count; ++k) of_levels.segment(k * levels, levels).setConstant(rows[k]);
      solved.level = solve_weighted(level, of_levels, penalty, false);
    }
    for (std::size_t o = 0; o < own.size(); ++o) {
      const Eigen::VectorXd column = solve_weighted(own[o], rows, penalty, true);
      solved.own.conservativeResize(column.size(), std::ssize(own));
      solved.own.col(static_cast<Eigen::Index>(o)) = column;
    }
    std::vector<double> distances;
    for (Eigen::Index k = 0; k < count; ++k) {
      const Terms& one = terms[static_cast<std::size_t>(k)];
      distances.push_back((Steps::moved_by(one, solved, components) - moved.row(k)).norm());
    }
    const double bend = kHuber * median(distances);
    for (Eigen::Index k = 0; k < count; ++k) {
      const double distance = distances[static_cast<std::size_t>(k)];
      rows[k] = distance <= bend ? 1.0 : bend / distance;
    }
  }
  return solved;
}

std::vector<Autoregression::Weights> Autoregression::Steps::solve_without(
    const std::vector<Terms>& terms, const Eigen::MatrixXd& moved, const std::vector<std::size_t>& parts,
    const Components& components, double penalty) {
  std::vector<Weights> without;
  for (std::size_t part = 0; part <= *std::ranges::max_element(parts); ++part) {
    std::vector<Terms> fitted;
    std::vector<Eigen::Index> rows;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (parts[k] == part) continue;
      fitted.push_back(terms[k]);
      rows.push_back(static_cast<Eigen::Index>(k));
    }
    without.push_back(solve(fitted, moved(rows, Eigen::all), components, penalty));
  }
  return without;
}

namespace {

void check_moments(std::span<const TrainingMoment> moments, const Components& components) {
  for (const TrainingMoment& moment : moments) {
    const Eigen::Index count = moments.front().next.size();
    if (moment.next.size() == count && moment.seen.positions.cols() == count &&
        moment.seen.positions.rows() == moment.seen.times.size() &&
        moment.known.size() == moments.front().known.size() && moment.known.allFinite())
      continue;
    throw ArgumentError(fmt::format(
        "a training moment has {} components seen in {} frames of {} times, {} next and {} known numbers; {} "
        "components, as many frames as times, and {} finite known numbers were expected",
        moment.seen.positions.cols(), moment.seen.positions.rows(), moment.seen.times.size(),
        moment.next.size(), moment.known.size(), count, moments.front().known.size()));
  }
  for (const int c : components.level) {
    if (moments.empty() || (c >= 0 && c < moments.front().next.size())) continue;
    throw ArgumentError(
        fmt::format("level component {} of {} components; a smaller number was expected, 0 or more", c,
                    moments.front().next.size()));
  }
}

}  // namespace

Autoregression Autoregression::fit(std::span<const TrainingMoment> moments, const Components& components) {
  check_moments(moments, components);
  Autoregression result;
  result.components_ = components;
  if (moments.empty()) return result;
  std::vector<Recent> recents;
  std::vector<Eigen::Index> rows;
  std::vector<std::size_t> parts;  // as cards are dealt, in the order of the clusters' first moments
  for (std::size_t k = 0; k < moments.size(); ++k) {
    auto recent = recent_of(moments[k].seen, moments[k].known, components);
    if (!recent || !moments[k].next.allFinite()) continue;
    recents.push_back(std::move(*recent));
    rows.push_back(static_cast<Eigen::Index>(k));
    const std::size_t next_part = result.part_of_.size() % kParts;
    parts.push_back(result.part_of_.try_emplace(moments[k].cluster, next_part).first->second);
  }
  if (result.part_of_.size() < 2) return result;

  const Eigen::Index bounded = recents.front().speeds.size();
  result.middle_.resize(bounded);
  result.width_.resize(bounded);
  for (Eigen::Index i = 0; i < bounded; ++i) {
    std::vector<double> values;
    for (const Recent& recent : recents) values.push_back(recent.speeds[i]);
    result.middle_[i] = median(values);
    double squares = 0.0;
    for (const double value : values) squares += std::pow(value - result.middle_[i], 2);
    constexpr double kWide = 1.5;  // root mean square distances: nearly straight within one
    result.width_[i] = std::max(kWide * std::sqrt(squares / static_cast<double>(values.size())),
                                std::numeric_limits<double>::min());
  }
  std::vector<Terms> terms;
  Eigen::MatrixXd moved(std::ssize(rows), moments.front().next.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    terms.push_back(terms_of(recents[k], result.middle_, result.width_, components));
    moved.row(static_cast<Eigen::Index>(k)) =
        moments[static_cast<std::size_t>(rows[k])].next - recents[k].last;
  }
  double least = std::numeric_limits<double>::infinity(), chosen = kPenalties[0];
  for (const double penalty : kPenalties) {
    std::vector<Weights> without = Steps::solve_without(terms, moved, parts, components, penalty);
    double sum = 0.0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      sum += (Steps::moved_by(terms[k], without[parts[k]], components) - moved.row(row)).norm();
    }
    if (!(sum < least)) continue;
    least = sum;
    chosen = penalty;
    result.without_ = std::move(without);
  }
  if (result.is_fitted()) result.weights_ = Steps::solve(terms, moved, components, chosen);
  return result;
}

Eigen::RowVectorXd Autoregression::predict(const SeenMotion& seen, const Eigen::VectorXd& known) const {
  return predict(weights_, seen, known);
}

Eigen::RowVectorXd Autoregression::predict_without(int cluster, const SeenMotion& seen,
                                                   const Eigen::VectorXd& known) const {
  const auto part = part_of_.find(cluster);
  return predict(part == part_of_.end() || !is_fitted() ? weights_ : without_[part->second], seen, known);
}

Eigen::RowVectorXd Autoregression::predict(const Weights& weights, const SeenMotion& seen,
                                           const Eigen::VectorXd& known) const {
  const Eigen::Index count = seen.positions.cols();
  const auto recent = is_fitted() ? recent_of(seen, known, components_) : std::nullopt;
  if (!recent) return Eigen::RowVectorXd::Constant(count, kUnsaid);
  if (recent->speeds.size() != middle_.size()) {
    throw ArgumentError(fmt::format(
        "a motion of {} components and {} known numbers was asked for; as many as in training were expected",
        count, known.size()));
  }
  return recent->last +
         Steps::moved_by(terms_of(*recent, middle_, width_, components_), weights, components_);
}

}  // namespace samara::identification
