#pragma once

#include <string>

#include "samara/identification/following/followed_motion.h"
#include "samara/identification/following/noise_search.h"
#include "samara/identification/problem/warnings.h"

/// A followed motion as text, as a table and as JSON.
namespace samara::identification {

/// What `samara follow` answers.
struct FollowReport {
  std::string model = {}, source = {};  ///< by name; and as the caller called it
  FollowedMotion motion = {};
  NoiseChoice noise = {};
  bool noise_was_chosen = false;  ///< on training captures, as far as it was not given; else given
  GivenNoise given = {};
  /// Whether states of the model have such units: else noise of velocities, or of rates, is none, and not told of.
  bool has_velocities = true, has_rates = true;
  Warnings warnings = {};
};

/// Whether the last frame that saw anything has a state: a motion without a start has none at all, and one that was
/// lost and not found again ends earlier.
bool is_followed_to_end(const FollowReport& report);

/// Warns of a motion that was not followed to its end, and of many frames far from what was expected.
void add_follow_warnings(FollowReport& report);

/// How it went, the last state and what is forecast from there.
std::string follow_text(const FollowReport& report);

/// A row a frame: time, status, hypotheses, innovation squared; values and errors of states and coefficients, the same
/// smoothed, and forecasts. Cells of what is not known are empty.
std::string follow_csv(const FollowReport& report);

/// All of it; schema samara-follow/1.
std::string follow_json(const FollowReport& report);

}  // namespace samara::identification
