#include "samara/identification/segment_residual.h"

namespace samara::identification {

SegmentResidual::SegmentResidual(const TrajectoryFamily& family, const FitProblem& problem,
                                 const Segment& segment)
    : problem_(&problem), segment_(&segment), source_(family.at(segment.times, problem.output_names())) {
  const auto frames = static_cast<Eigen::Index>(segment.times.size());
  const auto outputs = static_cast<Eigen::Index>(problem.outputs.size());
  const auto coordinates = static_cast<Eigen::Index>(problem.slots.size());
  const auto observations = static_cast<Eigen::Index>(segment.observations.size());
  q_.setZero(coordinates);
  values_.setZero(frames, outputs);
  derivatives_.setZero(frames, outputs * coordinates);
  residual_.setZero(observations);
  by_shared_.setZero(observations, problem.shared_count());
  by_own_.setZero(observations, problem.own_count());
}

void SegmentResidual::load(const double* shared, const double* own) {
  for (std::size_t k = 0; k < problem_->slots.size(); ++k) {
    const CoordinateSlot& slot = problem_->slots[k];
    double& q = q_[static_cast<Eigen::Index>(k)];
    switch (slot.role) {
      case CoordinateRole::shared:
        q = shared[slot.index];
        break;
      case CoordinateRole::own:
        q = own[slot.index];
        break;
      case CoordinateRole::fixed:
        q = slot.value;
        break;
    }
  }
}

bool SegmentResidual::evaluate(const double* shared, const double* own, bool with_derivatives) {
  load(shared, own);
  ++evaluations_;
  const std::span<const double> q(q_.data(), static_cast<std::size_t>(q_.size()));
  if (!source_->evaluate(q, values_, with_derivatives ? &derivatives_ : nullptr)) return false;
  const std::size_t own_coordinates = problem_->own.size();
  for (Eigen::Index row = 0; row < residual_.size(); ++row) {
    const Observation& observation = segment_->observations[static_cast<std::size_t>(row)];
    const ComparedOutput& output = problem_->outputs[static_cast<std::size_t>(observation.output)];
    const double offset =
        output.offset ? own[own_coordinates + static_cast<std::size_t>(*output.offset)] : 0.0;
    residual_[row] =
        (values_(observation.frame, observation.output) + offset - observation.value) / output.scale;
  }
  if (with_derivatives) fill_derivatives();
  return residual_.allFinite();
}

void SegmentResidual::fill_derivatives() {
  const auto outputs = static_cast<Eigen::Index>(problem_->outputs.size());
  for (Eigen::Index row = 0; row < residual_.size(); ++row) {
    const Observation& observation = segment_->observations[static_cast<std::size_t>(row)];
    const ComparedOutput& output = problem_->outputs[static_cast<std::size_t>(observation.output)];
    for (std::size_t k = 0; k < problem_->slots.size(); ++k) {
      const CoordinateSlot& slot = problem_->slots[k];
      if (slot.role == CoordinateRole::fixed) continue;
      const Eigen::Index column = observation.output + outputs * static_cast<Eigen::Index>(k);
      auto& target = slot.role == CoordinateRole::shared ? by_shared_ : by_own_;
      target(row, slot.index) = derivatives_(observation.frame, column) / output.scale;
    }
    if (output.offset) {
      by_own_(row, static_cast<Eigen::Index>(problem_->own.size()) + *output.offset) = 1.0 / output.scale;
    }
  }
}

void SegmentResidual::centre_offsets(Eigen::VectorXd& own) const {
  for (std::size_t o = 0; o < problem_->outputs.size(); ++o) {
    const ComparedOutput& output = problem_->outputs[o];
    if (!output.offset) continue;
    double sum = 0.0;
    int count = 0;
    for (Eigen::Index row = 0; row < residual_.size(); ++row) {
      if (segment_->observations[static_cast<std::size_t>(row)].output != static_cast<int>(o)) continue;
      sum += residual_[row] * output.scale;
      ++count;
    }
    if (count > 0) own[static_cast<Eigen::Index>(problem_->own.size()) + *output.offset] -= sum / count;
  }
}

}  // namespace samara::identification
