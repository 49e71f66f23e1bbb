#include "samara/identification/solve/laplace_evidence.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/identification/problem/camera.h"
#include "samara/identification/solve/posterior_density.h"
#include "samara/identification/statistics/loss.h"

namespace samara::identification {

namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
/// Of the noise, over the loss scales: a thousandth to a thousandfold.
const double kNoiseRange = std::log(1e3);

Ending no_evidence(std::string message) {
  return {.status = Termination::not_determined, .message = std::move(message)};
}

/// By Simpson's rule.
double integral(const std::function<double(double)>& f, double lower, double upper) {
  constexpr int kIntervals = 4000;
  const double h = (upper - lower) / kIntervals;
  double sum = f(lower) + f(upper);
  for (int k = 1; k < kIntervals; ++k) sum += (k % 2 == 1 ? 4.0 : 2.0) * f(lower + k * h);
  return sum * h / 3.0;
}

/// ln of the integral of exp(-rho(r)/(2 f^2)) over all r.
double log_norm_of_loss(LossKind loss, double log_factor) {
  const double f = std::exp(log_factor);
  if (loss == LossKind::none) return std::log(f * std::sqrt(kTwoPi));
  // Tails fall like exp(-|r|/f^2), or faster: is_density().
  const double reach = 40.0 * std::max(f, f * f);
  return std::log(2.0 * integral([&](double r) { return std::exp(-0.5 * loss_value(loss, r).rho / (f * f)); },
                                 0.0, reach));
}

/// Priors of single unknowns; nothing: one is of several.
struct Priors {
  const std::vector<PriorTerm>& terms;
  bool are_single() const {
    return std::ranges::all_of(terms, [](const PriorTerm& term) { return term.weights().size() == 1; });
  }
  std::vector<const PriorTerm*> of(Eigen::Index unknown) const {
    std::vector<const PriorTerm*> found;
    for (const PriorTerm& term : terms) {
      if (term.weights().front().unknown == unknown) found.push_back(&term);
    }
    return found;
  }
};

/// ln of what the prior of an unknown adds up to in its box, over the way in which it moves.
double log_norm_of_prior(const models::FamilyCoordinate& box, bool by_factor,
                         const std::vector<const PriorTerm*>& priors, Eigen::Index unknown,
                         Eigen::Index unknowns) {
  const double lower = by_factor ? std::log(box.lower) : box.lower;
  const double upper = by_factor ? std::log(box.upper) : box.upper;
  if (priors.empty()) return std::log(upper - lower);
  std::vector<double> all(static_cast<std::size_t>(unknowns), 1.0);
  const auto residual_squares = [&](double place) {
    all[static_cast<std::size_t>(unknown)] = by_factor ? std::exp(place) : place;
    double squares = 0.0;
    for (const PriorTerm* prior : priors) squares += std::pow(prior->residual(all.data()), 2);
    return squares;
  };
  // Where the prior is, in ever narrower parts of the box: it may be much narrower than that.
  double low = lower, high = upper;
  constexpr int kParts = 200;
  constexpr double kNothing = 80.0;
  for (int turn = 0; turn < 8; ++turn) {
    const double h = (high - low) / kParts;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= kParts; ++k) least = std::min(least, residual_squares(low + k * h));
    int first = kParts, last = 0;
    for (int k = 0; k <= kParts; ++k) {
      if (residual_squares(low + k * h) > least + kNothing) continue;
      first = std::min(first, k);
      last = std::max(last, k);
    }
    const double from = low + std::max(0, first - 1) * h, to = low + std::min(kParts, last + 1) * h;
    low = from;
    high = to;
  }
  return std::log(
      integral([&](double place) { return std::exp(-0.5 * residual_squares(place)); }, low, high));
}

/// ln of the norm of all priors of the shared unknowns, or of one motion's own; or why there is none.
Outcome<double> log_norm_of_priors(const std::vector<models::FamilyCoordinate>& boxes, const Chart& chart,
                                   const std::vector<PriorTerm>& terms) {
  const Priors priors{terms};
  if (!priors.are_single())
    return no_evidence("a prior is of several unknowns together; its norm in the box is not known");
  double sum = 0.0;
  int attitude_parts = 0, free = 0;
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const auto unknown = static_cast<Eigen::Index>(k);
    if (chart.is_part_of_quaternion(static_cast<int>(k))) {
      ++attitude_parts;
      continue;
    }
    if (chart.direction_of(static_cast<int>(k)) < 0) continue;  // held
    ++free;
    if (!std::isfinite(boxes[k].upper - boxes[k].lower)) {
      return no_evidence(
          fmt::format("{} has no box, so that its prior is none; a finite box was expected", boxes[k].name));
    }
    sum += log_norm_of_prior(boxes[k], chart.is_logarithmic(static_cast<int>(k)), priors.of(unknown), unknown,
                             std::ssize(boxes));
  }
  // All attitudes, or all directions of an axis.
  const int directions = chart.directions() - free - (chart.size() - static_cast<int>(boxes.size()));
  if (attitude_parts > 0)
    sum += (attitude_parts / 4) * std::log(directions % 3 == 0 ? 2.0 * kTwoPi * kTwoPi : 2.0 * kTwoPi);
  return sum;
}

/// Of all unknowns.
Outcome<double> log_norm_of_priors(const FitProblem& problem) {
  if (!problem.offsets.empty()) {
    return no_evidence(
        fmt::format("the offset of {} of each capture may be anything, so that its prior is none; outputs "
                    "without offsets "
                    "were expected",
                    problem.offsets.front()));
  }
  const Outcome<double> shared = log_norm_of_priors(problem.shared, problem.shared_chart, problem.priors);
  if (!shared) return shared.ending();
  const Outcome<double> own = log_norm_of_priors(problem.own, problem.own_chart, problem.own_priors);
  if (!own) return own.ending();
  double of_each = *own;
  if (problem.camera) {
    for (const double deviation : problem.camera->deviations)
      of_each += std::log(deviation * std::sqrt(kTwoPi));
  }
  return *shared + static_cast<double>(problem.motions.size()) * of_each;
}

/// Outputs and captures that are compared, by name.
ComparedValues compared_values(const FitProblem& problem) {
  ComparedValues compared;
  for (const ComparedOutput& output : problem.outputs) compared.outputs.push_back(output.name);
  if (problem.attitude_scale) compared.outputs.emplace_back("attitude");
  std::ranges::sort(compared.outputs);
  for (const Motion& motion : problem.motions) compared.captures.emplace_back(motion.file, motion.id);
  std::ranges::sort(compared.captures);
  return compared;
}

/// Sum of the logarithms of the loss scales of all values.
double log_scales(const FitProblem& problem) {
  double sum = 0.0;
  for (const Segment& segment : problem.segments) {
    for (const Observation& seen : segment.observations)
      sum += std::log(problem.outputs[static_cast<std::size_t>(seen.output)].scale);
    for (std::size_t k = 0; k < segment.attitudes.size(); ++k) sum += 3.0 * std::log(*problem.attitude_scale);
  }
  return sum;
}

/// The logarithm of the noise factor under which data of this cost are most likely.
double likely_noise(LossKind loss, const PosteriorDensity::DataCost& data) {
  const auto n = static_cast<double>(data.values);
  const auto minus_log = [&](double log_factor) {
    return n * log_norm_of_loss(loss, log_factor) + data.cost * std::exp(-2.0 * log_factor);
  };
  // Golden section.
  const double part = 0.5 * (std::sqrt(5.0) - 1.0);
  double low = -kNoiseRange, high = kNoiseRange;
  double a = high - part * (high - low), b = low + part * (high - low);
  double at_a = minus_log(a), at_b = minus_log(b);
  while (high - low > 1e-8) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - part * (high - low);
      at_a = minus_log(a);
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + part * (high - low);
      at_b = minus_log(b);
    }
  }
  return 0.5 * (low + high);
}

FitPoint moved(const FitProblem& problem, const DirectionLayout& layout, const FitPoint& from,
               const Eigen::VectorXd& step) {
  FitPoint to = from;
  const Eigen::VectorXd shared = step.head(layout.shared);
  problem.shared_chart.plus(from.shared.data(), shared.data(), to.shared.data());
  for (std::size_t k = 0; k < from.own.size(); ++k) {
    const Eigen::VectorXd own = step.segment(layout.first_of(k), layout.own);
    problem.own_chart.plus(from.own[k].data(), own.data(), to.own[k].data());
  }
  return to;
}

/// The minimum of unknowns and noise together.
struct Mode {
  FitPoint point;
  double log_factor = 0.0;
  double value = 0.0;     ///< -log of the density, but for norms
  Eigen::VectorXd slope;  ///< of it
};

/// Where a step of Newton promises to lower -log of the density by no more than this, is its minimum: that much the
/// logarithm of the evidence may be off.
constexpr double kLeft = 1e-3;

Outcome<Mode> find_mode(PosteriorDensity& density, const FitProblem& problem, const FitPoint& answer) {
  constexpr int kMost = 50, kHalvings = 20;
  constexpr double kStill = 1e-8;
  Mode mode{.point = answer, .slope = {}};
  double before = std::numeric_limits<double>::infinity(), gain = before;
  for (int turn = 0; turn <= kMost; ++turn) {
    mode.value = density(mode.point, mode.slope);
    if (!std::isfinite(mode.value)) return no_evidence("at the answer " + density.failure());
    mode.log_factor = likely_noise(problem.loss, density.data_cost(mode.point));
    density.set_dispersion(std::exp(2.0 * mode.log_factor));
    mode.value = density(mode.point, mode.slope);
    const Eigen::LLT<Eigen::MatrixXd> llt(density.second_derivative(mode.point));
    if (llt.info() != Eigen::Success) return no_evidence("captures and priors do not determine all unknowns");
    Eigen::VectorXd step = -llt.solve(mode.slope);
    gain = -0.5 * step.dot(mode.slope);
    if (!(gain > kStill) && std::abs(before - mode.log_factor) < 1e-6) break;
    if (turn == kMost) break;
    before = mode.log_factor;
    Eigen::VectorXd unused;
    int halving = 0;
    for (; halving < kHalvings; ++halving, step *= 0.5) {
      FitPoint next = moved(problem, density.layout(), mode.point, step);
      if (!(density(next, unused) <= mode.value)) continue;
      mode.point = std::move(next);
      break;
    }
    if (halving == kHalvings) {
      mode.value = density(mode.point, mode.slope);  // the density is asked of its last point below
      break;
    }
  }
  if (!(gain <= kLeft)) {
    return no_evidence(
        fmt::format("the minimum was not found: a step is still to lower it by {:.3g}; at most {} was "
                    "expected",
                    gain, kLeft));
  }
  return mode;
}

/// A box whose wall lies nearer than two deviations; null: none.
const BoxedDirection* near_wall(const PosteriorDensity& density, const FitPoint& point,
                                const Eigen::MatrixXd& covariance) {
  for (const BoxedDirection& boxed : density.boxed()) {
    const double reach = 2.0 * std::sqrt(covariance(boxed.direction, boxed.direction));
    const double place = boxed.place(point);
    if (place - reach < boxed.lower || place + reach > boxed.upper) return &boxed;
  }
  return nullptr;
}

}  // namespace

Outcome<Evidence> laplace_evidence(const models::TrajectoryFamily& family, const FitProblem& problem,
                                   const std::vector<SegmentResidual>& residuals, const FitPoint& answer) {
  if (!is_density(problem.loss)) {
    return no_evidence(fmt::format("the loss \"{}\" is no density of noise; another loss was expected",
                                   to_string(problem.loss)));
  }
  if (problem.segments.size() != problem.motions.size())
    return no_evidence("captures are cut into segments; whole ones were expected");
  const Outcome<double> log_prior_norm = log_norm_of_priors(problem);
  if (!log_prior_norm) return log_prior_norm.ending();

  PosteriorDensity density(family, problem, residuals, 1.0);
  const Outcome<Mode> mode = find_mode(density, problem, answer);
  if (!mode) return mode.ending();
  if (std::abs(mode->log_factor) > 0.99 * kNoiseRange)
    return no_evidence("residuals are a thousand times smaller or larger than the loss scales");
  const PosteriorDensity::DataCost data = density.data_cost(mode->point);
  const auto n = static_cast<double>(data.values);
  const double dispersion = std::exp(2.0 * mode->log_factor);

  // Second derivatives by unknowns and the logarithm of the noise: the slope of the data's part is -2 of it by the
  // noise.
  const Eigen::MatrixXd H = density.second_derivative(mode->point);
  const Eigen::LLT<Eigen::MatrixXd> llt(H);
  if (llt.info() != Eigen::Success) return no_evidence("captures and priors do not determine all unknowns");
  const Eigen::MatrixXd covariance = llt.solve(Eigen::MatrixXd::Identity(H.rows(), H.cols()));
  if (const BoxedDirection* wall = near_wall(density, mode->point, covariance)) {
    const std::string& name =
        (wall->is_shared ? problem.shared : problem.own)[static_cast<std::size_t>(wall->unknown)].name;
    return no_evidence(fmt::format("{} lies within two deviations of a bound of its box", name));
  }
  Eigen::VectorXd with_half;
  density.set_dispersion(2.0 * dispersion);
  density(mode->point, with_half);
  const Eigen::VectorXd cross = -2.0 * (2.0 * (mode->slope - with_half));
  constexpr double kStep = 1e-3;
  const double bend_of_norm = (log_norm_of_loss(problem.loss, mode->log_factor + kStep) -
                               2.0 * log_norm_of_loss(problem.loss, mode->log_factor) +
                               log_norm_of_loss(problem.loss, mode->log_factor - kStep)) /
                              (kStep * kStep);
  const double by_noise =
      n * (problem.loss == LossKind::none ? 0.0 : bend_of_norm) + 4.0 * data.cost / dispersion;
  const double left_by_noise = by_noise - cross.dot(covariance * cross);
  if (!(left_by_noise > 0.0)) return no_evidence("the noise is not determined");

  double log_det = std::log(left_by_noise);
  for (Eigen::Index k = 0; k < H.rows(); ++k) log_det += 2.0 * std::log(llt.matrixLLT()(k, k));
  const double unknowns = static_cast<double>(H.rows());
  return Evidence{.log = -mode->value - n * log_norm_of_loss(problem.loss, mode->log_factor) -
                         log_scales(problem) - *log_prior_norm - std::log(2.0 * kNoiseRange) +
                         0.5 * (unknowns + 1.0) * std::log(kTwoPi) - 0.5 * log_det,
                  .values = static_cast<int>(data.values),
                  .compared = compared_values(problem),
                  .unknowns = static_cast<int>(H.rows()),
                  .noise_factor = std::exp(mode->log_factor)};
}

}  // namespace samara::identification
