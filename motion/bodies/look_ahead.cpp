#include "samara/motion/bodies/look_ahead.h"

#include <algorithm>

#include "samara/base/bits.h"

namespace samara::motion {

LookAhead::LookAhead(const NextPieces& pieces, double step, double ramp, Eigen::Index choices)
    : pieces_(pieces),
      step_(step),
      ramp_(ramp),
      longest_(4.0 * std::ranges::max(pieces.database().segments, {}, &MotionSegment::duration).duration),
      model_(pieces.database().parametric_model()),
      stepper_(model_, pieces.database().coefficient_names, choices),
      finders_(pieces.tree().moving_states(), pieces.database().events, choices,
               static_cast<std::size_t>(stepper_.width())),
      outcomes_(static_cast<std::size_t>(choices)) {
  const Eigen::VectorXd& any = pieces.database().runs.front().coefficients;
  for (Eigen::Index lane = 0; lane < choices; ++lane) {
    stepper_.load(lane, {any.data(), static_cast<std::size_t>(any.size())});
    stepper_.set_running(lane, false);
  }
}

void LookAhead::begin(const Now& now, std::span<const NextPiece> choices) {
  for (std::size_t k = 0; k < choices.size(); ++k) {
    const auto lane = static_cast<Eigen::Index>(k);
    const Eigen::VectorXd& target = pieces_.coefficients(choices[k]);
    stepper_.set_state(lane, now.t, now.state);
    stepper_.set_parameters(lane, now.coefficients);
    stepper_.ramp(lane, {target.data(), static_cast<std::size_t>(target.size())}, ramp_);
    finders_.copy(lane, now.finders, now.lane);
    outcomes_[k] = Outcome::open;
  }
}

void LookAhead::step(std::span<const NextPiece> choices, double end) {
  for (Eigen::Index p = 0; p < stepper_.packs(); ++p) {
    const auto [pack, finite, events] = finders_.step(stepper_, p, step_);
    for_bits(pack.running, [&](int slot) {
      const Eigen::Index lane = p * stepper_.width() + slot;
      const auto k = static_cast<std::size_t>(lane);
      if (!has_bit(finite, slot) || pack.times[slot] > end) {
        outcomes_[k] = Outcome::lost;
      } else if (has_bit(events, slot)) {
        outcomes_[k] = finders_.event(lane).kind == choices[k].kind ? Outcome::kept : Outcome::lost;
      } else {
        return;
      }
      stepper_.set_running(lane, false);
    });
  }
}

std::size_t LookAhead::first_kept(const Now& now, std::span<const NextPiece> choices) {
  begin(now, choices);
  const double end = now.t + longest_;
  std::size_t first = 0;
  while (first < choices.size() && outcomes_[first] != Outcome::kept) {
    if (outcomes_[first] == Outcome::lost) {
      ++first;
    } else {
      step(choices, end);
    }
  }
  for (std::size_t k = 0; k < choices.size(); ++k) stepper_.set_running(static_cast<Eigen::Index>(k), false);
  return first;
}

}  // namespace samara::motion
