#pragma once

#include "samara/motion/ghost/ghost_force.h"
#include "samara/motion/planning/planner.h"

namespace samara::motion {

/// A motion at so many instants as a picture shows, the last one among them.
struct MotionView {
  Eigen::VectorXd times;
  Eigen::MatrixX3d places;
  Eigen::MatrixXd coefficients;  ///< times x coefficients of the box
  Eigen::VectorXd ghost_times, ghost_force, ghost_torque;
};

MotionView view_of(const MotionPlan& plan, const MotionResult& motion, const GhostForce& ghost);

}  // namespace samara::motion
