#include "samara/identification/problem/segment_residual.h"

#include <cmath>

#include <fmt/format.h>

#include "samara/identification/problem/measurement.h"
#include "samara/models/trajectories/averaged_source.h"
#include "samara/models/trajectories/delayed_source.h"

namespace samara::identification {

namespace {

/// Coordinates of the family by which the fit needs derivatives.
std::vector<int> wanted_coordinates(const FitProblem& problem) {
  std::vector<int> wanted;
  for (std::size_t k = 0; k < problem.model_slots; ++k) {
    const CoordinateRole role = problem.slots[k].role;
    if (role == CoordinateRole::shared || role == CoordinateRole::own) wanted.push_back(static_cast<int>(k));
  }
  return wanted;
}

models::FrameMean mean_of(const FitProblem& problem, const Segment& segment) {
  return {.frames = problem.averaged_frames, .interval = segment.interval, .last_is_state = segment.joined};
}

/// The requested outputs at the frames, and without a delay where a joined segment ends.
std::unique_ptr<models::TrajectorySource> source_of(const models::TrajectoryFamily& family,
                                                    const FitProblem& problem, const Segment& segment) {
  const models::FrameMean mean = mean_of(problem, segment);
  const std::vector<int> wanted = wanted_coordinates(problem);
  if (!problem.delay) return averaged_source(family, mean, segment.times, problem.requested, wanted);
  return delayed_source(family, delay_range(problem, problem.motion_of(segment)), mean, segment.times,
                        problem.requested, wanted);
}

/// The difference on a circle of length `period`, or on the line.
double wrapped(double difference, double period) {
  return period > 0.0 ? std::remainder(difference, period) : difference;
}

}  // namespace

SegmentResidual::SegmentResidual(const models::TrajectoryFamily& family, const FitProblem& problem,
                                 const Segment& segment)
    : problem_(&problem),
      segment_(&segment),
      source_(source_of(family, problem, segment)),
      source_slots_(problem.model_slots + (problem.delay ? 1 : 0)) {
  const auto times = static_cast<Eigen::Index>(segment.times.size());
  const auto outputs = static_cast<Eigen::Index>(problem.requested.size());
  const auto coordinates = static_cast<Eigen::Index>(source_slots_);
  frame_count_ = times - (segment.joined ? 1 : 0);
  data_size_ = static_cast<int>(segment.observations.size() + 3 * segment.attitudes.size());
  const bool is_first = &segment == &problem.segments[problem.motion_of(segment).first_segment];
  prior_size_ = is_first ? static_cast<int>(problem.own_priors.size()) : 0;
  const int joins = segment.joined ? problem.join_rows() : 0;
  q_.setZero(std::ssize(problem.slots));
  values_.setZero(times, outputs);
  derivatives_.setZero(times, outputs * coordinates);
  residual_.setZero(data_size_ + prior_size_ + joins);
  join_weights_.setOnes(joins);
  by_shared_.setZero(residual_.size(), problem.shared_count());
  by_own_.setZero(residual_.size(), problem.own_count());
  by_next_.setZero(residual_.size(), segment.joined ? problem.own_count() : 0);
  axis_of_.assign(problem.outputs.size(), -1);
  turns_.assign(problem.outputs.size(), 0);
  if (!problem.camera) return;
  for (std::size_t axis = 0; axis < problem.camera->columns.size(); ++axis) {
    const auto column = static_cast<std::size_t>(problem.camera->columns[axis]);
    if (column < axis_of_.size()) axis_of_[column] = static_cast<int>(axis);
  }
  for (const int angle : problem.camera->angles) turns_[static_cast<std::size_t>(angle)] = 1;
}

bool SegmentResidual::evaluate(const double* shared, const double* own, const double* next,
                               bool with_derivatives) {
  family_point(*problem_, problem_->motion_of(*segment_), shared, own, q_);
  if (problem_->clock) q_[static_cast<Eigen::Index>(*problem_->clock)] = segment_->start;
  ++evaluations_;
  is_finite_ = true;
  const std::span<const double> q(q_.data(), source_slots_);
  has_trajectory_ =
      static_cast<bool>(source_->evaluate(q, values_, with_derivatives ? &derivatives_ : nullptr));
  if (!has_trajectory_) return false;
  if (problem_->camera) view_ = CameraView(*problem_->camera, own);
  compare(own);
  if (with_derivatives) fill_derivatives();
  compare_attitudes(with_derivatives);
  add_priors(own, with_derivatives);
  if (segment_->joined) join(own, next, with_derivatives);
  is_finite_ = has_residuals() && (!with_derivatives || are_slopes_finite(0, residual_.size()));
  return is_finite_;
}

bool SegmentResidual::has_residuals() const {
  return has_trajectory_ && residual_.allFinite();
}

bool SegmentResidual::are_slopes_finite(Eigen::Index row, Eigen::Index rows) const {
  return by_shared_.middleRows(row, rows).allFinite() && by_own_.middleRows(row, rows).allFinite() &&
         by_next_.middleRows(row, rows).allFinite();
}

std::string SegmentResidual::name_of_row(Eigen::Index row) const {
  const std::string& capture = problem_->motion_of(*segment_).id;
  const auto shown = [&](const std::string& what, int frame) {
    const double time = segment_->start + segment_->times[static_cast<std::size_t>(frame)];
    return fmt::format("{} at {:.6g} s of capture \"{}\"", what, time, capture);
  };
  auto k = static_cast<std::size_t>(row);
  if (k < segment_->observations.size()) {
    const Observation& seen = segment_->observations[k];
    const ComparedOutput& output = problem_->outputs[static_cast<std::size_t>(seen.output)];
    return shown(fmt::format("the output \"{}\"", output.name), seen.frame);
  }
  k = (k - segment_->observations.size()) / 3;
  if (k < segment_->attitudes.size()) return shown("the turn to the attitude", segment_->attitudes[k].frame);
  if (row < data_size_ + prior_size_) return fmt::format("a prior of capture \"{}\"", capture);
  return shown("the end of a segment", static_cast<int>(frame_count_));
}

std::string SegmentResidual::failure() const {
  if (!has_trajectory_) return "there is no trajectory";
  if (is_finite_) return "";
  for (Eigen::Index row = 0; row < residual_.size(); ++row) {
    if (!std::isfinite(residual_[row])) return name_of_row(row) + " is not a finite number";
  }
  for (Eigen::Index row = 0; row < residual_.size(); ++row) {
    if (!are_slopes_finite(row, 1)) return name_of_row(row) + " has a derivative that is not a finite number";
  }
  return "";
}

Eigen::Vector3d SegmentResidual::place(Eigen::Index frame) const {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  const std::vector<int>& columns = problem_->camera->columns;
  for (std::size_t axis = 0; axis < columns.size(); ++axis)
    place[static_cast<Eigen::Index>(axis)] = values_(frame, columns[axis]);
  return place;
}

double SegmentResidual::shown_value(Eigen::Index frame, int output) const {
  const auto at = static_cast<std::size_t>(output);
  if (axis_of_[at] >= 0) return view_.map.row(axis_of_[at]).dot(place(frame));
  return values_(frame, output) + (turns_[at] ? view_.angle : 0.0);
}

double SegmentResidual::seen_value(Eigen::Index frame, int output, const double* own) const {
  const auto at = static_cast<std::size_t>(output);
  const double value = gain_at(problem_->outputs[at], q_) * shown_value(frame, output);
  const std::optional<int>& offset = problem_->outputs[at].offset;
  return offset ? value + own[problem_->own.size() + static_cast<std::size_t>(*offset)] : value;
}

Eigen::MatrixXd SegmentResidual::seen(const double* own) const {
  Eigen::MatrixXd all(frame_count_, static_cast<Eigen::Index>(problem_->outputs.size()));
  for (Eigen::Index frame = 0; frame < all.rows(); ++frame) {
    for (Eigen::Index o = 0; o < all.cols(); ++o) all(frame, o) = seen_value(frame, static_cast<int>(o), own);
  }
  return all;
}

void SegmentResidual::compare(const double* own) {
  for (std::size_t k = 0; k < segment_->observations.size(); ++k) {
    const Observation& observation = segment_->observations[k];
    const ComparedOutput& output = problem_->outputs[static_cast<std::size_t>(observation.output)];
    const double model = seen_value(observation.frame, observation.output, own);
    residual_[static_cast<Eigen::Index>(k)] =
        wrapped(model - observation.value, output.period) / output.scale;
  }
}

void SegmentResidual::fill_slot(Eigen::Index row, std::size_t slot, double derivative) {
  const CoordinateSlot& of = problem_->slots[slot];
  if (of.role == CoordinateRole::shared) by_shared_(row, of.index) = derivative;
  if (of.role == CoordinateRole::own) by_own_(row, of.index) = derivative;
}

void SegmentResidual::fill_row(Eigen::Index row, Eigen::Index frame, Eigen::Index column, double factor) {
  const auto outputs = static_cast<Eigen::Index>(problem_->requested.size());
  for (std::size_t k = 0; k < source_slots_; ++k) {
    fill_slot(row, k, factor * derivatives_(frame, column + outputs * static_cast<Eigen::Index>(k)));
  }
}

void SegmentResidual::fill_seen(Eigen::Index row, const Observation& observation, double factor) {
  const auto at = static_cast<std::size_t>(observation.output);
  if (axis_of_[at] >= 0) {
    fill_axis(row, observation.frame, axis_of_[at], place(observation.frame), factor);
    return;
  }
  fill_row(row, observation.frame, observation.output, factor);
  if (turns_[at]) by_own_(row, *problem_->camera->turn) = factor;
}

void SegmentResidual::fill_axis(Eigen::Index row, Eigen::Index frame, int axis, const Eigen::Vector3d& way,
                                double factor) {
  const Camera& camera = *problem_->camera;
  const auto outputs = static_cast<Eigen::Index>(problem_->requested.size());
  for (std::size_t k = 0; k < source_slots_; ++k) {
    const CoordinateSlot& slot = problem_->slots[k];
    if (slot.role != CoordinateRole::shared && slot.role != CoordinateRole::own) continue;
    double sum = 0.0;
    for (std::size_t other = 0; other < camera.columns.size(); ++other) {
      if (frame == frame_count_ && camera.is_own[other]) continue;
      const Eigen::Index column = camera.columns[other] + outputs * static_cast<Eigen::Index>(k);
      sum += view_.map(axis, static_cast<Eigen::Index>(other)) * derivatives_(frame, column);
    }
    (slot.role == CoordinateRole::shared ? by_shared_ : by_own_)(row, slot.index) = factor * sum;
  }
  if (camera.scale) by_own_(row, *camera.scale) = factor * view_.by_scale.row(axis).dot(way);
  for (int k = 0; k < camera.turns(); ++k) {
    by_own_(row, *camera.turn + k) = factor * view_.by_turn[static_cast<std::size_t>(k)].row(axis).dot(way);
  }
}

void SegmentResidual::join_offset(const JoinRule& rule, int axis, Eigen::Index row, const double* own,
                                  const double* next, bool with_derivatives) {
  const double weight = join_weights_[row - data_size_ - prior_size_];
  const Camera& camera = *problem_->camera;
  Eigen::Vector3d way = place(frame_count_);
  for (std::size_t k = 0; k < camera.columns.size(); ++k) {
    double& part = way[static_cast<Eigen::Index>(k)];
    const int slot = camera.start_slots[k];
    const double start = slot == JoinRule::kNone ? camera.starts[k] : q_[slot];
    part = camera.is_own[k] ? 0.0 : part - start;
  }
  const ComparedOutput& output = problem_->outputs[static_cast<std::size_t>(rule.column)];
  const double shown = view_.map.row(axis).dot(way);
  const double gain = gain_at(output, q_);
  residual_[row] = weight * (gain * shown + own[rule.own] - next[rule.own]);
  if (!with_derivatives) return;
  fill_axis(row, frame_count_, axis, way, weight * gain);
  if (output.gain) fill_slot(row, *output.gain, weight * shown);
  for (std::size_t k = 0; k < camera.columns.size(); ++k) {
    const int start = camera.start_slots[k];
    if (start == JoinRule::kNone) continue;
    const CoordinateSlot& slot = problem_->slots[static_cast<std::size_t>(start)];
    if (slot.role == CoordinateRole::shared)
      by_shared_(row, slot.index) -= weight * gain * view_.map(axis, static_cast<Eigen::Index>(k));
  }
  by_own_(row, rule.own) = weight;
  by_next_(row, rule.own) = -weight;
}

void SegmentResidual::fill_derivatives() {
  for (std::size_t k = 0; k < segment_->observations.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const Observation& observation = segment_->observations[k];
    const ComparedOutput& output = problem_->outputs[static_cast<std::size_t>(observation.output)];
    const double factor = gain_at(output, q_) / output.scale;
    if (problem_->camera) {
      fill_seen(row, observation, factor);
    } else {
      fill_row(row, observation.frame, observation.output, factor);
    }
    if (output.gain)
      fill_slot(row, *output.gain, shown_value(observation.frame, observation.output) / output.scale);
    if (output.offset) {
      by_own_(row, static_cast<Eigen::Index>(problem_->own.size()) + *output.offset) = 1.0 / output.scale;
    }
  }
}

void SegmentResidual::compare_attitudes(bool with_derivatives) {
  const auto outputs = static_cast<Eigen::Index>(problem_->requested.size());
  const Eigen::Index column = problem_->attitude_column();
  auto row = static_cast<Eigen::Index>(segment_->observations.size());
  const bool turned = problem_->camera && problem_->camera->turns() == 3;
  const Eigen::Matrix4d seen_by = turned ? view_.on_attitude() : Eigen::Matrix4d::Identity();
  for (const AttitudeObservation& observation : segment_->attitudes) {
    const Eigen::Vector4d unturned = attitude(observation.frame);
    const Eigen::Vector4d model = seen_by * unturned;
    const Turn turn = turn_between(observation.q_WB.data(), model.data());
    const double scale = *problem_->attitude_scale;
    residual_.segment<3>(row) = turn.vector / scale;
    for (std::size_t k = 0; with_derivatives && k < source_slots_; ++k) {
      const CoordinateSlot& slot = problem_->slots[k];
      if (slot.role != CoordinateRole::shared && slot.role != CoordinateRole::own) continue;
      auto& target = slot.role == CoordinateRole::shared ? by_shared_ : by_own_;
      const Eigen::Vector4d derivative = derivatives_.row(observation.frame)
                                             .segment<4>(column + outputs * static_cast<Eigen::Index>(k))
                                             .transpose();
      target.block<3, 1>(row, slot.index) = turn.by_to * (seen_by * derivative) / scale;
    }
    if (with_derivatives && turned) {
      by_own_.block<3, 3>(row, *problem_->camera->turn) =
          turn.by_to * (CameraView::on_turn(unturned) * view_.turn_by_turn) / scale;
    }
    row += 3;
  }
}

void SegmentResidual::add_priors(const double* own, bool with_derivatives) {
  for (int k = 0; k < prior_size_; ++k) {
    const PriorTerm& prior = problem_->own_priors[static_cast<std::size_t>(k)];
    residual_[data_size_ + k] = prior.residual(own);
    if (!with_derivatives) continue;
    for (const auto& [unknown, weight] : prior.weights()) {
      by_own_(data_size_ + k, unknown) = weight * prior.slope(own);
    }
  }
}

void SegmentResidual::join(const double* own, const double* next, bool with_derivatives) {
  const Eigen::Index end = frame_count_;
  const Eigen::Index first = data_size_ + prior_size_;
  Eigen::Index row = first;
  for (const JoinRule& rule : problem_->joins) {
    if (rule.kind == JoinRule::Kind::turn) {
      join_turn(rule, row, next, with_derivatives);
      row += rule.rows();
      continue;
    }
    if (rule.kind == JoinRule::Kind::offset && axis_of_[static_cast<std::size_t>(rule.column)] >= 0) {
      join_offset(rule, axis_of_[static_cast<std::size_t>(rule.column)], row, own, next, with_derivatives);
      ++row;
      continue;
    }
    const double weight = join_weights_[row - first];
    const bool is_constant = rule.kind == JoinRule::Kind::constant;
    const bool is_state = rule.kind == JoinRule::Kind::state;
    const double start = rule.start_slot == JoinRule::kNone ? rule.start : q_[rule.start_slot];
    const ComparedOutput* output = rule.kind == JoinRule::Kind::offset
                                       ? &problem_->outputs[static_cast<std::size_t>(rule.column)]
                                       : nullptr;
    const double gain = output != nullptr ? gain_at(*output, q_) : 1.0;
    const double moved = is_constant ? own[rule.own]
                         : is_state  ? values_(end, rule.column)
                                     : gain * (values_(end, rule.column) - start) + own[rule.own];
    residual_[row] = weight * (moved - next[rule.own]);
    if (with_derivatives) {
      by_next_(row, rule.own) = -weight;
      if (!is_constant) fill_row(row, end, rule.column, weight * gain);
      if (output != nullptr && output->gain)
        fill_slot(row, *output->gain, weight * (values_(end, rule.column) - start));
      if (!is_state) by_own_(row, rule.own) = weight;
      if (rule.start_slot != JoinRule::kNone) {
        const CoordinateSlot& slot = problem_->slots[static_cast<std::size_t>(rule.start_slot)];
        if (slot.role == CoordinateRole::shared) by_shared_(row, slot.index) -= weight * gain;
      }
    }
    ++row;
  }
}

void SegmentResidual::join_turn(const JoinRule& rule, Eigen::Index row, const double* next,
                                bool with_derivatives) {
  const Eigen::Index end = frame_count_;
  const Eigen::Vector4d model = values_.row(end).segment<4>(rule.column).transpose();
  const Turn turn = turn_between(next + rule.own, model.data());
  const Eigen::Vector3d weights = join_weights_.segment<3>(row - data_size_ - prior_size_);
  residual_.segment<3>(row) = weights.cwiseProduct(turn.vector);
  if (!with_derivatives) return;
  const auto outputs = static_cast<Eigen::Index>(problem_->requested.size());
  by_next_.block<3, 4>(row, rule.own) = weights.asDiagonal() * turn.by_from;
  for (std::size_t k = 0; k < source_slots_; ++k) {
    const CoordinateSlot& slot = problem_->slots[k];
    if (slot.role != CoordinateRole::shared && slot.role != CoordinateRole::own) continue;
    auto& target = slot.role == CoordinateRole::shared ? by_shared_ : by_own_;
    const Eigen::Vector4d derivative =
        derivatives_.row(end).segment<4>(rule.column + outputs * static_cast<Eigen::Index>(k)).transpose();
    target.block<3, 1>(row, slot.index) = weights.asDiagonal() * (turn.by_to * derivative);
  }
}

void SegmentResidual::centre_offsets(Eigen::VectorXd& own) const {
  for (std::size_t o = 0; o < problem_->outputs.size(); ++o) {
    const ComparedOutput& output = problem_->outputs[o];
    if (!output.offset) continue;
    double sum = 0.0;
    int count = 0;
    for (std::size_t k = 0; k < segment_->observations.size(); ++k) {
      if (segment_->observations[k].output != static_cast<int>(o)) continue;
      sum += residual_[static_cast<Eigen::Index>(k)] * output.scale;
      ++count;
    }
    if (count > 0) own[static_cast<Eigen::Index>(problem_->own.size()) + *output.offset] -= sum / count;
  }
}

std::vector<SegmentResidual> make_residuals(const models::TrajectoryFamily& family, const FitProblem& problem,
                                            const std::vector<SegmentResidual>& like) {
  std::vector<SegmentResidual> residuals;
  for (const Segment& segment : problem.segments) residuals.emplace_back(family, problem, segment);
  for (std::size_t k = 0; k < like.size(); ++k) residuals[k].set_join_weights(like[k].join_weights());
  return residuals;
}

std::string failure_of(const std::vector<SegmentResidual>& residuals) {
  for (const SegmentResidual& residual : residuals) {
    if (std::string failure = residual.failure(); !failure.empty()) return failure;
  }
  return "";
}

long evaluations_of(const std::vector<SegmentResidual>& residuals) {
  long sum = 0;
  for (const SegmentResidual& residual : residuals) sum += residual.evaluations();
  return sum;
}

}  // namespace samara::identification
