#include "samara/identification/following/smoother.h"

#include "samara/identification/following/covariances.h"

namespace samara::identification {

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
