#pragma once

#include <span>
#include <vector>

#include "samara/models/batch/stepper.h"
#include "samara/motion/bodies/next_pieces.h"
#include "samara/motion/events/event_lanes.h"

namespace samara::motion {

/// Goes on with several pieces side by side, in still air, until their next events: which of them keeps its kind.
class LookAhead {
 public:
  /// What a body that goes on is like.
  struct Now {
    const EventLanes& finders;  ///< one of which has just seen the state
    Eigen::Index lane = 0;      ///< which
    double t = 0.0;
    std::span<const double> state, coefficients;
  };

  /// @param step, ramp s
  LookAhead(const NextPieces& pieces, double step, double ramp, Eigen::Index choices);

  /// The number of the first choice whose next event is of its kind; that of all if there is none. Does not allocate.
  std::size_t first_kept(const Now& now, std::span<const NextPiece> choices);

 private:
  enum class Outcome { open, kept, lost };

  void begin(const Now& now, std::span<const NextPiece> choices);
  void step(std::span<const NextPiece> choices, double end);

  const NextPieces& pieces_;
  double step_, ramp_, longest_;
  models::ParametricModel model_;
  models::Stepper stepper_;
  EventLanes finders_;
  std::vector<Outcome> outcomes_;
};

}  // namespace samara::motion
