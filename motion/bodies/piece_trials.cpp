#include "samara/motion/bodies/piece_trials.h"

#include <algorithm>

#include "samara/base/bits.h"
#include "samara/base/parallel.h"
#include "samara/models/batch/stepper.h"
#include "samara/motion/events/event_lanes.h"

namespace samara::motion {

namespace {

constexpr Eigen::Index kTrialLanes = 32;

/// Trials side by side; the next one takes the lane of one that has ended.
class TrialLanes {
 public:
  TrialLanes(const MotionDatabase& database, const models::ParametricModel& model, double ramp)
      : database_(database),
        moving_(database.moving_states()),
        ramp_(ramp),
        longest_(4.0 * std::ranges::max(database.segments, {}, &MotionSegment::duration).duration),
        stepper_(model, database.coefficient_names, kTrialLanes),
        finders_(moving_, database.events, kTrialLanes, static_cast<std::size_t>(stepper_.width())),
        riders_(static_cast<std::size_t>(kTrialLanes)),
        state_(database.state_names.size()) {
    const Eigen::VectorXd& any = database.runs.front().coefficients;
    for (Eigen::Index lane = 0; lane < kTrialLanes; ++lane) {
      stepper_.load(lane, {any.data(), static_cast<std::size_t>(any.size())});
      stepper_.set_running(lane, false);
    }
  }

  void run(std::span<const PieceTrial> trials, std::span<char> kept) {
    std::size_t next = 0, riding = 0;
    for (Eigen::Index lane = 0; lane < kTrialLanes && next < trials.size(); ++lane, ++riding)
      board(lane, next, trials[next]), ++next;
    while (riding > 0) {
      for (Eigen::Index p = 0; p < stepper_.packs(); ++p) {
        const auto [pack, finite, events] = finders_.step(stepper_, p, database_.step);
        for_bits(pack.running, [&](int slot) {
          const Eigen::Index lane = p * stepper_.width() + slot;
          Rider& rider = riders_[static_cast<std::size_t>(lane)];
          const bool is_lost = !has_bit(finite, slot) || pack.times[slot] > longest_;
          if (!is_lost && !has_bit(events, slot)) {
            if (!rider.is_on_ramp) stepper_.read(lane, state_);
            return steer(rider, lane);
          }
          if (!is_lost)
            kept[rider.number] = finders_.event(lane).kind == segment(rider.trial.with).kind ? 1 : 0;
          if (next < trials.size()) {
            board(lane, next, trials[next]);
            ++next;
          } else {
            stepper_.set_running(lane, false);
            --riding;
          }
        });
      }
    }
  }

 private:
  struct Rider {
    std::size_t number = 0;
    PieceTrial trial = {};
    double certain_square = 0.0;  // |v|^2 at which the event that it began with is certain
    bool is_on_ramp = false;
  };

  const MotionSegment& segment(Eigen::Index n) const {
    return database_.segments[static_cast<std::size_t>(n)];
  }
  std::span<const double> coefficients(Eigen::Index n) const {
    const Eigen::VectorXd& own = database_.runs[static_cast<std::size_t>(segment(n).run)].coefficients;
    return {own.data(), static_cast<std::size_t>(own.size())};
  }

  void board(Eigen::Index lane, std::size_t number, const PieceTrial& trial) {
    Rider& rider = riders_[static_cast<std::size_t>(lane)];
    Eigen::Map<Eigen::VectorXd>(state_.data(), std::ssize(state_)) = database_.ends.row(trial.after);
    stepper_.set_state(lane, 0.0, state_);
    stepper_.set_parameters(lane, coefficients(trial.after));
    rider.number = number;
    rider.trial = trial;
    finders_.begin(lane, 0.0, state_);
    // A steady segment ends when its time is over, and is certain then.
    rider.certain_square =
        segment(trial.after).is_steady
            ? 0.0
            : moving_.speed_square(state_) + database_.events.prominence * database_.events.mean_square_speed;
    rider.is_on_ramp = false;
    steer(rider, lane);
  }

  void steer(Rider& rider, Eigen::Index lane) {
    if (rider.is_on_ramp || moving_.speed_square(state_) < rider.certain_square) return;
    rider.is_on_ramp = true;
    stepper_.ramp(lane, coefficients(rider.trial.with), ramp_);
  }

  const MotionDatabase& database_;
  MovingStates moving_;
  double ramp_, longest_;
  models::Stepper stepper_;
  EventLanes finders_;
  std::vector<Rider> riders_;
  std::vector<double> state_;
};

}  // namespace

std::vector<char> try_pieces(const MotionDatabase& database, std::span<const PieceTrial> trials,
                             double ramp) {
  std::vector<char> kept(trials.size(), 0);
  const models::ParametricModel model = database.parametric_model();
  constexpr std::size_t kTask = 1024;
  parallel_for((trials.size() + kTask - 1) / kTask, [&](std::size_t task) {
    const std::size_t first = task * kTask, count = std::min(kTask, trials.size() - first);
    TrialLanes(database, model, ramp)
        .run(trials.subspan(first, count), std::span(kept).subspan(first, count));
  });
  return kept;
}

}  // namespace samara::motion
