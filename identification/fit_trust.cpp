#include "samara/identification/fit_trust.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/identification/determined_inverse.h"
#include "samara/identification/loss.h"
#include "samara/identification/minimize.h"
#include "samara/identification/segment_residual.h"

namespace samara::identification {

namespace {

/// Noise of a millionth of the loss scale: less is none, and what is left of the cost is rounding.
constexpr double kLeastDispersion = 1e-12;

double usable(double dispersion) {
  return std::isnan(dispersion) ? 1.0 : std::max(dispersion, kLeastDispersion);
}

/// One over the diagonal of the inverse information: the curvature of each profile. 0 for coefficients that
/// are not determined.
Eigen::VectorXd profile_curvatures(const Uncertainty& uncertainty) {
  const Eigen::MatrixXd& information = uncertainty.information;
  const DeterminedInverse inverse = invert_determined(information, Eigen::VectorXd::Zero(information.rows()));
  Eigen::VectorXd curvatures = Eigen::VectorXd::Zero(information.rows());
  for (Eigen::Index k = 0; k < curvatures.size(); ++k) {
    if (inverse.determined[static_cast<std::size_t>(k)]) curvatures[k] = 1.0 / inverse.inverse(k, k);
  }
  return curvatures;
}

/// The dispersion with which a profile has the width of the coefficient's standard error.
double dispersion_of(const Coefficient& c, double curvature, double naive) {
  const double error = c.standard_error.value_or(c.naive_standard_error.value_or(0.0));
  const double dispersion = error * error * curvature;
  return dispersion > 0.0 ? usable(dispersion) : usable(naive);
}

/// Of the dispersion: from clusters where the error is, else from what is left over of the frames.
double degrees_of_freedom(const FitProblem& problem, const Coefficient& c) {
  if (c.standard_error) return std::max(1, problem.cluster_count - 1);
  const int unknowns =
      problem.shared_count() + problem.own_count() * static_cast<int>(problem.segments.size());
  return std::max(1, problem.observation_count() - unknowns);
}

/// The problem without one of its shared unknowns, which is held at a value that can be changed.
struct HeldProblem {
  FitProblem problem;
  CoordinateSlot* slot = nullptr;

  HeldProblem(const FitProblem& whole, int held) : problem(whole) {
    problem.shared.erase(problem.shared.begin() + held);
    for (CoordinateSlot& s : problem.slots) {
      if (s.role != CoordinateRole::shared) continue;
      if (s.index == held) {
        slot = &s;
      } else if (s.index > held) {
        --s.index;
      }
    }
    slot->role = CoordinateRole::fixed;
  }
  HeldProblem(const HeldProblem&) = delete;
  HeldProblem& operator=(const HeldProblem&) = delete;
};

/// Shared unknowns, then each capture's own, in one vector; and back.
Eigen::VectorXd packed(const FitPoint& point) {
  Eigen::Index size = point.shared.size();
  for (const Eigen::VectorXd& own : point.own) size += own.size();
  Eigen::VectorXd values(size);
  values.head(point.shared.size()) = point.shared;
  Eigen::Index at = point.shared.size();
  for (const Eigen::VectorXd& own : point.own) {
    values.segment(at, own.size()) = own;
    at += own.size();
  }
  return values;
}

FitPoint unpacked(const FitProblem& problem, const Eigen::VectorXd& values) {
  FitPoint point;
  const Eigen::Index shared = problem.shared_count();
  const Eigen::Index own = problem.own_count();
  point.shared = values.head(shared);
  for (std::size_t c = 0; c < problem.segments.size(); ++c)
    point.own.push_back(values.segment(shared + own * static_cast<Eigen::Index>(c), own));
  return point;
}

FitPoint without(const FitPoint& point, Eigen::Index held) {
  const Eigen::Index after = point.shared.size() - 1 - held;
  Eigen::VectorXd shared(held + after);
  shared.head(held) = point.shared.head(held);
  shared.tail(after) = point.shared.tail(after);
  return {std::move(shared), point.own};
}

/// Fits with one coefficient held.
class HeldFits {
 public:
  HeldFits(const TrajectoryFamily& family, const FitProblem& whole, int held, int max_iterations)
      : held_(whole, held), max_iterations_(max_iterations) {
    for (const Segment& segment : held_.problem.segments)
      residuals_.emplace_back(family, held_.problem, segment);
  }

  std::optional<ProfileSolution> solve(double value, const Eigen::VectorXd& warm_start) {
    held_.slot->value = value;
    if (held_.problem.shared_count() + held_.problem.own_count() == 0) return cost_without_unknowns();
    const MinimizeResult run =
        minimize(held_.problem, residuals_, unpacked(held_.problem, warm_start), max_iterations_);
    if (run.status == FitStatus::failed) return {};
    return ProfileSolution{run.cost, packed(run.point)};
  }

  long evaluations() const {
    long sum = 0;
    for (const SegmentResidual& residual : residuals_) sum += residual.evaluations();
    return sum;
  }

 private:
  std::optional<ProfileSolution> cost_without_unknowns() {
    double cost = 0.0;
    for (SegmentResidual& residual : residuals_) {
      if (!residual.evaluate(nullptr, nullptr, false)) return {};
      for (const double r : residual.residual()) cost += 0.5 * loss_value(held_.problem.loss, r).rho;
    }
    return ProfileSolution{cost, {}};
  }

  HeldProblem held_;
  int max_iterations_;
  std::vector<SegmentResidual> residuals_;
};

std::span<const double> span_of(const Eigen::VectorXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

/// The larger of the naive dispersion and the mean of what the clusters say, trace(V H)/p.
double overall_dispersion(const Uncertainty& uncertainty, const FitResult& result) {
  double trace = 0.0;
  int count = 0;
  for (Eigen::Index i = 0; i < result.covariance.rows(); ++i) {
    if (std::isnan(result.covariance(i, i))) continue;
    for (Eigen::Index k = 0; k < result.covariance.rows(); ++k) {
      if (!std::isnan(result.covariance(i, k)))
        trace += result.covariance(i, k) * uncertainty.information(k, i);
    }
    ++count;
  }
  return std::max(usable(uncertainty.dispersion), count > 0 ? trace / count : 0.0);
}

}  // namespace

void add_whiteness(FitResult& result) {
  std::vector<SeriesWhiteness> all;
  for (const CaptureFit& capture : result.captures) {
    for (std::size_t o = 0; o < capture.residuals.size(); ++o) {
      const auto column = static_cast<Eigen::Index>(o);
      const Eigen::VectorXd residual = capture.measured.col(column) - capture.model.col(column);
      SeriesWhiteness series = series_whiteness(span_of(capture.times), span_of(residual));
      series.capture = capture.id;
      series.output = capture.residuals[o].output;
      all.push_back(std::move(series));
    }
  }
  result.whiteness = pool_whiteness(std::move(all));
}

void add_identifiability(const Uncertainty& uncertainty, FitResult& result) {
  if (result.coefficients.empty()) return;
  std::vector<InformedCoefficient> coefficients;
  for (const Coefficient& c : result.coefficients)
    coefficients.push_back({.name = c.name, .value = c.value, .scale = 0.5 * (c.upper - c.lower)});
  result.identifiability =
      identifiability(coefficients, uncertainty.information, overall_dispersion(uncertainty, result));
}

long add_profiles(const TrajectoryFamily& family, const FitProblem& problem, const FitPoint& point,
                  const Uncertainty& uncertainty, int max_iterations, FitResult& result) {
  const Eigen::VectorXd curvatures = profile_curvatures(uncertainty);
  long evaluations = 0;
  for (std::size_t k = 0; k < result.coefficients.size(); ++k) {
    const Coefficient& c = result.coefficients[k];
    const auto at = static_cast<Eigen::Index>(k);
    const ProfileTarget target{.name = c.name,
                               .best = c.value,
                               .best_cost = result.cost,
                               .scale = c.standard_error.value_or(c.naive_standard_error.value_or(0.0)),
                               .lower = c.lower,
                               .upper = c.upper};
    HeldFits fits(family, problem, static_cast<int>(k), max_iterations);
    const ProfileSolver solver = [&](double value, const Eigen::VectorXd& warm_start) {
      return fits.solve(value, warm_start);
    };
    const double dispersion = dispersion_of(c, curvatures[at], uncertainty.dispersion);
    result.profiles.push_back(
        profile(target, packed(without(point, at)), solver,
                {.dispersion = dispersion, .degrees_of_freedom = degrees_of_freedom(problem, c)}));
    evaluations += fits.evaluations();
  }
  return evaluations;
}

void add_profile_warnings(FitResult& result) {
  for (const Profile& p : result.profiles) {
    const Coefficient& c = *std::ranges::find(result.coefficients, p.name, &Coefficient::name);
    if (p.shape == ProfileShape::better_elsewhere) {
      result.warnings.push_back(
          fmt::format("the profile of {} met a {}: the fit ended in a local optimum; more starts are advised",
                      p.name, describe(p)));
    } else if (p.shape != ProfileShape::identified && c.determined && !c.at_bound) {
      result.warnings.push_back(
          fmt::format("the captures determine {} to one side at most: {}", p.name, describe(p)));
    }
  }
}

}  // namespace samara::identification
