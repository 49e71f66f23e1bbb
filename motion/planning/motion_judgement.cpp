#include "samara/motion/planning/motion_judgement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/motion/patterns/features.h"

namespace samara::motion {

namespace {

std::string in_unit(double value, const std::string& unit) {
  return unit == "1" ? fmt::format("{:.4g}", value) : fmt::format("{:.4g} {}", value, unit);
}

/// The pattern of a stretch of a motion that has settled.
PatternLabel label_of_stretch(const PlannedFall& fall, const RealisedFall& real, double begin, double end) {
  const double* const first = real.times.data();
  const double* const last = first + real.times.size();
  const Eigen::Index from = std::lower_bound(first, last, begin) - first;
  const Eigen::Index count = std::upper_bound(first, last, end) - first - from;
  // About a hundred frames a swing are more than features need.
  const Eigen::Index every =
      std::max<Eigen::Index>(1, std::lround(0.02 * fall.longest_piece() / fall.plan().search.step));
  RecordBuilder builder(fall.states(), static_cast<std::size_t>(count / every + 1));
  std::vector<double> state(static_cast<std::size_t>(real.states.cols()));
  for (Eigen::Index row = from; row < from + count; row += every) {
    for (std::size_t i = 0; i < state.size(); ++i) state[i] = real.states(row, static_cast<Eigen::Index>(i));
    builder.add(real.times[row], state);
  }
  if (static_cast<Eigen::Index>(builder.count()) < kFewestFrames)
    return {Pattern::unresolved, 0.0, "the stretch has too few frames"};
  MotionRecord record = builder.record(2.0 * fall.semi_length());
  record.position_noise = record.angle_noise = 0.0;  // of a simulation
  if (fall.plan().sequence->is_of_places) {
    record.normals.resize(0, 3);
    record.angles.resize(0);
  }
  return label(features(record, {.settle_share = 0.0}), fall.plan().sequence->thresholds);
}

/// Stretches of equal patterns, each judged as a whole.
void judge_stretches(const PlannedFall& fall, const RealisedFall& real, SequenceOutcome& outcome) {
  const std::vector<AskedSegment>& asked = fall.plan().sequence->segments;
  const double over = real.times[real.times.size() - 1];
  for (std::size_t n = 0; n < asked.size();) {
    std::size_t last = n;
    while (last + 1 < asked.size() && asked[last + 1].pattern == asked[n].pattern) ++last;
    SequenceOutcome::Stretch stretch{.begin = over, .end = over, .asked = *asked[n].pattern};
    stretch.got.why = "the fall was over before";
    if (n < outcome.segments.size()) {
      stretch.begin = outcome.segments[n].begin;
      stretch.end = outcome.segments[std::min(last, outcome.segments.size() - 1)].end;
      stretch.got = label_of_stretch(fall, real, stretch.begin, stretch.end);
    } else {
      ++outcome.not_reached;
    }
    outcome.had += stretch.got.pattern == stretch.asked ? 1 : 0;
    ++outcome.asked;
    outcome.stretches.push_back(stretch);
    n = last + 1;
  }
}

SequenceOutcome outcome_of(const PlannedFall& fall, const RealisedFall& real) {
  const MotionSequence& sequence = *fall.plan().sequence;
  SequenceOutcome outcome;
  double sum = 0.0, priced = 0.0;
  std::vector<int> past;
  const EventList list = events_of_motion(fall, real);
  for (std::size_t k = 1; k < list.events.size(); ++k) {
    const Event& event = list.events[k];
    SequenceOutcome::Segment segment{.begin = list.events[k - 1].t, .end = event.t};
    if (!event.is_steady) segment.got = event.kind;
    if (k - 1 < sequence.segments.size()) segment.asked = sequence.segments[k - 1].kind;
    if (sequence.chain && segment.got) {
      const int kind = static_cast<int>(*segment.got);
      sum += std::log(sequence.chain->probability(past, kind));
      priced += 1.0;
      past.push_back(kind);
    }
    // As in chains, what is steady cuts a sequence.
    if (!segment.got) past.clear();
    outcome.segments.push_back(segment);
  }
  outcome.log_likelihood = priced == 0.0 ? std::numeric_limits<double>::quiet_NaN() : sum / priced;
  if (sequence.is_of_patterns()) {
    judge_stretches(fall, real, outcome);
    return outcome;
  }
  outcome.asked = static_cast<int>(sequence.segments.size());
  outcome.not_reached = std::max(0, outcome.asked - static_cast<int>(outcome.segments.size()));
  for (const SequenceOutcome::Segment& segment : outcome.segments)
    outcome.had += segment.asked && segment.asked == segment.got ? 1 : 0;
  return outcome;
}

std::string sequence_sentence(const SequenceOutcome& outcome, bool is_of_patterns) {
  std::string text =
      fmt::format("{} of {} {} as asked", outcome.had, outcome.asked, is_of_patterns ? "stretches" : "kinds");
  if (outcome.not_reached > 0) text += fmt::format(", {} not reached", outcome.not_reached);
  return text;
}

/// What was asked, and how near the motion came.
struct Distances {
  double miss = 0.0;  ///< the larger one of those that `deviation` is asked of
  std::string text;
};

Distances distances_of(const MotionPlan& plan, const RealisedFall& real, const std::string& length) {
  Distances all;
  if (plan.sketch) {
    all.miss = real.deviation;
    all.text = in_unit(real.deviation, length) + " rms from the sketch";
  }
  if (plan.landing) {
    all.miss = std::max(all.miss, real.landing_miss);
    all.text += fmt::format("{}{} from the landing place", all.text.empty() ? "" : ", ",
                            in_unit(real.landing_miss, length));
  }
  return all;
}

}  // namespace

EventList events_of_motion(const PlannedFall& fall, const RealisedFall& real) {
  if (!fall.plan().sequence) return {};
  const Eigen::MatrixXd states = real.states.transpose();
  EventFinder finder = fall.finder();
  EventList list;
  for (Eigen::Index k = 0; k < states.cols(); ++k) {
    if (finder.see(real.times[k], {states.col(k).data(), static_cast<std::size_t>(states.rows())}))
      list.events.push_back(finder.event());
  }
  return list;
}

void judge_motion(const PlannedFall& fall, const RealisedFall& real, MotionResult& result) {
  const MotionPlan& plan = fall.plan();
  if (real.times.size() == 0) {
    result.course.reset();
    result.status = MotionStatus::lost;
    result.message = "the motion that was found is not finite when it is integrated";
    return;
  }
  result.times = real.times;
  result.states = real.states;
  result.end = real.times[real.times.size() - 1];
  result.deviation = real.deviation;
  result.landing_miss = real.landing_miss;
  const auto& info = plan.model->info();
  const std::string length = std::ranges::find(info.states, "x", &models::StateInfo::name)->unit;
  const std::string time = models::time_unit(info);
  const auto [miss, distances] = distances_of(plan, real, length);
  result.status = MotionStatus::found;
  result.message = distances;
  if (plan.sequence) {
    result.sequence = outcome_of(fall, real);
    if (result.sequence->asked > 0) {
      result.message += (distances.empty() ? "" : "; ") +
                        sequence_sentence(*result.sequence, plan.sequence->is_of_patterns());
      if (result.sequence->had < result.sequence->asked) result.status = MotionStatus::kinds_missed;
    }
  }
  if (result.message.empty()) result.message = fmt::format("a fall of {}", in_unit(result.end, time));
  if (!real.is_over || (plan.landing && !real.landed)) {
    const Eigen::VectorXd state = real.states.row(real.states.rows() - 1);
    const double height =
        fall.states().position({state.data(), static_cast<std::size_t>(state.size())}).z() - plan.ground;
    result.status = MotionStatus::not_landed;
    result.message = fmt::format("{} above the ground after {}; {}", in_unit(height, length),
                                 in_unit(result.end, time), result.message);
  } else if (plan.duration && result.end < *plan.duration * (1.0 - 1e-9)) {
    result.status = MotionStatus::landed_early;
    result.message += fmt::format("; on the ground after {} of {}", in_unit(result.end, time),
                                  in_unit(*plan.duration, time));
  } else if (plan.deviation && miss > *plan.deviation) {
    result.status = MotionStatus::deviation_missed;
    result.message += fmt::format("; {} was asked", in_unit(*plan.deviation, length));
  }
}

}  // namespace samara::motion
