#include "bound.h"

#include <algorithm>
#include <cmath>

#include "cases.h"
#include "samara/base/streams.h"
#include "samara/identification/fit/fitted_motion.h"

namespace samara::benchmarks::prediction {

using identification::Window;
using samara::identification::Capture;
using samara::identification::Channel;

namespace {

constexpr int kOrder = 5;  ///< of differences
constexpr std::uint64_t kSeed = 28;

Eigen::VectorXd differences(Eigen::VectorXd values, int order) {
  for (int k = 0; k < order; ++k)
    values = (values.tail(values.size() - 1) - values.head(values.size() - 1)).eval();
  return values;
}

/// By how much those of white noise are larger than it, if each frame is the mean of so many.
double gain_of_differences(int averaged) {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(2 * kOrder + averaged);
  weights.segment(kOrder, averaged).setConstant(1.0 / averaged);
  return differences(weights, kOrder).norm();
}

/// Frames x 3 of noise.
Eigen::MatrixX3d drawn_noise(const Bound& bound, Eigen::Index frames, Stream& stream) {
  Eigen::MatrixX3d noise = Eigen::MatrixX3d::Zero(frames, 3);
  Eigen::MatrixX3d white(frames + bound.averaged - 1, 3);
  for (Eigen::Index k = 0; k < white.rows(); ++k)
    for (Eigen::Index c = 0; c < 3; ++c) white(k, c) = bound.noise[c] * stream.normal();
  for (int k = 0; k < bound.averaged; ++k) noise += white.middleRows(k, frames) / bound.averaged;
  return noise;
}

/// Windows of motions of the body that are as near to the given ones as it comes.
std::vector<Window> made(const Bound& bound, std::span<const Window> windows, std::uint64_t draw) {
  const auto states =
      identification::predict_unseen(*bound.family, bound.options, bound.coefficients, windows);
  const auto held = identification::with_coefficients(bound.options, bound.coefficients);
  std::vector<Window> result;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    Window window = windows[k];
    const Eigen::VectorXd& times = window.capture.times;
    const auto motion = samara::identification::fitted_motion(*bound.family, held, states.fit, k,
                                                              {times.begin(), times.end()}, {"x", "y", "z"});
    window.next = states.next.row(static_cast<Eigen::Index>(k));
    if (!motion || !motion->allFinite() || !window.next.allFinite()) continue;
    Stream stream(kSeed + draw, k);
    const Eigen::Index frames = times.size();
    const double interval = (times[frames - 1] - times[0]) / static_cast<double>(frames - 1);
    const auto next = static_cast<Eigen::Index>(std::lround((window.next_time - times[0]) / interval));
    const Eigen::MatrixX3d noise = drawn_noise(bound, next + 1, stream);
    for (Channel& channel : window.capture.channels) {
      if (channel.unit != "m") continue;
      const int c = channel.quantity[0] - 'x';
      channel.values = motion->col(c) + noise.col(c).head(frames);
    }
    window.next += noise.row(next);
    result.push_back(std::move(window));
  }
  return result;
}

std::vector<AskedMoment> asked(const Bound& bound, std::span<const Window> windows, std::uint64_t draw) {
  const std::vector<Window> all = made(bound, windows, draw);
  const auto predicted =
      identification::predict_unseen(*bound.family, bound.options, bound.coefficients, all);
  std::vector<AskedMoment> moments;
  for (std::size_t k = 0; k < all.size(); ++k)
    moments.push_back(bound.moment_of(all[k], predicted.next.row(static_cast<Eigen::Index>(k))));
  return moments;
}

double judged_noise(const Bound& bound) {
  constexpr Eigen::Index kDraws = 20000;
  Stream stream(kSeed, 0);
  const Eigen::VectorXd distances = drawn_noise(bound, kDraws, stream).rowwise().norm();
  return identification::median_of({distances.begin(), distances.end()});
}

}  // namespace

Eigen::RowVector3d noise_of(std::span<const Capture> motions, int averaged) {
  constexpr double kMedianOfNormal = 0.6745;  // of |x|, in standard deviations
  Eigen::RowVector3d noise;
  for (Eigen::Index c = 0; c < 3; ++c) {
    std::vector<double> sizes;
    for (const Capture& motion : motions) {
      if (motion.frame_count() <= kOrder) continue;
      for (const double value : differences(identification::positions_of(motion).col(c), kOrder)) {
        if (std::isfinite(value)) sizes.push_back(std::abs(value));
      }
    }
    noise[c] = identification::median_of(std::move(sizes)) / kMedianOfNormal / gain_of_differences(averaged);
  }
  return noise;
}

void report_bound(const std::string& test_case, const std::string& suffix, const Bound& bound,
                  std::span<const Window> training, std::span<const Window> unseen) {
  const std::vector<AskedMoment> known = asked(bound, training, 1), wanted = asked(bound, unseen, 2);
  report(test_case, {score_split(test_case + suffix, known, wanted)}, suffix);
  print({kBench, test_case, "judged_noise" + suffix, judged_noise(bound), "m"});
}

}  // namespace samara::benchmarks::prediction
