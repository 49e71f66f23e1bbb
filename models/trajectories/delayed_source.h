#pragma once

#include <memory>
#include <string>
#include <vector>

#include "samara/models/trajectories/averaged_source.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Trajectories by a clock that reads 0 at an unknown time of theirs: a frame at time t of the clock shows the
/// trajectory at t + delay. Frames may be means (averaged_source.h).
///
/// Families evaluate at times that are fixed beforehand. So the family is asked at Chebyshev nodes that cover all
/// that the delay may reach, and what lies between them is a polynomial: the derivative by the delay is the exact
/// one of that polynomial, and steady from piece to piece to within its error. Pieces are four frames long, or
/// shorter; each has as many nodes n as keep the error of a motion sin(w t), at most w^n/n! prod |t - t_j| <=
/// 4 (w L/4)^n/n! on a piece of length L with its Chebyshev nodes of the second kind t_j, below two millionths at
/// w = 1 rad from frame to frame: six frames a swing, coarser than a motion is seen that can be followed at all. At
/// twelve frames a swing the error is a thousandth of that. Some 2.3 times are asked for each frame that the
/// run and the range of the delay cover.
namespace samara::models {

/// @param range of the delay, s; without a width the delay is held, and trajectories are asked where it says
/// @param mean as averaged_source(); where the last time is a state, it has no delay
/// @param times s, by the clock, since the start of the trajectory
/// @param outputs, wanted as TrajectoryFamily::at()
/// @returns a source whose point is that of the family and, last, the delay. It is done only where the trajectory
///   goes on as far as the range leads.
/// @throws ArgumentError for a range that is not finite or reversed; as TrajectoryFamily::at() where the range
///   leads out of the times of the family.
std::unique_ptr<TrajectorySource> delayed_source(const TrajectoryFamily& family, const Interval& range,
                                                 const FrameMean& mean, const std::vector<double>& times,
                                                 const std::vector<std::string>& outputs,
                                                 const std::vector<int>& wanted);

}  // namespace samara::models
