#include "samara/identification/smoothing/local_polynomial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Dense>

#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

using Eigen::Index;
using Frames = std::vector<Index>;

/// Times that differ by rounding are the same.
constexpr double kSameTime = 1e-3;

/// A polynomial through as many frames as it has terms leaves no distance.
constexpr double kLeastVariance = 1e-12;

constexpr int kAbsoluteIterations = 8;
constexpr int kReweightings = 4;

Eigen::VectorXd picked(const Eigen::VectorXd& all, const Frames& frames) {
  Eigen::VectorXd part(static_cast<Index>(frames.size()));
  for (Index k = 0; k < part.size(); ++k) part[k] = all[frames[static_cast<std::size_t>(k)]];
  return part;
}

/// What noise makes of a fit. @param levers coefficients = levers * values; for independent noise, rows
/// of the same length do
void carry_noise(const LocalFrames& all, const Eigen::VectorXd& since, const Eigen::MatrixXd& levers,
                 double reach, LocalPolynomial& fit) {
  // Of running means over a range: by how much of it they overlap.
  const double range = all.averaged * all.interval;
  const auto overlap = [&](const auto& distance) {
    return (1.0 - distance.abs() / range).max(0.0).matrix().eval();
  };
  const bool is_correlated = all.averaged > 1;
  Eigen::MatrixXd correlation;
  if (is_correlated) {
    correlation.resize(since.size(), since.size());
    for (Index k = 0; k < since.size(); ++k) correlation.col(k) = overlap(since.array() - since[k]);
  }
  double scale = 1.0;  // k! / reach^k
  for (Index k = 0; k < std::min<Index>(3, levers.rows()); ++k) {
    if (k > 0) scale *= static_cast<double>(k) / reach;
    const Eigen::RowVectorXd lever = levers.row(k);
    fit.deviations[k] =
        scale * std::sqrt(is_correlated ? lever * correlation * lever.transpose() : lever.squaredNorm());
  }
  if (is_correlated) {
    fit.with_frame = levers.row(0) * overlap(since.array());
  } else if ((since.array() == 0.0).any()) {
    fit.with_frame = fit.deviations[0] * fit.deviations[0];
  }
}

/// fit_local(), if wanted without what it says about noise.
LocalPolynomial solve_local(const LocalFrames& all, const Frames& frames, double t0,
                            const Eigen::VectorXd& weights, const Eigen::MatrixXd& values, bool with_noise) {
  const Eigen::VectorXd since = picked(all.times, frames).array() - t0;
  const double reach = since.cwiseAbs().maxCoeff();
  const auto terms = std::min<Index>(all.degree + 1, since.size());
  Eigen::MatrixXd basis(since.size(), terms);
  basis.col(0).setOnes();
  for (Index k = 1; k < terms; ++k) basis.col(k) = basis.col(k - 1).cwiseProduct(since) / reach;

  const Eigen::VectorXd root = weights.cwiseSqrt();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(root.asDiagonal() * basis);
  const Eigen::MatrixXd coefficients = qr.solve(Eigen::MatrixXd(root.asDiagonal() * values));
  LocalPolynomial fit;
  fit.residuals = values - basis * coefficients;
  fit.span = since[since.size() - 1] - since[0];
  fit.derivatives = Eigen::MatrixXd::Zero(3, values.cols());
  fit.deviations.setZero();
  double scale = 1.0;  // k! / reach^k
  for (Index k = 0; k < std::min<Index>(3, terms); ++k) {
    if (k > 0) scale *= static_cast<double>(k) / reach;
    fit.derivatives.row(k) = scale * coefficients.row(k);
  }
  if (!with_noise) return fit;
  // Rows of R^-1 are as long as those of R^-1 Q', which is all that independent noise asks for.
  const Eigen::MatrixXd levers =
      all.averaged > 1 ? qr.solve(Eigen::MatrixXd(root.asDiagonal()))
                       : Eigen::MatrixXd(qr.matrixQR().topRows(terms).triangularView<Eigen::Upper>().solve(
                             Eigen::MatrixXd::Identity(terms, terms)));
  carry_noise(all, since, levers, reach, fit);
  return fit;
}

/// Least absolute residuals by iterated reweighting: an outlier among the frames does not bend it.
LocalPolynomial fit_absolute(const LocalFrames& all, const Frames& frames, double t0,
                             const Eigen::MatrixXd& values, double least) {
  const auto count = static_cast<Index>(frames.size());
  LocalPolynomial fit = solve_local(all, frames, t0, Eigen::VectorXd::Ones(count), values, false);
  for (int k = 0; k < kAbsoluteIterations; ++k) {
    const Eigen::VectorXd sizes = fit.residuals.rowwise().norm();
    // Weights over many orders of magnitude would lose digits.
    const double floor = std::max(least, 1e-3 * sizes.mean());
    if (!(floor > 0.0)) break;
    fit = solve_local(all, frames, t0, sizes.cwiseMax(floor).cwiseInverse() * floor, values, false);
  }
  return fit;
}

/// Deviations of the frames (rows) from polynomials through their neighbours, over the standard deviation of
/// that for noise of size 1.
Eigen::MatrixXd deviations(const LocalFrames& frames, const LocalChart& chart, bool absolute, double least) {
  Eigen::MatrixXd result;
  for (Index i = 0; i < frames.count(); ++i) {
    const double t0 = frames.times[i];
    const Frames others = frames.around(t0, i);
    const Eigen::MatrixXd values = chart(i, others);
    const Eigen::VectorXd weights = picked(frames.weights, others);
    const Eigen::VectorXd equal = Eigen::VectorXd::Ones(weights.size());
    const LocalPolynomial plain = fit_local(frames, others, t0, absolute ? equal : weights, values);
    const Eigen::RowVectorXd predicted =
        (absolute ? fit_absolute(frames, others, t0, values, least) : plain).derivatives.row(0);
    if (i == 0) result.resize(frames.count(), values.cols());
    result.row(i) =
        (chart(i, {i}).row(0) - predicted) / std::sqrt(std::max(plain.distance_variance(), kLeastVariance));
  }
  return result;
}

/// Noise of each coordinate, from the medians of deviations.
Eigen::RowVectorXd scales_of(const Eigen::MatrixXd& deviations, const RobustOptions& options) {
  constexpr double kMedianOfNormal = 0.674490;
  Eigen::RowVectorXd scales(deviations.cols());
  for (Index k = 0; k < scales.size(); ++k) {
    const Eigen::VectorXd sizes = deviations.col(k).cwiseAbs();
    // A noise that is given too small would make outliers of what simply scatters more.
    scales[k] = std::max(options.noise.value_or(0.0), median({sizes.begin(), sizes.end()}) / kMedianOfNormal);
  }
  // A direction that hardly moves would make outliers of whatever moves in it.
  const double least = std::max(options.least_noise, 0.1 * scales.maxCoeff());
  return scales.cwiseMax(least);
}

Eigen::VectorXd lengths_of(const Eigen::MatrixXd& deviations, const Eigen::RowVectorXd& scales) {
  return (deviations.array().rowwise() / scales.array()).matrix().rowwise().norm();
}

/// Deviation of frame i from the polynomial through others, as deviations().
Eigen::RowVectorXd deviation_from(const LocalFrames& frames, const LocalChart& chart, Index i,
                                  const Frames& others) {
  const Eigen::MatrixXd values = chart(i, others);
  const LocalPolynomial fit =
      fit_local(frames, others, frames.times[i], Eigen::VectorXd::Ones(values.rows()), values);
  return (chart(i, {i}).row(0) - fit.derivatives.row(0)) /
         std::sqrt(std::max(fit.distance_variance(), kLeastVariance));
}

/// An outlier at an end of the record bends the polynomials there to itself, so that its neighbours seem
/// wrong. Seen from the inside it stands alone: frames of the last half bandwidth are held one by one against
/// those before them, and the first against those after them.
void judge_ends_from_inside(LocalFrames& frames, const LocalChart& chart, const Eigen::RowVectorXd& scales,
                            double limit) {
  const auto wanted = static_cast<std::size_t>(frames.degree) + 3;
  const auto test = [&](Index i, bool forward) {
    Frames inside;
    for (Index k = i + (forward ? -1 : 1); k >= 0 && k < frames.count(); k += forward ? -1 : 1) {
      if (std::abs(frames.times[k] - frames.times[i]) > frames.bandwidth && inside.size() >= wanted) break;
      if (frames.weights[k] > 0.0) inside.push_back(k);
    }
    if (inside.size() < wanted) return;
    if (forward) std::ranges::reverse(inside);
    frames.weights[i] = lengths_of(deviation_from(frames, chart, i, inside), scales)[0] <= limit ? 1.0 : 0.0;
  };
  const double half = 0.5 * frames.bandwidth;
  const double begin = frames.times[0];
  const double end = frames.times[frames.count() - 1];
  for (Index i = frames.count() - 1; i >= 0; --i) {
    if (frames.times[i] <= begin + half) test(i, false);
  }
  for (Index i = 0; i < frames.count(); ++i) {
    if (frames.times[i] >= end - half) test(i, true);
  }
}

}  // namespace

Frames LocalFrames::nearest(double t, std::size_t wanted, Index but) const {
  Frames found;
  Index after = std::ranges::lower_bound(times, t) - times.begin();
  Index before = after - 1;
  const auto is_usable = [&](Index i) { return weights[i] > 0.0 && i != but; };
  while (found.size() < wanted) {
    while (before >= 0 && !is_usable(before)) --before;
    while (after < count() && !is_usable(after)) ++after;
    if (before < 0 && after >= count()) break;
    const bool goes_back = after >= count() || (before >= 0 && t - times[before] < times[after] - t);
    found.push_back(goes_back ? before-- : after++);
  }
  std::ranges::sort(found);
  return found;
}

Frames LocalFrames::around(double t, Index but) const {
  const double slack = kSameTime * bandwidth / 15.0;
  const double begin = times[0];
  const double end = times[count() - 1];
  double lower = t - 0.5 * bandwidth;
  double upper = t + 0.5 * bandwidth;
  if (lower < begin) upper = begin + bandwidth;
  if (upper > end) lower = std::min(lower, end - bandwidth);
  Frames inside;
  const Index first = std::ranges::lower_bound(times, lower - slack) - times.begin();
  for (Index i = first; i < count() && times[i] <= upper + slack; ++i) {
    if (weights[i] > 0.0 && i != but) inside.push_back(i);
  }
  const auto wanted = static_cast<std::size_t>(degree) + 2;
  if (inside.size() >= wanted) return inside;
  return nearest(t, wanted, but);
}

LocalPolynomial fit_local(const LocalFrames& all, const Frames& frames, double t0,
                          const Eigen::VectorXd& weights, const Eigen::MatrixXd& values) {
  return solve_local(all, frames, t0, weights, values, true);
}

void weigh_outliers(LocalFrames& frames, const LocalChart& chart, Index coordinates,
                    const RobustOptions& options) {
  frames.weights.setOnes(frames.count());
  if (!std::isfinite(options.threshold)) return;
  // About as improbable for a vector as `threshold` is for a number.
  const double limit =
      std::sqrt(options.threshold * options.threshold + 3.0 * static_cast<double>(coordinates - 1));
  const auto judge = [&](bool absolute) {
    const Eigen::MatrixXd found = deviations(frames, chart, absolute, options.least_noise);
    const Eigen::RowVectorXd scales = scales_of(found, options);
    return std::pair(Eigen::ArrayXd(lengths_of(found, scales)), scales);
  };
  // Where most frames would be outliers none is: the noise that was given is not theirs.
  const auto weigh = [&](const Eigen::ArrayXd& weights) {
    const bool most_count = 2 * (weights > 0.0).count() >= weights.size();
    frames.weights = most_count ? weights : Eigen::ArrayXd::Ones(weights.size());
    return most_count;
  };
  Eigen::ArrayXd lengths = judge(true).first;
  for (int k = 0; k < kReweightings; ++k) {
    if (!weigh((1.0 - (lengths / limit).min(1.0).square()).square())) return;  // Tukey's bisquare
    lengths = judge(false).first;
  }
  // In the end a frame counts or not, so that standard errors are those of plain least squares.
  if (!weigh((lengths <= limit).cast<double>())) return;
  judge_ends_from_inside(frames, chart, judge(false).second, limit);
  weigh((judge(false).first <= limit).cast<double>());
  // Nor where a polynomial would go through all that are left: they would seem to have no noise.
  if ((frames.weights.array() > 0.0).count() < frames.degree + 2) frames.weights.setOnes();
}

double residual_noise(const LocalFrames& frames, const LocalChart& chart, Index coordinates) {
  std::vector<double> lengths;   // of residuals
  std::vector<double> freedoms;  // their variance for noise of size 1
  std::vector<double> sizes;     // of residuals over their standard deviation
  for (Index i = 0; i < frames.count(); ++i) {
    if (frames.weights[i] == 0.0) continue;
    const double t0 = frames.times[i];
    const Frames used = frames.around(t0);
    const Eigen::MatrixXd values = chart(i, used);
    const LocalPolynomial fit = fit_local(frames, used, t0, Eigen::VectorXd::Ones(values.rows()), values);
    const auto own = std::ranges::find(used, i) - used.begin();
    lengths.push_back(fit.residuals.row(own).norm());
    freedoms.push_back(std::max(fit.distance_variance(), kLeastVariance));
    sizes.push_back(lengths.back() / std::sqrt(freedoms.back()));
  }
  // An outlier at an end of the record may hide another; it should not count for all the rest.
  constexpr double kLargest = 7.5;  // medians: 5 standard deviations
  const double largest = kLargest * median(sizes);
  double squares = 0.0;
  double freedom = 0.0;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    if (sizes[k] > largest) continue;
    squares += lengths[k] * lengths[k];
    freedom += freedoms[k];
  }
  return std::sqrt(squares / (static_cast<double>(coordinates) * freedom));
}

}  // namespace samara::identification
