#include "samara/identification/forecasts/autoregression.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

constexpr double kUnsaid = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kParts = 5;  ///< of the clusters
constexpr double kPenalties[] = {1.0, 3.0, 10.0, 30.0, 100.0, 1000.0};

/// Speeds and known numbers before they are bounded.
Eigen::VectorXd speeds_of(const RecentMotion& recent, const Eigen::VectorXd& known,
                          const Components& components) {
  const std::vector<int> others = others_of(components, recent.last.size());
  const Eigen::Index levels = components.level.empty() ? 0 : 1;
  Eigen::VectorXd speeds(std::ssize(others) + levels + known.size());
  Eigen::Index place = 0;
  for (const int c : others) speeds[place++] = recent.rates(0, c);
  if (levels > 0) speeds[place++] = recent.rates(0, components.level).squaredNorm();
  speeds.tail(known.size()) = known;
  return speeds;
}

/// Of a motion that is to be corrected.
struct CorrectionMoment {
  LevelFrame frame;
  Mirrored features = {};
};

CorrectionMoment correction_moment(const SeenMotion& seen, const RecentMotion& recent,
                                   const Eigen::VectorXd& known, const Components& components,
                                   double way_back) {
  const Eigen::Vector4d intervals = Eigen::Vector4d(0.25, 0.5, 0.75, 1.0) * way_back;
  Eigen::MatrixXd displacements(recent.rates.rows() + intervals.size(), recent.last.size());
  displacements << recent.rates, places_back(seen, intervals);
  const LevelFrame frame(components, recent.rates.row(0));
  CorrectionMoment moment{.frame = frame, .features = frame.split(displacements)};
  // The velocity has no part across itself.
  if (components.level.size() == 2) moment.features.odd[0] = 0.0;
  const Eigen::Index count = moment.features.even.size();
  moment.features.even.conservativeResize(count + known.size());
  moment.features.even.tail(known.size()) = known;
  return moment;
}

/// The terms whose weights are sought.
struct Terms {
  Eigen::MatrixXd level = {};                ///< terms x level components
  std::vector<Eigen::VectorXd> others = {};  ///< of each of the others; the first is the constant
};

Terms terms_of(const RecentMotion& recent, const Eigen::VectorXd& speeds, const Eigen::VectorXd& middle,
               const Eigen::VectorXd& width, const Components& components) {
  const Eigen::VectorXd z = ((speeds - middle).array() / width.array()).tanh();
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
  /// A moment that was seen for long enough to teach more than a linear prediction.
  struct Taught {
    const TrainingMoment* moment;
    const RecentMotion* recent;
    std::size_t part;
    Eigen::RowVectorXd missed;  ///< by the linear prediction without the part
  };
  static Eigen::RowVectorXd moved_by(const Terms& terms, const Weights& weights,
                                     const Components& components);
  static Weights solve(const std::vector<Terms>& terms, const Eigen::MatrixXd& moved,
                       const Components& components, double penalty);
  static std::vector<Weights> solve_without(const std::vector<Terms>& terms, const Eigen::MatrixXd& moved,
                                            const std::vector<std::size_t>& parts,
                                            const Components& components, double penalty);
  static void add_correction(Autoregression& to, const std::vector<Taught>& taught);
  static void add_turning(Autoregression& to, const std::vector<Taught>& taught);
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
  std::vector<RecentMotion> recents;
  std::vector<Eigen::VectorXd> speeds;
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < moments.size(); ++k) {
    auto recent = recent_motion(moments[k].seen);
    if (!recent || !moments[k].next.allFinite()) continue;
    speeds.push_back(speeds_of(*recent, moments[k].known, components));
    recents.push_back(std::move(*recent));
    rows.push_back(k);
    result.part_of_[moments[k].cluster] = 0;
  }
  if (result.part_of_.size() < 2) return result;
  // Clusters are dealt as cards, in the order of their numbers.
  std::size_t dealt = 0;
  for (auto& [cluster, part] : result.part_of_) part = dealt++ % kParts;
  std::vector<std::size_t> parts;
  for (const std::size_t k : rows) parts.push_back(result.part_of_.at(moments[k].cluster));

  const Eigen::Index bounded = speeds.front().size();
  result.middle_.resize(bounded);
  result.width_.resize(bounded);
  for (Eigen::Index i = 0; i < bounded; ++i) {
    std::vector<double> values;
    for (const Eigen::VectorXd& one : speeds) values.push_back(one[i]);
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
    terms.push_back(terms_of(recents[k], speeds[k], result.middle_, result.width_, components));
    moved.row(static_cast<Eigen::Index>(k)) = moments[rows[k]].next - recents[k].last;
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
  if (!result.is_fitted()) return result;
  result.weights_ = Steps::solve(terms, moved, components, chosen);
  if (components.level.size() > 2) return result;
  std::vector<double> ways;
  for (const RecentMotion& recent : recents) ways.push_back(recent.seen_for);
  result.way_back_ = way_back(ways);
  std::vector<Steps::Taught> taught;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (recents[k].seen_for < kLeastSeen * result.way_back_) continue;
    taught.push_back({&moments[rows[k]], &recents[k], parts[k],
                      moved.row(static_cast<Eigen::Index>(k)) -
                          Steps::moved_by(terms[k], result.without_[parts[k]], components)});
  }
  Steps::add_correction(result, taught);
  if (components.level.size() == 2) Steps::add_turning(result, taught);
  return result;
}

void Autoregression::Steps::add_correction(Autoregression& to, const std::vector<Taught>& taught) {
  std::vector<Mirrored> features, missed;
  std::vector<std::size_t> parts;
  for (const Taught& one : taught) {
    CorrectionMoment moment =
        correction_moment(one.moment->seen, *one.recent, one.moment->known, to.components_, to.way_back_);
    missed.push_back(moment.frame.split(one.missed));
    features.push_back(std::move(moment.features));
    parts.push_back(one.part);
  }
  to.correction_ = KernelCorrection::fit(features, missed, parts);
}

void Autoregression::Steps::add_turning(Autoregression& to, const std::vector<Taught>& taught) {
  std::vector<TurningMoment> moments;
  for (const Taught& one : taught) {
    const auto& [cluster, seen, known, next] = *one.moment;
    const Eigen::RowVectorXd first = to.first_prediction(one.part, seen, *one.recent, known);
    moments.push_back({cluster, one.part, &seen, &known, next - one.recent->last, next - first});
  }
  to.turning_ = TurningPrediction::fit(moments, to.components_, to.way_back_);
}

Eigen::RowVectorXd Autoregression::predict(const SeenMotion& seen, const Eigen::VectorXd& known) const {
  return predict(kNoPart, seen, known);
}

Eigen::RowVectorXd Autoregression::predict_without(int cluster, const SeenMotion& seen,
                                                   const Eigen::VectorXd& known) const {
  const auto part = part_of_.find(cluster);
  return predict(part == part_of_.end() ? kNoPart : part->second, seen, known);
}

Eigen::RowVectorXd Autoregression::predict(std::size_t without, const SeenMotion& seen,
                                           const Eigen::VectorXd& known) const {
  const auto recent = is_fitted() ? recent_motion(seen) : std::nullopt;
  if (!recent) return Eigen::RowVectorXd::Constant(seen.positions.cols(), kUnsaid);
  const Eigen::RowVectorXd first = first_prediction(without, seen, *recent, known);
  if (!turning_.is_fitted() || !turning_.is_shown_by(seen) || recent->seen_for < kLeastSeen * way_back_)
    return first;
  const Eigen::RowVectorXd moved =
      without == kNoPart ? turning_.moved(seen, known) : turning_.moved_without(without, seen, known);
  return (1.0 - turning_.share()) * first + turning_.share() * (recent->last + moved);
}

Eigen::RowVectorXd Autoregression::first_prediction(std::size_t without, const SeenMotion& seen,
                                                    const RecentMotion& recent,
                                                    const Eigen::VectorXd& known) const {
  const Eigen::VectorXd speeds = speeds_of(recent, known, components_);
  if (speeds.size() != middle_.size()) {
    throw ArgumentError(fmt::format(
        "a motion of {} components and {} known numbers was asked for; as many as in training were expected",
        seen.positions.cols(), known.size()));
  }
  const Weights& weights = without == kNoPart ? weights_ : without_[without];
  const Eigen::RowVectorXd linear =
      recent.last +
      Steps::moved_by(terms_of(recent, speeds, middle_, width_, components_), weights, components_);
  if (!correction_.is_fitted() || recent.seen_for < kLeastSeen * way_back_) return linear;
  const CorrectionMoment moment = correction_moment(seen, recent, known, components_, way_back_);
  return linear + moment.frame.joined(without == kNoPart ? correction_.at(moment.features)
                                                         : correction_.without(without, moment.features));
}

}  // namespace samara::identification
