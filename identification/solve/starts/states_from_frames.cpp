#include "samara/identification/solve/starts/states_from_frames.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>

#include "samara/identification/problem/measurement.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/smoothing/smoothing.h"
#include "samara/identification/smoothing/smoothing_attitude.h"
#include "samara/identification/smoothing/smoothing_checks.h"

namespace samara::identification {

namespace {

constexpr double kGravity = 9.81;  ///< m/s^2
/// A push is compared with that so many frames later for the rate at which it turns.
constexpr int kLaterFrames = 2;
/// Small: a guess is kept as it is.
constexpr double kGuessError = 1e-4;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A motion as a table again: rows are frames of all its segments, at the times of the model and without gains.
struct Record {
  Eigen::VectorXd times;
  Eigen::MatrixXd values;      ///< frames x outputs
  Eigen::MatrixX4d attitudes;  ///< frames x (w, x, y, z)
  double delay = 0.0;          ///< s, by which the model is later than the clock of the capture
  Eigen::VectorXd gains;       ///< per output
};

/// @param q where the delay and the gains are
Record record_of(const FitProblem& problem, const Motion& motion, const Eigen::VectorXd& q) {
  std::vector<double> times;
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < motion.segment_count; ++k) {
    row += static_cast<Eigen::Index>(problem.segments[motion.first_segment + k].times.size());
  }
  Record record;
  record.delay = delay_at(problem, q);
  record.gains.resize(std::ssize(problem.outputs));
  for (std::size_t o = 0; o < problem.outputs.size(); ++o)
    record.gains[static_cast<Eigen::Index>(o)] = gain_at(problem.outputs[o], q);
  record.values.setConstant(row, static_cast<Eigen::Index>(problem.outputs.size()), kNaN);
  record.attitudes.setConstant(row, 4, kNaN);
  for (std::size_t k = 0; k < motion.segment_count; ++k) {
    const Segment& segment = problem.segments[motion.first_segment + k];
    const auto first = static_cast<Eigen::Index>(times.size());
    const std::size_t frames = segment.times.size() - (segment.joined ? 1 : 0);
    for (std::size_t f = 0; f < frames; ++f) times.push_back(segment.start + segment.times[f] + record.delay);
    for (const Observation& o : segment.observations)
      record.values(first + o.frame, o.output) = o.value / record.gains[o.output];
    for (const AttitudeObservation& a : segment.attitudes) {
      record.attitudes.row(first + a.frame) = Eigen::Vector4d(a.q_WB.data()).transpose();
    }
  }
  const auto count = static_cast<Eigen::Index>(times.size());
  record.times = Eigen::Map<const Eigen::VectorXd>(times.data(), count);
  record.values.conservativeResize(count, Eigen::NoChange);
  record.attitudes.conservativeResize(count, Eigen::NoChange);
  return record;
}

/// What is known of the state at one time: values and rates of states, with standard errors (infinite where
/// nothing is known).
struct Known {
  Eigen::VectorXd value, value_error, rate, rate_error;

  explicit Known(Eigen::Index states)
      : value(Eigen::VectorXd::Zero(states)),
        value_error(Eigen::VectorXd::Constant(states, std::numeric_limits<double>::infinity())),
        rate(value),
        rate_error(value_error) {}
};

/// Index of a state by its name.
int state_index(const models::ParametricModel& equations, const std::string& name) {
  const auto& states = equations.model().info().states;
  return static_cast<int>(std::ranges::find(states, name, &models::StateInfo::name) - states.begin());
}

/// Whether a polynomial of that degree may go through them. What is seen too rarely stays unknown.
bool are_enough(Eigen::Index frames, const StartSmoothing& smoothing) {
  return frames >= least_frames(smoothing.degree);
}

/// Frames that are not NaN.
Eigen::Index seen_frames(const Eigen::VectorXd& channel) {
  return channel.size() - channel.array().isNaN().count();
}

/// s, of two frames or more
double bandwidth_of(const Eigen::VectorXd& times, const StartSmoothing& smoothing) {
  const double duration = times[times.size() - 1] - times[0];
  return (smoothing.frames - 0.5) * duration / static_cast<double>(times.size() - 1);
}

/// The first frame shows the state later, by half the width of a mean and by the delay: back to the state.
void go_back(double lead, const Smoothed& smoothed, Eigen::Index row, int state, Known& known) {
  const double rate = smoothed.rate(row, 0);
  const double acceleration = smoothed.acceleration(row, 0);
  known.value[state] = smoothed.value(row, 0) - lead * (rate - 0.5 * lead * acceleration);
  known.rate[state] = rate - lead * acceleration;
}

void add_smoothed(const models::ParametricModel& equations, const FitProblem& problem, const Motion& motion,
                  const Record& record, const Eigen::VectorXd& at, const StartSmoothing& smoothing,
                  std::vector<Known>& known) {
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const ComparedOutput& output = problem.outputs[o];
    const Eigen::VectorXd channel = record.values.col(static_cast<Eigen::Index>(o));
    const double gain = std::abs(record.gains[static_cast<Eigen::Index>(o)]);
    if (!are_enough(seen_frames(channel), smoothing)) continue;
    const SmoothingOptions options{.degree = smoothing.degree,
                                   .bandwidth = bandwidth_of(record.times, smoothing),
                                   .noise = output.scale / gain};
    const Smoothed smoothed = output.period > 0.0
                                  ? smooth_angle(record.times, channel, output.period / gain, at, options)
                                  : smooth(record.times, channel, at, options);
    const int state = state_index(equations, output.name);
    if (state == equations.state_count()) continue;  // an output that is no state
    for (std::size_t k = 0; k < known.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      const double lead = problem.segments[motion.first_segment + k].lead + record.delay;
      go_back(lead, smoothed, row, state, known[k]);
      known[k].value_error[state] = smoothed.value_error(row, 0);
      known[k].rate_error[state] = smoothed.rate_error(row, 0);
    }
  }
}

void add_smoothed_attitude(const models::ParametricModel& equations, const FitProblem& problem,
                           const Record& record, const Eigen::VectorXd& at, const StartSmoothing& smoothing,
                           std::vector<Known>& known) {
  if (!are_enough(seen_frames(record.attitudes.col(0)), smoothing)) return;
  const double bandwidth = bandwidth_of(record.times, smoothing);
  const SmoothedAttitude smoothed =
      smooth_attitude(record.times, record.attitudes, at,
                      {.degree = smoothing.degree, .bandwidth = bandwidth, .noise = *problem.attitude_scale});
  const auto column = static_cast<std::size_t>(problem.attitude_column());
  for (std::size_t k = 0; k < known.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const Eigen::Vector4d q = smoothed.attitude.row(row).transpose();
    const Eigen::Vector3d w = smoothed.angular_velocity.row(row).transpose();
    // q' = 1/2 q (0, w)
    const Eigen::Vector4d rate = 0.5 * Eigen::Vector4d(-q[1] * w[0] - q[2] * w[1] - q[3] * w[2],
                                                       q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
                                                       q[0] * w[1] - q[1] * w[2] + q[3] * w[0],
                                                       q[0] * w[2] + q[1] * w[1] - q[2] * w[0]);
    for (std::size_t part = 0; part < 4; ++part) {
      const int state = state_index(equations, problem.requested[column + part]);
      const auto at_part = static_cast<Eigen::Index>(part);
      known[k].value[state] = q[at_part];
      known[k].value_error[state] = 0.5 * smoothed.attitude_error.row(row).norm();
      known[k].rate[state] = rate[at_part];
      known[k].rate_error[state] = 0.5 * smoothed.angular_velocity_error.row(row).norm();
    }
  }
}

/// Acceleration less that of gravity, world axes: rows as `at`. Empty if positions were not all measured, in
/// frames enough.
std::optional<Eigen::MatrixX3d> pushes(const models::ParametricModel& equations, const FitProblem& problem,
                                       const Record& record, const Eigen::VectorXd& at,
                                       const StartSmoothing& smoothing) {
  const models::ModelInfo& info = equations.model().info();
  const auto group =
      std::ranges::find(info.groups, models::StateGroupKind::position, &models::StateGroup::kind);
  if (group == info.groups.end()) return {};
  Eigen::MatrixX3d result(at.size(), 3);
  for (int axis = 0; axis < 3; ++axis) {
    const std::string& name = info.states[static_cast<std::size_t>(group->first + axis)].name;
    const auto output = std::ranges::find(problem.outputs, name, &ComparedOutput::name);
    if (output == problem.outputs.end()) return {};
    const Eigen::VectorXd channel = record.values.col(output - problem.outputs.begin());
    if (!are_enough(seen_frames(channel), smoothing)) return {};
    const double bandwidth = bandwidth_of(record.times, smoothing);
    const Smoothed smoothed =
        smooth(record.times, channel, at,
               {.degree = smoothing.degree,
                .bandwidth = bandwidth,
                .noise = output->scale / std::abs(record.gains[output - problem.outputs.begin()])});
    result.col(axis) = smoothed.acceleration.col(0);
  }
  result.col(2).array() += kGravity;
  return result;
}

void add_guessed_attitude(const models::ParametricModel& equations, const FitProblem& problem,
                          const Record& record, const Eigen::VectorXd& at, const StartSmoothing& smoothing,
                          std::vector<Known>& known) {
  if (record.times.size() < 2) return;
  const double interval = median_interval(record.times);
  const double later = kLaterFrames * interval;
  // Polynomials reach one frame beyond the last.
  const Eigen::VectorXd at_later =
      (at.array() + later).cwiseMin(record.times[record.times.size() - 1] + interval);
  const auto push = pushes(equations, problem, record, at, smoothing);
  const auto push_later = pushes(equations, problem, record, at_later, smoothing);
  if (!push || !push_later) return;
  for (std::size_t k = 0; k < known.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const GuessedAttitude guessed =
        guess_attitude(push->row(row).transpose(), push_later->row(row).transpose(), later, *smoothing.guess);
    for (std::size_t part = 0; part < 4; ++part) {
      const std::string& coordinate = problem.own[*problem.own_attitude + part].name;
      const int state = state_index(equations, coordinate.substr(0, coordinate.find('(')));
      const auto at_part = static_cast<Eigen::Index>(part);
      known[k].value[state] = guessed.q_WB[at_part];
      known[k].value_error[state] = kGuessError;
      known[k].rate[state] = guessed.rate[at_part];
      known[k].rate_error[state] = kGuessError;
    }
  }
}

/// Own unknowns in the middle of their boxes, where they have one.
Eigen::VectorXd middle_of_boxes(const FitProblem& problem) {
  Eigen::VectorXd middle = Eigen::VectorXd::Zero(problem.own_count());
  for (std::size_t k = 0; k < problem.own.size(); ++k)
    middle[static_cast<Eigen::Index>(k)] = 0.5 * (problem.own[k].lower + problem.own[k].upper);
  return middle;
}

/// The own coordinates whose states agree best with values and rates: Gauss-Newton on the equations.
class StateSearch {
 public:
  StateSearch(const models::ParametricModel& equations, const FitProblem& problem, const Motion& motion,
              const Eigen::VectorXd& shared)
      : equations_(equations),
        problem_(problem),
        workspace_(equations.make_workspace()),
        middle_(middle_of_boxes(problem)) {
    q_.setZero(std::ssize(problem.slots));
    family_point(problem, motion, shared.data(), middle_.data(), q_);
    for (std::size_t slot = 0; slot < problem.model_slots; ++slot) {
      if (problem.slots[slot].role == CoordinateRole::own && equations.free()[slot].is_initial) {
        state_of_own_.push_back(
            {problem.slots[slot].index, equations.free()[slot].index, static_cast<Eigen::Index>(slot)});
      }
    }
    states_.resize(static_cast<std::size_t>(equations.state_count()));
    rates_.resize(states_.size());
  }

  /// @param segment where the states are
  Eigen::VectorXd operator()(const Segment& segment, const Known& known) {
    if (problem_.own_attitude) {
      middle_.segment<4>(static_cast<Eigen::Index>(*problem_.own_attitude)) =
          start_attitude(problem_, segment);
    }
    for (const OwnState& s : state_of_own_) q_[s.slot] = middle_[s.own];
    equations_.initial({q_.data(), problem_.model_slots}, states_);
    for (const OwnState& s : state_of_own_) {
      if (std::isfinite(known.value_error[s.state]))
        states_[static_cast<std::size_t>(s.state)] = known.value[s.state];
    }
    constexpr int kImprovements = 8;
    for (int i = 0; i < kImprovements; ++i) improve(known);
    Eigen::VectorXd result = middle_;
    for (const OwnState& s : state_of_own_) {
      const double value = states_[static_cast<std::size_t>(s.state)];
      const models::FamilyCoordinate& c = problem_.own[static_cast<std::size_t>(s.own)];
      if (std::isfinite(value)) result[s.own] = std::clamp(value, c.lower, c.upper);
    }
    return result;
  }

  /// The last answer's.
  double state(int index) const { return states_[static_cast<std::size_t>(index)]; }

 private:
  /// A state that nothing is known of is held in the middle of its box by this share of the box.
  static constexpr double kLoose = 1e3;

  void improve(const Known& known) {
    equations_.rhs_with_derivatives(0.0, states_, {q_.data(), problem_.model_slots}, rates_, derivatives_,
                                    workspace_);
    const auto unknowns = static_cast<Eigen::Index>(state_of_own_.size());
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(unknowns);
    Eigen::VectorXd row(unknowns);
    for (Eigen::Index i = 0; i < known.rate.size(); ++i) {
      if (!std::isfinite(known.rate_error[i]) || known.rate_error[i] <= 0.0) continue;
      for (Eigen::Index k = 0; k < unknowns; ++k) {
        row[k] = derivatives_.df_dx(i, state_of_own_[static_cast<std::size_t>(k)].state);
      }
      row /= known.rate_error[i];
      normal += row * row.transpose();
      gradient += row * ((rates_[static_cast<std::size_t>(i)] - known.rate[i]) / known.rate_error[i]);
    }
    for (Eigen::Index k = 0; k < unknowns; ++k) {
      const auto& [own, state, slot] = state_of_own_[static_cast<std::size_t>(k)];
      const models::FamilyCoordinate& c = problem_.own[static_cast<std::size_t>(own)];
      const double now = states_[static_cast<std::size_t>(state)];
      const bool measured = std::isfinite(known.value_error[state]) && known.value_error[state] > 0.0;
      const double error = measured ? known.value_error[state] : kLoose * (c.upper - c.lower);
      const double target = measured ? known.value[state] : middle_[own];
      normal(k, k) += 1.0 / (error * error);
      gradient[k] += (now - target) / (error * error);
    }
    const Eigen::VectorXd step = normal.ldlt().solve(gradient);
    if (!step.allFinite()) return;
    for (Eigen::Index k = 0; k < unknowns; ++k) {
      states_[static_cast<std::size_t>(state_of_own_[static_cast<std::size_t>(k)].state)] -= step[k];
    }
  }

  struct OwnState {
    int own, state;     ///< their numbers
    Eigen::Index slot;  ///< among the coordinates
  };
  const models::ParametricModel& equations_;
  const FitProblem& problem_;
  models::ParametricModel::Workspace workspace_;
  models::RhsDerivatives derivatives_;
  std::vector<OwnState> state_of_own_;
  Eigen::VectorXd middle_;
  Eigen::VectorXd q_;  ///< with delay and gains
  std::vector<double> states_, rates_;
};

}  // namespace

std::vector<Eigen::VectorXd> states_from_frames(const models::ParametricModel& equations,
                                                const FitProblem& problem, const Motion& motion,
                                                const Eigen::VectorXd& shared,
                                                const StartSmoothing& smoothing) {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(std::ssize(problem.slots));
  family_point(problem, motion, shared.data(), middle_of_boxes(problem).data(), q);
  const Record record = record_of(problem, motion, q);
  Eigen::VectorXd at(static_cast<Eigen::Index>(motion.segment_count));
  for (std::size_t k = 0; k < motion.segment_count; ++k) {
    const Segment& segment = problem.segments[motion.first_segment + k];
    at[static_cast<Eigen::Index>(k)] = segment.start + segment.lead + record.delay;
  }
  std::vector<Known> known(motion.segment_count, Known(equations.state_count()));
  add_smoothed(equations, problem, motion, record, at, smoothing, known);
  if (problem.attitude_scale) add_smoothed_attitude(equations, problem, record, at, smoothing, known);

  if (smoothing.guess && problem.own_attitude && !problem.attitude_scale) {
    add_guessed_attitude(equations, problem, record, at, smoothing, known);
  }

  StateSearch search(equations, problem, motion, shared);
  std::vector<Eigen::VectorXd> result;
  for (std::size_t k = 0; k < known.size(); ++k) {
    const Known& one = known[k];
    result.push_back(search(problem.segments[motion.first_segment + k], one));
    for (const ComparedOutput& output : problem.outputs) {
      if (!output.offset) continue;
      const int state = state_index(equations, output.name);
      if (state == equations.state_count() || !std::isfinite(one.value_error[state])) continue;
      result.back()[static_cast<Eigen::Index>(problem.own.size()) + *output.offset] =
          gain_at(output, q) * (one.value[state] - search.state(state));
    }
  }
  return result;
}

}  // namespace samara::identification
