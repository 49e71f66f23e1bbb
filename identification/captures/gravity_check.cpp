#include "samara/identification/captures/gravity_check.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "samara/identification/captures/capture_suspicions.h"
#include "samara/identification/smoothing/smoothing.h"

namespace samara::identification {

namespace {

using Eigen::Index;

/// How a body at rest begins to move.
struct Weight {
  std::vector<std::string> places = {};  ///< states that are places
  Eigen::VectorXd acceleration = {};     ///< of each, m/s^2
};

/// When and where a body is let go: all other places are 0.
struct LetGo {
  double time = 0.0;       ///< s
  std::string place = {};  ///< empty: none
  double at = 0.0;         ///< m, along that place
};

/// Without velocities and turns, the rates of places are zero; a moment later they are not.
Weight weight_of(const models::ParametricModel& equations, std::span<const double> q,
                 const LetGo& let_go = {}) {
  constexpr double kMoment = 1e-4;  // s
  const std::vector<models::StateInfo>& states = equations.model().info().states;
  std::vector<double> rest(states.size(), 0.0), rates(states.size()), later(states.size());
  for (std::size_t s = 0; s < states.size(); ++s) {
    rest[s] = states[s].name == "qw" ? 1.0 : 0.0;
    if (states[s].name == let_go.place) rest[s] = let_go.at;
  }
  auto workspace = equations.make_workspace();
  equations.rhs(let_go.time, rest, q, rates, workspace);
  for (std::size_t s = 0; s < states.size(); ++s) later[s] = rest[s] + kMoment * rates[s];
  const std::vector<double> before = rates;
  equations.rhs(let_go.time + kMoment, later, q, rates, workspace);
  Weight weight;
  std::vector<double> accelerations;
  for (std::size_t s = 0; s < states.size(); ++s) {
    const bool is_place = states[s].unit == "m" && states[s].name.size() == 1;
    if (!is_place) continue;
    weight.places.push_back(states[s].name);
    accelerations.push_back((rates[s] - before[s]) / kMoment);
  }
  weight.acceleration = Eigen::Map<Eigen::VectorXd>(accelerations.data(), std::ssize(accelerations));
  return weight;
}

/// The axis along which the weight acts, "-z".
std::string axis_of(const Weight& weight) {
  Index axis = 0;
  weight.acceleration.cwiseAbs().maxCoeff(&axis);
  return fmt::format("{}{}", weight.acceleration[axis] < 0.0 ? "-" : "+",
                     weight.places[static_cast<std::size_t>(axis)]);
}

/// Whether it is the same all along its axis, and at all times: a spring or a drive pulls here and now one way, there
/// and then another, and is no weight.
bool is_steady(const models::ParametricModel& equations, std::span<const double> q, const Weight& weight) {
  constexpr double kSame = 0.1;
  Index axis = 0;
  const double most = kSame * weight.acceleration.cwiseAbs().maxCoeff(&axis);
  const std::string& place = weight.places[static_cast<std::size_t>(axis)];
  std::vector<LetGo> others = {{.place = place, .at = -1.0}, {.place = place, .at = 1.0}};
  for (const double time : {0.1, 1.3, 17.0}) others.push_back({.time = time});
  return std::ranges::none_of(others, [&](const LetGo& other) {
    const Weight there = weight_of(equations, q, other);
    return std::abs(there.acceleration[axis] - weight.acceleration[axis]) > most;
  });
}

/// What turns the world of a capture, as a sidecar says it, or is to be left out of one.
std::string remedy(const Capture& capture, const Weight& weight) {
  const std::string axis = axis_of(weight).substr(1);
  if (!capture.up.empty()) {
    return fmt::format("up = \"{}\" in its sidecar turns it",
                       capture.up[0] == '-' ? capture.up.substr(1) : "-" + capture.up);
  }
  if (capture.has("qw")) return fmt::format("up = \"-{}\" in a sidecar turns it", axis);
  const bool was_flipped = capture.channel(axis).is_flipped;
  std::string names = fmt::format("\"{}\"", axis);
  // In a mirrored plane angles count the other way.
  for (const char* const turn : {"theta", "w"}) {
    if (capture.has(turn) && (!was_flipped || capture.channel(turn).is_flipped))
      names += fmt::format(", \"{}\"", turn);
  }
  return was_flipped ? fmt::format("flip = [{}] of its sidecar turned it: leave that out", names)
                     : fmt::format("flip = [{}] in a sidecar turns it", names);
}

/// Downward, m, frame by frame; empty where it was not measured.
std::optional<Eigen::VectorXd> depths(const Capture& capture, const Weight& weight) {
  constexpr double kMatters = 0.1;
  const Eigen::VectorXd down = weight.acceleration.normalized();
  Eigen::VectorXd result = Eigen::VectorXd::Zero(capture.times.size());
  for (std::size_t k = 0; k < weight.places.size(); ++k) {
    const double part = down[static_cast<Index>(k)];
    if (std::abs(part) < kMatters) continue;
    if (!capture.has(weight.places[k]) || capture.channel(weight.places[k]).unit != "m") return {};
    result += part * capture.channel(weight.places[k]).values;
  }
  return result;
}

/// The share of frames in which the body rises, where it does so unslowed.
std::optional<double> unslowed_rise(const Capture& capture, const Weight& weight) {
  constexpr Index kFewestFrames = 10;
  constexpr Index kFrames = 40;     // enough of a long recording
  constexpr double kCertain = 3.0;  // standard errors of a velocity
  constexpr double kShare = 0.3;    // of the frames
  constexpr double kSlowed = 0.2;   // of the acceleration of a body at rest
  const std::optional<Eigen::VectorXd> depth = depths(capture, weight);
  if (!depth || !capture.times.allFinite()) return {};
  std::vector<Index> seen;
  for (Index k = 0; k < depth->size(); ++k) {
    if (!std::isfinite((*depth)[k])) continue;
    if (!seen.empty() && !(capture.times[k] > capture.times[seen.back()])) return {};
    seen.push_back(k);
  }
  const Index stride = 1 + std::ssize(seen) / kFrames;
  std::vector<Index> some;
  for (Index k = 0; k < std::ssize(seen); k += stride) some.push_back(seen[static_cast<std::size_t>(k)]);
  if (std::ssize(some) < kFewestFrames) return {};
  const Eigen::VectorXd times = capture.times(some);
  const Smoothed path = smooth(times, (*depth)(some), times,
                               {.degree = 2, .bandwidth = 0.25 * (times[times.size() - 1] - times[0])});
  double rising = 0.0, slowed = 0.0;
  for (Index k = 0; k < times.size(); ++k) {
    if (!(path.rate(k, 0) < -kCertain * path.rate_error(k, 0))) continue;
    rising += 1.0;
    slowed += path.acceleration(k, 0);
  }
  const double share = rising / static_cast<double>(times.size());
  if (share < kShare || slowed / rising > kSlowed * weight.acceleration.norm()) return {};
  return share;
}

constexpr double kHeavy = 0.5;  // m/s^2

}  // namespace

bool falls(const models::ParametricModel& equations, std::span<const double> q) {
  const Weight weight = weight_of(equations, q);
  return weight.places.empty() || !(weight.acceleration.norm() < kHeavy);
}

std::vector<std::string> check_gravity(const models::ParametricModel& equations, std::span<const double> q,
                                       std::span<const Capture> captures) {
  const Weight weight = weight_of(equations, q);
  // A body that nearly floats is moved by anything else.
  if (weight.places.empty() || !(weight.acceleration.norm() > kHeavy)) return {};
  if (!is_steady(equations, q, weight)) return {};
  std::vector<std::pair<std::string, std::string>> found;
  for (const Capture& capture : captures) {
    const std::optional<double> share = unslowed_rise(capture, weight);
    if (!share) continue;
    found.emplace_back(
        capture.id,
        fmt::format("it moves against the weight of the model, which acts along {}, in {:.0f} % of "
                    "its frames without being slowed: is an axis upside down? ({})",
                    axis_of(weight), 100.0 * *share, remedy(capture, weight)));
  }
  return merge_alike(found);
}

}  // namespace samara::identification
