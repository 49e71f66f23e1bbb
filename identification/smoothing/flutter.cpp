#include "samara/identification/smoothing/flutter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/QR>
#include <Eigen/SVD>

#include "samara/base/require.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/smoothing/smoothing_checks.h"

namespace samara::identification {

namespace {

constexpr Eigen::Index kFewestFrames = 12;
constexpr double kFewestSwings = 1.5;
/// Of the scan, in widths of a peak.
constexpr double kScanStep = 0.15;

/// A parabola and one frequency fitted to the horizontal coordinates.
struct Oscillation {
  double rest = 0.0;      ///< sum of squares that is left
  Eigen::Matrix2d waves;  ///< rows: cosine, sine; columns: x, y
};

Oscillation oscillation(const Eigen::VectorXd& s, const Eigen::MatrixX2d& xy, double frequency) {
  const Eigen::ArrayXd phase = 2.0 * std::numbers::pi * frequency * s.array();
  Eigen::MatrixXd basis(s.size(), 5);
  basis << Eigen::VectorXd::Ones(s.size()), s, s.cwiseAbs2(), phase.cos().matrix(), phase.sin().matrix();
  const Eigen::MatrixXd solution = basis.householderQr().solve(Eigen::MatrixXd(xy));
  return {(xy - basis * solution).squaredNorm(), solution.bottomRows<2>()};
}

/// Where `rest` is least, between two frequencies, by golden sections.
double refined(const Eigen::VectorXd& s, const Eigen::MatrixX2d& xy, double lower, double upper) {
  const double ratio = 1.0 / std::numbers::phi;
  while (upper - lower > 1e-4 * upper) {
    const double left = upper - ratio * (upper - lower);
    const double right = lower + ratio * (upper - lower);
    if (oscillation(s, xy, left).rest < oscillation(s, xy, right).rest) {
      upper = right;
    } else {
      lower = left;
    }
  }
  return 0.5 * (lower + upper);
}

/// Times from the middle, and positions, of frames that were seen.
struct Seen {
  Eigen::VectorXd s;
  Eigen::MatrixX3d positions;
};

Seen seen_frames(const Eigen::VectorXd& times, const Eigen::MatrixX3d& positions) {
  check_times(times, positions.rows());
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    if (positions.row(k).allFinite()) rows.push_back(k);
  }
  Seen seen{times(rows), positions(rows, Eigen::all)};
  if (seen.s.size() > 0) seen.s.array() -= 0.5 * (seen.s[0] + seen.s[seen.s.size() - 1]);
  return seen;
}

}  // namespace

std::optional<Flutter> flutter(const Eigen::VectorXd& times, const Eigen::MatrixX3d& positions) {
  const auto [s, seen] = seen_frames(times, positions);
  if (s.size() < kFewestFrames) return {};
  const double duration = s[s.size() - 1] - s[0];
  const double lowest = kFewestSwings / duration;
  const double highest = 0.25 / median_interval(s);
  if (!(lowest < highest)) return {};
  const Eigen::MatrixX2d xy = seen.leftCols<2>();
  const double step = kScanStep / duration;
  double best = lowest;
  double least = oscillation(s, xy, lowest).rest;
  for (int k = 1; lowest + k * step <= highest; ++k) {
    const double rest = oscillation(s, xy, lowest + k * step).rest;
    if (rest < least) {
      least = rest;
      best = lowest + k * step;
    }
  }
  Flutter result;
  result.frequency = refined(s, xy, std::max(lowest, best - step), std::min(highest, best + step));
  const Eigen::MatrixXd waves = oscillation(s, xy, result.frequency).waves;
  result.amplitude = waves.jacobiSvd().singularValues()[0];
  Eigen::MatrixXd line(s.size(), 2);
  line << Eigen::VectorXd::Ones(s.size()), s;
  const Eigen::VectorXd heights = seen.col(2), fall = line.colPivHouseholderQr().solve(heights);
  result.fall_speed = -fall[1];
  return result;
}

std::optional<Flutter> typical_flutter(const Eigen::VectorXd& times, const Eigen::MatrixX3d& positions,
                                       double part) {
  require_positive(part, "part [s]", "typical_flutter");
  check_times(times, positions.rows());
  std::vector<double> speeds;
  std::vector<double> frequencies;
  std::vector<double> amplitudes;
  const double interval = median_interval(times);
  for (Eigen::Index first = 0; first < times.size();) {
    Eigen::Index count = 1;
    while (first + count < times.size() && times[first + count] < times[first] + part) ++count;
    const bool is_whole = times[first + count - 1] > times[first] + part - 1.5 * interval;
    if (const auto one = flutter(times.segment(first, count), positions.middleRows(first, count));
        one && is_whole) {
      speeds.push_back(one->fall_speed);
      frequencies.push_back(one->frequency);
      amplitudes.push_back(one->amplitude);
    }
    first += count;
  }
  if (speeds.empty()) return {};
  return Flutter{median(speeds), median(frequencies), median(amplitudes)};
}

}  // namespace samara::identification
