#include "samara/identification/fit/delay_check.h"

#include <algorithm>
#include <span>

#include <fmt/format.h>

#include "samara/identification/problem/measurement.h"
#include "samara/models/trajectories/averaged_source.h"

namespace samara::identification {

namespace {

/// Loss scales by which the polynomials may be off without a warning.
constexpr double kTolerableDelayError = 0.01;

/// Of one segment, over the loss scales.
double segment_error(const models::TrajectoryFamily& family, const FitProblem& problem,
                     SegmentResidual& residual, const Eigen::VectorXd& shared, const Eigen::VectorXd& own,
                     const double* next) {
  const Segment& segment = residual.segment();
  if (!residual.evaluate(shared.data(), own.data(), next, false)) return 0.0;
  Eigen::VectorXd q(std::ssize(problem.slots));
  family_point(problem, problem.motion_of(segment), shared.data(), own.data(), q);
  if (problem.clock) q[static_cast<Eigen::Index>(*problem.clock)] = segment.start;
  std::vector<double> times(segment.times.begin(), segment.times.end() - (segment.joined ? 1 : 0));
  for (double& time : times) time = std::max(0.0, time + delay_at(problem, q));
  const models::FrameMean mean{.frames = problem.averaged_frames, .interval = segment.interval};
  const auto direct = averaged_source(family, mean, times, problem.requested, {});
  Eigen::MatrixXd values(std::ssize(times), std::ssize(problem.requested));
  if (!direct->evaluate(std::span<const double>(q.data(), problem.model_slots), values, nullptr)) return 0.0;
  double largest = 0.0;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const auto column = static_cast<Eigen::Index>(o);
    const double error = (residual.values().col(column) - values.col(column)).cwiseAbs().maxCoeff();
    largest = std::max(largest, std::abs(gain_at(problem.outputs[o], q)) * error / problem.outputs[o].scale);
  }
  for (Eigen::Index frame = 0; problem.attitude_scale && frame < values.rows(); ++frame) {
    const Eigen::Vector4d there = values.row(frame).segment<4>(problem.attitude_column()).transpose();
    const double turn = turn_between(there.data(), residual.attitude(frame).eval().data()).vector.norm();
    largest = std::max(largest, turn / *problem.attitude_scale);
  }
  return largest;
}

}  // namespace

double delay_error(const models::TrajectoryFamily& family, const FitProblem& problem,
                   std::vector<SegmentResidual>& residuals, const FitPoint& point) {
  if (!problem.delay) return 0.0;
  double largest = 0.0;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    const double* next = residuals[k].segment().joined ? point.own[k + 1].data() : nullptr;
    largest =
        std::max(largest, segment_error(family, problem, residuals[k], point.shared, point.own[k], next));
  }
  return largest;
}

void add_delay_warning(const models::TrajectoryFamily& family, const FitProblem& problem,
                       std::vector<SegmentResidual>& residuals, const FitPoint& point, FitResult& result) {
  const double error = delay_error(family, problem, residuals, point);
  if (error <= kTolerableDelayError) return;
  result.warnings.add(
      WarningKind::captures,
      fmt::format(
          "frames are too far apart to be shifted by a delay: between them the motion is off by {:.2g} loss "
          "scales; captures with more frames in each swing are needed",
          error));
}

}  // namespace samara::identification
