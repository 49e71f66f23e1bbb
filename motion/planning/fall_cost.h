#pragma once

#include "samara/motion/planning/fall_lanes.h"

/// What a fall costs, for the search and for what refines it: both ask these functions and no others. Windows need J
/// as a sum of squares: its quantities are deviations, changes, accelerations and places, and each has a weight here
/// by which it is multiplied before it is squared; sums over a fall take the same weights.
///
///     J = 1/(t a^2) int |deviation|^2 dt                                       path
///       + 1/H [0.06 sum over decisions of mean_j (dc_j/range_j)^2              changes
///              + sum over pieces of |a(c) - a(c_0)|^2 tau h/(3 C_0 epsilon)]   turbulence, where it is asked for
///       + w mean over segments of price                                        kinds, see MotionSequence::price
///       + |place - landing place|^2/a^2                                        of falls on the ground
///
/// with the semi-length a, the height fallen H, and of each piece its duration tau and its height h, all heights in a.
/// The turbulence has k = 3/2 (I U)^2 and epsilon = 0.09^(3/4) k^(3/2)/(0.14 a).
namespace samara::motion {

/// Of a fall that has come as far as this point.
FallCost cost_of(const PlannedFall& fall, const FallPoint& point);

/// H of a fall that is at this height; 1 at least.
double height_fallen(const PlannedFall& fall, double height);
/// Of a deviation [m] that lasts `duration` of the time t.
double deviation_weight(const PlannedFall& fall, double duration, double t);
/// Of a change of a coefficient; the square goes over H.
double change_weight(const PlannedFall& fall, std::size_t coefficient);
/// Of a difference of accelerations [m/s^2] that lasts `duration` of a piece that falls by `fallen` [m]; the square
/// goes over H.
double turbulence_weight(const PlannedFall& fall, double duration, double fallen);
/// Of a distance from the landing place [m].
double landing_weight(const PlannedFall& fall);

/// A decision: the coefficients set out for other values.
void add_change(const PlannedFall& fall, FallPoint& point, const std::vector<double>& from,
                const std::vector<double>& to);
/// 1/(3 C_0 epsilon) of the plan's turbulence, 0 without [s^3/m^2]: two thirds of models::turbulent_action().
double turbulence_factor(const MotionPlan& plan);
/// A piece that has ended at this point, at its acceleration_square.
void add_piece(const PlannedFall& fall, FallPoint& point, double duration, double fallen);
/// An event. @param kind of the segment that it ends; none: steady
void add_event(const PlannedFall& fall, FallPoint& point, std::optional<EventKind> kind);

}  // namespace samara::motion
