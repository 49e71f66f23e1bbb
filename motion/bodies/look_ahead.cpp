#include "samara/motion/bodies/look_ahead.h"

#include <algorithm>

namespace samara::motion {

LookAhead::LookAhead(const NextPieces& pieces, double step, double ramp, Eigen::Index choices)
    : pieces_(pieces),
      step_(step),
      ramp_(ramp),
      longest_(4.0 * std::ranges::max(pieces.database().segments, {}, &MotionSegment::duration).duration),
      model_(pieces.database().parametric_model()),
      stepper_(model_, pieces.database().coefficient_names, choices),
      finders_(static_cast<std::size_t>(choices),
               EventFinder(pieces.tree().moving_states(), pieces.database().events)),
      outcomes_(static_cast<std::size_t>(choices)),
      state_(pieces.database().state_names.size()) {
  const Eigen::VectorXd& any = pieces.database().runs.front().coefficients;
  for (Eigen::Index lane = 0; lane < choices; ++lane) {
    stepper_.load(lane, {any.data(), static_cast<std::size_t>(any.size())});
    stepper_.set_running(lane, false);
  }
}

LookAhead::Outcome LookAhead::look(Eigen::Index lane, EventKind kind, double end) {
  EventFinder& finder = finders_[static_cast<std::size_t>(lane)];
  stepper_.read(lane, state_);
  if (!stepper_.finite(lane) || stepper_.time(lane) > end) return Outcome::lost;
  if (!finder.see(stepper_.time(lane), state_)) return Outcome::open;
  return finder.event().kind == kind ? Outcome::kept : Outcome::lost;
}

std::size_t LookAhead::first_kept(const Now& now, std::span<const NextPiece> choices) {
  for (std::size_t k = 0; k < choices.size(); ++k) {
    const auto lane = static_cast<Eigen::Index>(k);
    const Eigen::VectorXd& target = pieces_.coefficients(choices[k]);
    stepper_.set_state(lane, now.t, now.state);
    stepper_.set_parameters(lane, now.coefficients);
    stepper_.ramp(lane, {target.data(), static_cast<std::size_t>(target.size())}, ramp_);
    finders_[k] = now.finder;
    outcomes_[k] = Outcome::open;
  }
  const double end = now.t + longest_;
  std::size_t first = 0;
  while (first < choices.size() && outcomes_[first] != Outcome::kept) {
    if (outcomes_[first] == Outcome::lost) {
      ++first;
      continue;
    }
    stepper_.step(step_);
    for (std::size_t k = first; k < choices.size(); ++k) {
      const auto lane = static_cast<Eigen::Index>(k);
      if (outcomes_[k] != Outcome::open) continue;
      outcomes_[k] = look(lane, choices[k].kind, end);
      if (outcomes_[k] != Outcome::open) stepper_.set_running(lane, false);
    }
  }
  for (std::size_t k = 0; k < choices.size(); ++k) stepper_.set_running(static_cast<Eigen::Index>(k), false);
  return first;
}

}  // namespace samara::motion
