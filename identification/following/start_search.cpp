#include "samara/identification/following/start_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

#include "samara/identification/following/covariances.h"
#include "samara/identification/following/measured_states.h"
#include "samara/models/batch/rk4_flow.h"
#include "samara/models/integrators/rotations.h"

namespace samara::identification {

namespace {

/// rad: of an attitude that nothing is known of, about each axis; it hardly holds a descent back.
constexpr double kAnyTurn = 1.5;
/// rad: an angle with as large a deviation may start anywhere on its circle.
constexpr double kAnyAngle = 1.2;
/// Of what frames themselves say of a state they measure: it is left to them.
constexpr double kLoose = 100.0;
constexpr int kDescentSteps = 25;
/// Of a standard error: two starts that differ by less, in all, are one.
constexpr double kSame = 0.5;
/// A frame that is missed so many times worse than the median frame is an outlier.
constexpr double kFarOff = 25.0;
/// Ways on that are carried at most.
constexpr int kMostHypotheses = 6;

struct StartPrior {
  Eigen::VectorXd point;       ///< its mean
  Eigen::VectorXd deviations;  ///< of the errors of states; 0: held
  Eigen::MatrixXd root;        ///< errors x unknowns: errors are root times numbers that are standard normal
  Eigen::VectorXi spread;      ///< per error: 1 where it is a part of an attitude or angle that is not known
};

Eigen::Vector4d first_attitude(std::span<const SeenFrame> frames) {
  for (const SeenFrame& frame : frames) {
    if (!frame.attitude.hasNaN()) return frame.attitude.normalized();
  }
  return {1.0, 0.0, 0.0, 0.0};
}

/// How far from a value a state has been.
double farthest(const StateRanges& been, Eigen::Index state, double from) {
  if (been.lowest.size() == 0) return 0.0;
  return std::max(std::abs(been.lowest[state] - from), std::abs(been.highest[state] - from));
}

/// What turns a round body about its axis cannot be seen: where it is held, it stays so.
bool is_unseen_spin(const FollowOptions& options, const models::StateInfo& state) {
  return options.round_body && noise_by_unit(state) == &ModelNoise::rate;
}

StartPrior prior_of(const FollowedModel& model, std::span<const SeenFrame> frames, const MeasuredStates& seen,
                    const StateRanges& been) {
  const FollowOptions& options = model.options();
  const auto& states = model.equations().model().info().states;
  StartPrior prior{.point = Eigen::VectorXd::Zero(model.size()),
                   .deviations = Eigen::VectorXd::Zero(model.errors()),
                   .root = {},
                   .spread = Eigen::VectorXi::Zero(model.errors())};
  bool attitude_fixed = false, attitude_moved = false;
  for (Eigen::Index i = 0; i < model.states(); ++i) {
    const models::StateInfo& state = states[static_cast<std::size_t>(i)];
    const auto fixed = options.fixed.find(state.name + "(0)");
    const auto start = options.start.find(state.name);
    const bool of_attitude = model.attitude() && i >= *model.attitude() && i < *model.attitude() + 4;
    const bool is_fixed = fixed != options.fixed.end();
    const double known = is_fixed                       ? fixed->second
                         : start != options.start.end() ? start->second.mean
                                                        : state.default_initial;
    const double moved = farthest(been, i, known);
    prior.point[i] = known;
    if (of_attitude) {
      constexpr double kRounding = 1e-9;  // a quaternion is normalised at each step
      attitude_fixed = attitude_fixed || is_fixed;
      attitude_moved = attitude_moved || moved > kRounding;
      continue;
    }
    if (is_fixed && (moved == 0.0 || is_unseen_spin(options, state))) continue;
    const Eigen::Index error = model.error_of_state(i);
    const bool is_shown = !std::isnan(seen.values[i]);
    const bool is_prior = start != options.start.end() && (moved == 0.0 || !is_shown);
    if (is_prior || !is_shown) {
      const double deviation = is_prior && !is_fixed ? start->second.deviation : 0.0;
      prior.deviations[error] = std::hypot(deviation, moved);
    } else {
      prior.point[i] = seen.values[i];
      const double noise = options.noise.at(state.name);
      double lowest = seen.values[i], highest = lowest;
      for (const SeenFrame& frame : frames) {
        for (Eigen::Index row = 0; row < std::ssize(model.measured()); ++row) {
          const SeenOutput& output = model.measured()[static_cast<std::size_t>(row)];
          if (!output.is_state || output.index != i || std::isnan(frame.values[row])) continue;
          lowest = std::min(lowest, frame.values[row]);
          highest = std::max(highest, frame.values[row]);
        }
      }
      prior.deviations[error] = kLoose * noise + (highest - lowest);
    }
    const bool is_angle = state.unit == "rad" && std::isnan(seen.values[i]);
    prior.spread[error] = is_angle && prior.deviations[error] > kAnyAngle ? 1 : 0;
  }
  if (const auto at = model.attitude(); at && (!attitude_fixed || attitude_moved)) {
    const bool is_seen = model.attitude_is_measured();
    prior.point.segment<4>(*at) = is_seen ? first_attitude(frames) : Eigen::Vector4d(1.0, 0.0, 0.0, 0.0);
    prior.deviations.segment<3>(*at).setConstant(
        is_seen ? std::min(kAnyTurn, kLoose * *options.attitude_noise) : kAnyTurn);
    if (!is_seen) prior.spread.segment<3>(*at).setOnes();
  } else if (at) {
    prior.point.segment<4>(*at).normalize();
  }
  Eigen::MatrixXd covariance = prior.deviations.array().square().matrix().asDiagonal();
  for (Eigen::Index j = 0; j < model.coefficients(); ++j) {
    const FollowedCoefficient& c = options.coefficients[static_cast<std::size_t>(j)];
    prior.point[model.states() + j] = c.value;
    covariance(model.error_of_coefficient(j), model.error_of_coefficient(j)) = c.deviation * c.deviation;
  }
  if (options.coefficient_covariance.size() > 0)
    covariance.bottomRightCorner(model.coefficients(), model.coefficients()) = options.coefficient_covariance;
  prior.root = root_of(covariance);
  return prior;
}

/// Attitudes all around: the 24 turns that leave a cube as it is, at most 63 degrees from any. Of a round body the 13
/// axes of a cube through its faces, edges and corners, along which z may lie.
std::vector<Eigen::Vector4d> attitudes_around(bool round_body) {
  std::vector<Eigen::Vector4d> attitudes;
  const auto add = [&](double angle, const Eigen::Vector3d& axis) {
    const models::Quaternion q = models::rotation_exponential(angle * axis.normalized());
    attitudes.emplace_back(q[0], q[1], q[2], q[3]);
  };
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const Eigen::Vector3d axis(x, y, z);
        const int parts = x * x + y * y + z * z;
        const bool upper = z > 0 || (z == 0 && (y > 0 || (y == 0 && x > 0)));
        if (!upper) continue;
        if (round_body) {
          // About what is at right angles to z and the axis; of z itself the angle is 0.
          add(std::acos(axis.z() / std::sqrt(parts)),
              Eigen::Vector3d(-axis.y(), axis.x(), x == 0 && y == 0 ? 1.0 : 0.0));
          continue;
        }
        constexpr double kTurn = 2.0 * std::numbers::pi;
        const int turns = parts == 1 ? 4 : parts == 2 ? 2 : 3;
        for (int turn = 1; turn < turns; ++turn) add(kTurn * turn / turns, axis);
      }
    }
  }
  if (!round_body) add(0.0, Eigen::Vector3d::UnitZ());
  return attitudes;
}

/// Points from which descents begin: attitudes and angles all around.
std::vector<Eigen::VectorXd> beginnings(const FollowedModel& model, const StartPrior& prior) {
  std::vector<Eigen::VectorXd> points;
  if (model.attitude() && prior.spread[*model.attitude()] == 1) {
    for (const Eigen::Vector4d& attitude : attitudes_around(model.options().round_body)) {
      points.push_back(prior.point);
      points.back().segment<4>(*model.attitude()) = attitude;
    }
    return points;
  }
  points.push_back(prior.point);
  for (Eigen::Index i = 0; i < model.states(); ++i) {
    if (prior.spread[model.error_of_state(i)] == 0) continue;
    constexpr int kAngles = 8;
    std::vector<Eigen::VectorXd> more;
    for (const Eigen::VectorXd& point : points) {
      for (int k = 0; k < kAngles; ++k) {
        more.push_back(point);
        more.back()[i] += 2.0 * std::numbers::pi * k / kAngles;
      }
    }
    points = std::move(more);
  }
  return points;
}

/// Moves states that are not measured such that the equations give the rates that were measured; attitude and angles
/// stay.
void meet_rates(const FollowedModel& model, double time, const MeasuredStates& seen, const StartPrior& prior,
                Eigen::VectorXd& point) {
  Eigen::VectorXd deviations = prior.deviations;
  for (Eigen::Index e = 0; e < deviations.size(); ++e) {
    if (prior.spread[e] == 1) deviations[e] = 0.0;
  }
  deviations.tail(model.coefficients()).setZero();
  for (Eigen::Index i = 0; i < model.states(); ++i) {
    const bool of_attitude = model.attitude() && i >= *model.attitude() && i < *model.attitude() + 4;
    if (!of_attitude && !std::isnan(seen.values[i])) deviations[model.error_of_state(i)] = 0.0;
  }
  const Eigen::VectorXd mean = point;
  auto workspace = model.equations().make_workspace();
  models::RhsDerivatives derivatives;
  Eigen::VectorXd rates(model.states()), error(model.errors());
  Eigen::MatrixXd by_point = Eigen::MatrixXd::Zero(model.states(), model.size());
  Eigen::MatrixXd by_errors(model.states(), model.errors());
  for (int iteration = 0; iteration < 6; ++iteration) {
    model.equations().rhs_with_derivatives(time, {point.data(), static_cast<std::size_t>(model.states())},
                                           {point.data(), static_cast<std::size_t>(model.size())},
                                           {rates.data(), static_cast<std::size_t>(rates.size())},
                                           derivatives, workspace);
    if (!rates.allFinite() || !derivatives.df_dx.allFinite()) {
      point = mean;
      return;
    }
    by_point.leftCols(model.states()) = derivatives.df_dx;
    model.times_plus(by_point, point, by_errors);
    model.minus(point, mean, error);
    Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(model.errors(), model.errors());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(model.errors());
    for (Eigen::Index i = 0; i < model.states(); ++i) {
      if (std::isnan(seen.rates[i])) continue;
      const Eigen::VectorXd row = by_errors.row(i).transpose().cwiseProduct(deviations) / seen.rate_errors[i];
      normal += row * row.transpose();
      right += row * ((seen.rates[i] - rates[i]) / seen.rate_errors[i] +
                      by_errors.row(i).dot(error) / seen.rate_errors[i]);
    }
    const Eigen::VectorXd whole = normal.llt().solve(right).cwiseProduct(deviations);
    model.plus(mean, whole, point);
  }
}

/// One descent: the most likely point at the first frame.
class Descent {
 public:
  Descent(const FollowedModel& model, std::span<const SeenFrame> frames, const StartPrior& prior,
          HypothesisFilter& filter)
      : model_(model),
        frames_(frames),
        prior_(prior),
        filter_(filter),
        flow_(model.equations(), model.options().step, directions(model)),
        weights_(Eigen::VectorXd::Ones(std::ssize(frames))) {}

  /// @param mean of the prior, about which unknowns are counted; @param begin where the descent begins
  /// @returns whether there is a finite motion
  bool run(const Eigen::VectorXd& mean, const Eigen::VectorXd& begin, Hypothesis& found) {
    weights_.setOnes();
    mean_ = mean;
    Eigen::VectorXd error(model_.errors());
    model_.minus(begin, mean, error);
    // Scaled by the deviations, a root's columns are of about the same size.
    const Eigen::VectorXd scales =
        prior_.root.rowwise().norm().unaryExpr([](double size) { return size > 0.0 ? 1.0 / size : 0.0; });
    const Eigen::MatrixXd scaled = scales.asDiagonal() * prior_.root;
    const Eigen::VectorXd right = scaled.transpose() * scales.cwiseProduct(error);
    const Eigen::MatrixXd gram = scaled.transpose() * scaled;
    Eigen::VectorXd unknowns = Eigen::LLT<Eigen::MatrixXd>(gram).solve(right);
    if (!descend(unknowns)) return false;
    if (weigh_outliers() && !descend(unknowns)) return false;
    const Eigen::LLT<Eigen::MatrixXd> llt(normal_);
    if (llt.info() != Eigen::Success) return false;
    double log_determinant = 0.0;
    for (Eigen::Index k = 0; k < normal_.rows(); ++k)
      log_determinant += 2.0 * std::log(llt.matrixLLT()(k, k));
    found.point = point_;
    const Eigen::MatrixXd half = llt.matrixL().solve(root_here_.transpose());
    found.covariance = half.transpose() * half;
    found.log_weight = -cost_ - 0.5 * log_determinant;
    return true;
  }

 private:
  static std::vector<int> directions(const FollowedModel& model) {
    std::vector<int> all(static_cast<std::size_t>(model.size()));
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<int>(k);
    return all;
  }

  /// Cost, normal equations and gradient at the unknowns.
  bool linearise(const Eigen::VectorXd& unknowns) {
    const Eigen::Index states = model_.states(), moving = model_.errors() - model_.coefficients();
    point_.resize(model_.size());
    const Eigen::VectorXd error = prior_.root * unknowns;
    model_.plus(mean_, error, point_);
    root_here_ = prior_.root;
    if (const auto at = model_.attitude())
      root_here_.middleRows<3>(*at) = right_jacobian(error.segment<3>(*at)) * prior_.root.middleRows<3>(*at);
    cost_ = 0.5 * unknowns.squaredNorm();
    normal_ = Eigen::MatrixXd::Identity(unknowns.size(), unknowns.size());
    gradient_ = unknowns;
    misses_.setZero(std::ssize(frames_));
    Eigen::VectorXd here = point_;
    Eigen::VectorXd residuals(model_.compared()), variances(model_.compared());
    Eigen::MatrixXd by_errors(model_.compared(), model_.errors());
    Eigen::MatrixXd by_flow(states, model_.size()), by_start(states, model_.errors());
    Eigen::MatrixXd upper(model_.errors(), model_.errors());
    const double lead = filter_.lead();
    flow_.start({point_.data(), static_cast<std::size_t>(point_.size())}, frames_.front().time - lead);
    for (std::size_t k = 0; k < frames_.size(); ++k) {
      const double time = frames_[k].time - lead;
      if (!flow_.advance(std::max(0.0, time - flow_.time()))) return false;
      flow_.read({here.data(), static_cast<std::size_t>(states)});
      flow_.read_derivatives(by_flow);
      model_.times_plus(by_flow, point_, by_start);
      Eigen::MatrixXd transition = Eigen::MatrixXd::Identity(model_.errors(), model_.errors());
      model_.minus_times(here, by_start, upper);
      transition.topRows(moving) = upper.topRows(moving);
      if (const auto at = model_.attitude()) here.segment<4>(*at).normalize();
      if (!filter_.compare(here, time, frames_[k], residuals, &by_errors, variances)) return false;
      const double weight = weights_[static_cast<Eigen::Index>(k)];
      const Eigen::VectorXd scales = variances.array().sqrt().inverse();
      const Eigen::VectorXd scaled = residuals.cwiseProduct(scales);
      const Eigen::MatrixXd rows = scales.asDiagonal() * by_errors * transition * root_here_;
      misses_[static_cast<Eigen::Index>(k)] = scaled.squaredNorm();
      cost_ += 0.5 * weight * scaled.squaredNorm();
      normal_.noalias() += weight * rows.transpose() * rows;
      gradient_.noalias() -= weight * rows.transpose() * scaled;
    }
    return std::isfinite(cost_) && normal_.allFinite();
  }

  bool descend(Eigen::VectorXd& unknowns) {
    if (!linearise(unknowns)) return false;
    double damping = 1e-3;
    for (int step = 0; step < kDescentSteps; ++step) {
      const double before = cost_;
      const Eigen::MatrixXd normal = normal_;
      const Eigen::VectorXd gradient = gradient_;
      Eigen::MatrixXd damped = normal;
      damped.diagonal() *= 1.0 + damping;
      const Eigen::VectorXd next = unknowns - damped.llt().solve(gradient);
      if (next.allFinite() && linearise(next) && cost_ < before) {
        unknowns = next;
        damping = std::max(1e-9, 0.1 * damping);
        if (before - cost_ < 1e-6 * (1.0 + cost_)) return true;
        continue;
      }
      damping *= 10.0;
      if (!linearise(unknowns)) return false;
      if (damping > 1e6) return true;
    }
    return true;
  }

  /// @returns whether there are outliers
  bool weigh_outliers() {
    std::vector<double> sorted(misses_.data(), misses_.data() + misses_.size());
    std::ranges::nth_element(sorted, sorted.begin() + std::ssize(sorted) / 2);
    const double middle = sorted[sorted.size() / 2];
    bool any = false;
    for (Eigen::Index k = 0; k < misses_.size(); ++k) {
      const double gate = filter_.gate(frames_[static_cast<std::size_t>(k)].count);
      if (misses_[k] <= gate || misses_[k] <= kFarOff * middle) continue;
      weights_[k] = gate / misses_[k];
      any = true;
    }
    return any;
  }

  const FollowedModel& model_;
  std::span<const SeenFrame> frames_;
  const StartPrior& prior_;
  HypothesisFilter& filter_;
  models::Rk4Flow flow_;
  Eigen::VectorXd weights_, misses_;  ///< per frame
  Eigen::VectorXd mean_, point_, gradient_;
  Eigen::MatrixXd root_here_, normal_;
  double cost_ = 0.0;
};

bool are_same(const FollowedModel& model, const Hypothesis& a, const Hypothesis& b) {
  Eigen::VectorXd error(model.errors());
  model.minus(b.point, a.point, error);
  const Eigen::VectorXd deviations = a.covariance.diagonal().array().max(0.0).sqrt();
  return (error.array().abs() <= kSame * deviations.array() + 1e-12).all();
}

}  // namespace

void StateRanges::add(const Eigen::VectorXd& point) {
  if (lowest.size() == 0) lowest = highest = point;
  lowest = lowest.cwiseMin(point);
  highest = highest.cwiseMax(point);
}

std::vector<Hypothesis> find_starts(const FollowedModel& model, std::span<const SeenFrame> frames,
                                    HypothesisFilter& filter, const StateRanges& been) {
  const MeasuredStates seen = measured_states(model, frames);
  const StartPrior prior = prior_of(model, frames, seen, been);
  Descent descent(model, frames, prior, filter);
  std::vector<Hypothesis> starts;
  for (const Eigen::VectorXd& mean : beginnings(model, prior)) {
    Eigen::VectorXd begin = mean;
    meet_rates(model, frames.front().time, seen, prior, begin);
    Hypothesis found;
    if (descent.run(mean, begin, found)) starts.push_back(std::move(found));
  }
  std::ranges::stable_sort(starts, std::ranges::greater{}, &Hypothesis::log_weight);
  std::vector<Hypothesis> kept;
  for (Hypothesis& start : starts) {
    const bool is_known =
        std::ranges::any_of(kept, [&](const Hypothesis& other) { return are_same(model, other, start); });
    if (!is_known) kept.push_back(std::move(start));
  }
  if (std::ssize(kept) > kMostHypotheses) kept.resize(static_cast<std::size_t>(kMostHypotheses));
  return kept;
}

}  // namespace samara::identification
