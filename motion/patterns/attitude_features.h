#pragma once

#include "samara/motion/patterns/features.h"

/// Internal to motion/: the parts of features().
namespace samara::motion {

/// Share p of sorted values, interpolated. @param values not empty
double quantile(std::vector<double> values, double p);

/// Times at which a number turns back, by more than the band on either side, as indices of its extremes.
std::vector<Eigen::Index> turning_points(const Eigen::Ref<const Eigen::VectorXd>& values, double band);

/// Frames of the swings of the attitude: turning points of the rotation about its main axis, and half turns.
std::vector<Eigen::Index> attitude_swings(const SmoothedMotion& motion, const FeatureOptions& options);

/// Tilt, flips, coherence, reversals; swings of the attitude. The motion holds the settled part alone.
void add_attitude_features(const SmoothedMotion& settled, const FeatureOptions& options, Features& features);

/// How well the path repeats itself in a phase space that is free of yaw and of the plate's symmetry: the smallest
/// over lags of the rms distance of the path to itself, over its deviation times sqrt 2. Lags begin where the path
/// has first left itself (0.7), and end at half the record or 24 swings.
/// Phase space: (cos 2 theta, sin 2 theta) in the plane; (n_z^2, v_z/U, |v_h|/U) in space, U the rms speed; without
/// attitude the last two.
double recurrence(const SmoothedMotion& settled, double swing_time);

}  // namespace samara::motion
