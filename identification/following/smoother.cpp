#include "samara/identification/following/smoother.h"

#include <Eigen/Eigenvalues>

namespace samara::identification {

namespace {

/// Of the largest eigenvalue, once errors are scaled: what is less is a combination that does not move.
constexpr double kHeld = 1e-12;

/// The inverse of a covariance where it has any, zero elsewhere.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& covariance) {
  const Eigen::ArrayXd sizes = covariance.diagonal().array().max(0.0).sqrt();
  const Eigen::VectorXd scales = (sizes > 0.0).select(sizes.max(1e-300).inverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scales.asDiagonal() * covariance * scales.asDiagonal());
  const Eigen::ArrayXd values = solver.eigenvalues().array();
  const double least = kHeld * std::max(values.maxCoeff(), 0.0);
  const Eigen::VectorXd inverse = (values > least).select(values.max(1e-300).inverse(), 0.0);
  const Eigen::MatrixXd vectors = scales.asDiagonal() * solver.eigenvectors();
  return vectors * inverse.asDiagonal() * vectors.transpose();
}

}  // namespace

std::vector<FollowedState> smooth(const FollowedModel& model, const std::vector<FrameRecord>& records) {
  std::vector<FollowedState> states(records.size());
  if (records.empty()) return states;
  Eigen::VectorXd point = records.back().point, error(model.errors());
  Eigen::MatrixXd covariance = records.back().covariance, scratch(model.errors(), model.errors());
  for (std::size_t k = records.size(); k-- > 0;) {
    if (k + 1 < records.size()) {
      const FrameRecord& here = records[k];
      const FrameRecord& next = records[k + 1];
      const Eigen::MatrixXd gain =
          here.covariance * next.transition.transpose() * inverse_of(next.expected_covariance);
      model.minus(point, next.expected, error);
      const Eigen::VectorXd moved = gain * error;
      model.plus(here.point, moved, point);
      covariance = here.covariance + gain * (covariance - next.expected_covariance) * gain.transpose();
      covariance = (0.5 * (covariance + covariance.transpose())).eval();
      model.carry(moved, covariance, scratch);
    }
    states[k] = {.time = records[k].time,
                 .weight = 1.0,
                 .states = point.head(model.states()),
                 .coefficients = point.tail(model.coefficients()),
                 .covariance = covariance};
  }
  return states;
}

std::vector<FrameRecord> start_records(const FollowedModel& model, const Hypothesis& start,
                                       std::span<const SeenFrame> frames, double lead) {
  HypothesisFilter flow(model);
  std::vector<FrameRecord> records;
  Hypothesis moving = start;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    FrameRecord record;
    record.time = frames[k].time - lead;
    record.transition.setIdentity(model.errors(), model.errors());
    if (k > 0) {
      const double before = frames[k - 1].time - lead;
      if (!flow.predict(moving, before, record.time - before, &record.transition)) break;
      moving.covariance =
          (record.transition * records.back().covariance * record.transition.transpose()).eval();
    }
    record.expected = record.point = moving.point;
    record.expected_covariance = record.covariance = moving.covariance;
    records.push_back(std::move(record));
  }
  return records;
}

void end_start_records(Hypothesis& hypothesis) {
  if (hypothesis.records.empty()) return;
  FrameRecord& last = hypothesis.records.back();
  last.expected_covariance = last.covariance = hypothesis.covariance;
  last.expected = last.point = hypothesis.point;
}

}  // namespace samara::identification
