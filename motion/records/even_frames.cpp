#include "samara/motion/records/even_frames.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/motion/records/motion_record.h"

namespace samara::motion {

using identification::median_interval;

namespace {

/// The frame before the first gap that is too long.
std::optional<Eigen::Index> before_long_gap(const Eigen::VectorXd& times, double interval) {
  for (Eigen::Index k = 0; k + 1 < times.size(); ++k) {
    if ((times[k + 1] - times[k]) / interval > static_cast<double>(kLongestGap) + 1.5) return k;
  }
  return {};
}

}  // namespace

std::vector<BetweenFrames> even_frames(const Eigen::VectorXd& times) {
  if (const std::string gap = long_gap(times); !gap.empty()) throw ArgumentError(gap);
  const double interval = median_interval(times);
  std::vector<BetweenFrames> frames;
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    frames.push_back({k, 0.0});
    if (k + 1 == times.size()) break;
    const double steps = (times[k + 1] - times[k]) / interval;
    if (steps < 1.5) continue;
    const auto pieces = std::lround(steps);
    for (long piece = 1; piece < pieces; ++piece)
      frames.push_back({k, static_cast<double>(piece) / static_cast<double>(pieces)});
  }
  return frames;
}

std::string long_gap(const Eigen::VectorXd& times) {
  const double interval = median_interval(times);
  const auto k = before_long_gap(times, interval);
  if (!k) return "";
  return fmt::format(
      "the record has no frames from {:.6g} to {:.6g} s, {:.0f} at its rate, expected at most {}: "
      "its parts may be records of their own",
      times[*k], times[*k + 1], (times[*k + 1] - times[*k]) / interval - 1.0, kLongestGap);
}

Eigen::MatrixXd between(const Eigen::MatrixXd& values, const std::vector<BetweenFrames>& frames) {
  Eigen::MatrixXd all(static_cast<Eigen::Index>(frames.size()), values.cols());
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const auto& [k, share] = frames[n];
    all.row(static_cast<Eigen::Index>(n)) = values.row(k);
    if (share > 0.0) all.row(static_cast<Eigen::Index>(n)) += share * (values.row(k + 1) - values.row(k));
  }
  return all;
}

Eigen::VectorXd divided_difference(const Eigen::Ref<const Eigen::VectorXd>& times) {
  const double width = times[times.size() - 1] - times[0];
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(times.size());
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    for (Eigen::Index j = 0; j < times.size(); ++j) {
      if (j != i) weights[i] *= width / (times[i] - times[j]);
    }
  }
  return weights.normalized();
}

double deviation_of(const Eigen::Ref<const Eigen::VectorXd>& differences) {
  if (differences.size() == 0) return 0.0;
  Eigen::VectorXd sizes = differences.cwiseAbs();
  const auto middle = sizes.begin() + sizes.size() / 2;
  std::nth_element(sizes.begin(), middle, sizes.end());
  return 1.4826 * *middle;
}

double noise_of(const Eigen::Ref<const Eigen::VectorXd>& values, const Eigen::VectorXd& times) {
  if (values.size() < 5) return 0.0;
  const double longest = 1.5 * median_interval(times);
  std::vector<double> any, whole;
  for (Eigen::Index k = 0; k + 5 <= values.size(); ++k) {
    any.push_back(divided_difference(times.segment(k, 5)).dot(values.segment(k, 5)));
    const bool has_gap = ((times.segment(k + 1, 4) - times.segment(k, 4)).array() >= longest).any();
    if (!has_gap) whole.push_back(any.back());
  }
  const bool are_few = static_cast<Eigen::Index>(whole.size()) < kFewestFrames;
  const std::vector<double>& differences = are_few ? any : whole;
  return deviation_of(Eigen::Map<const Eigen::VectorXd>(differences.data(), std::ssize(differences)));
}

}  // namespace samara::motion
