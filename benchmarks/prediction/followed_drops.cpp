#include "followed_drops.h"

#include <limits>

#include "identification/falling_paper.h"
#include "samara/identification/following/followed_motion.h"
#include "samara/models/laws/registry.h"

namespace samara::benchmarks::prediction {

using samara::identification::Capture;
using samara::identification::FitResult;
using samara::identification::FollowOptions;
using samara::identification::NoiseSearch;

namespace {

constexpr double kSteps = 5.2e-3;  // s: two a frame, as in the fit
constexpr double kAheadOf = 0.1;   // s
constexpr double kMotion = 0.2;    // s: origins of forecasts on which noise is chosen

}  // namespace

FollowedDrops::FollowedDrops(const std::vector<Capture>& drops, const FitResult& fitted,
                             const std::vector<identification::Window>& training)
    : fitted_(fitted) {
  fitted_.setup.unknowns.known = identification::paper_options().unknowns.known;
  for (const Capture& drop : drops) drops_.emplace(drop.labels.at("traj"), drop);
  std::map<std::string, Capture> trained;
  for (const identification::Window& window : training) {
    const std::string& name = window.capture.labels.at("traj");
    trained.emplace(name, drops_.at(name));
  }
  std::vector<Capture> captures;
  std::vector<FollowOptions> options;
  for (const auto& [name, drop] : trained) {
    captures.push_back(drop);
    options.push_back(options_of(drop));
  }
  NoiseSearch search{.ahead = kAheadOf, .stride = kMotion, .rounds = 1};
  search.start = {.noise_factor = 0.5, .velocity = 0.5, .rate = 10.0, .spread = 0.2, .drift = 0.1};
  noise_ = choose_noise(samara::models::find_model("immersed_body"), options, captures, search);
}

FollowOptions FollowedDrops::options_of(const Capture& drop) const {
  FollowOptions options = follow_options(*samara::models::find_model("immersed_body"), fitted_, drop);
  options.step = kSteps;
  return options;
}

Eigen::RowVector3d FollowedDrops::next(const identification::Window& window) const {
  const Capture& drop = drops_.at(window.capture.labels.at("traj"));
  samara::identification::Follower follower(samara::models::find_model("immersed_body"),
                                            with_noise(options_of(drop), noise_));
  const Eigen::MatrixXd values = samara::identification::frames_of(follower, drop);
  const Eigen::Index last = window.first + window.capture.times.size() - 1;
  Eigen::RowVectorXd frame(values.cols());
  for (Eigen::Index k = 0; k <= last; ++k) {
    frame = values.row(k);
    follower.add(drop.times[k], {frame.data(), static_cast<std::size_t>(frame.size())});
  }
  const double time = drop.times[window.first] + window.next_time;
  const auto band = samara::identification::band_of(follower.forecast({&time, 1}));
  return band.mean.row(0);  // x, y, z: by name
}

}  // namespace samara::benchmarks::prediction
