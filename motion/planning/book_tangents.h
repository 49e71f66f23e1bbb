#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/composition/flow_map.h"
#include "samara/motion/planning/motion_plan.h"

namespace samara::motion {

/// How the end of a stretch of a fall changes with its start and with coefficients that rest, by the codebook of a
/// plan: its flow map (codebooks/composition/flow_map.h), images by symmetry included. One object per thread.
class BookTangents {
 public:
  /// @throws ArgumentError for a codebook of another model, of other equations or of other constants than the plan's;
  /// one that is no flow map, is shorter than a step of the plan, or has no coordinate for a coefficient of its box,
  /// or none of the values that it may take.
  explicit BookTangents(const MotionPlan& plan);

  /// Of the plan, that a window of the codebook is long, 1 or more.
  long steps() const { return steps_; }

  /// For the transitions that follow. @param values of the plan's box, in its order
  /// @returns whether the codebook's box holds them
  bool set_coefficients(std::span<const double> values);

  /// @param duration s, at most that of a window
  /// @param by_start, by_coefficients d(state at the end)/d(state at the start), states x states, and d(..)/d(values
  /// of the plan's box), states x coefficients; as they were where nothing is known
  /// @returns whether the codebook's box holds the start, or an image of it
  bool transition(std::span<const double> start, double duration, Eigen::MatrixXd& by_start,
                  Eigen::MatrixXd& by_coefficients);

 private:
  std::shared_ptr<const codebooks::Codebook> book_;
  codebooks::FlowMap map_;
  std::vector<double> parameters_;    ///< of the flow map
  std::vector<Eigen::Index> places_;  ///< of the plan's coefficients among them
  long steps_ = 0;
};

}  // namespace samara::motion
