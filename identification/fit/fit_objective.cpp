#include "samara/identification/fit/fit_objective.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/parallel.h"
#include "samara/identification/problem/camera.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/laplace_evidence.h"
#include "samara/identification/statistics/loss.h"
#include "samara/models/trajectories/trajectory_family.h"

namespace samara::identification {

namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

std::vector<FitUnknown> unknowns_of(const FitProblem& problem) {
  std::vector<FitUnknown> unknowns;
  for (const models::FamilyCoordinate& c : problem.shared)
    unknowns.push_back({c.name, c.unit, c.lower, c.upper});
  for (const Segment& segment : problem.segments) {
    const Motion& motion = problem.motion_of(segment);
    const std::string of =
        (motion.segment_count > 1 ? motion.id + " at " + std::to_string(segment.start) : motion.id) + ": ";
    for (const models::FamilyCoordinate& c : problem.own)
      unknowns.push_back({of + c.name, c.unit, c.lower, c.upper});
    for (const ComparedOutput& output : problem.outputs) {
      if (output.offset)
        unknowns.push_back({of + "offset of " + output.name, output.unit, -kUnbounded, kUnbounded});
    }
    for (const std::string& name : camera_unknowns(problem))
      unknowns.push_back({of + name, name == kCameraScale ? "1" : "rad", -kUnbounded, kUnbounded});
  }
  return unknowns;
}

Eigen::VectorXd in_one_row(const FitPoint& point) {
  Eigen::Index size = point.shared.size();
  for (const Eigen::VectorXd& own : point.own) size += own.size();
  Eigen::VectorXd all(size);
  all.head(point.shared.size()) = point.shared;
  Eigen::Index next = point.shared.size();
  for (const Eigen::VectorXd& own : point.own) {
    all.segment(next, own.size()) = own;
    next += own.size();
  }
  return all;
}

}  // namespace

struct FitObjective::Impl {
  const models::TrajectoryFamily& family;
  FitProblem problem;
  FitPoint point;
  std::vector<FitUnknown> unknowns;
  Eigen::VectorXd answer;
  double dispersion;
  std::mutex mutex;
  std::vector<SegmentResidual> segments;
  Eigen::Index rows = 0;

  Impl(const models::TrajectoryFamily& of_family, FitProblem of, const std::vector<SegmentResidual>& like,
       const FitPoint& at, double dispersion_of_residuals)
      : family(of_family),
        problem(std::move(of)),
        point(at),
        unknowns(unknowns_of(problem)),
        answer(in_one_row(point)),
        dispersion(dispersion_of_residuals),
        segments(make_residuals(family, problem, like)) {
    for (const SegmentResidual& segment : segments) rows += segment.size();
    rows += std::ssize(problem.priors);
  }

  Eigen::Index first_of(std::size_t segment) const {
    return problem.shared_count() + static_cast<Eigen::Index>(segment) * problem.own_count();
  }

  void check(std::span<const double> q) const {
    if (q.size() != unknowns.size()) {
      throw ArgumentError(fmt::format("a point of {} numbers, expected {}, one for every unknown of the fit",
                                      q.size(), unknowns.size()));
    }
    const auto bad = std::ranges::find_if_not(q, [](double value) { return std::isfinite(value); });
    if (bad == q.end()) return;
    throw ArgumentError(fmt::format("\"{}\" is {}, expected a finite number",
                                    unknowns[static_cast<std::size_t>(bad - q.begin())].name, *bad));
  }

  /// @returns whether all residuals are finite, whatever their derivatives are
  bool evaluate(const double* q, bool with_derivatives) {
    parallel_for(segments.size(), [&](std::size_t k) {
      const double* own = q + first_of(k);
      const double* next = segments[k].segment().joined ? q + first_of(k + 1) : nullptr;
      segments[k].evaluate(q, own, next, with_derivatives);
    });
    return std::ranges::all_of(segments, &SegmentResidual::has_residuals);
  }

  /// Calls row(residual, is_data, derivatives of it into a row of all unknowns) for one after the other.
  template <class Row>
  void for_each_row(const double* q, const Row& row) const {
    for (std::size_t k = 0; k < segments.size(); ++k) {
      const SegmentResidual& segment = segments[k];
      const double weight = std::sqrt(problem.motion_of(segment.segment()).weight);
      for (Eigen::Index i = 0; i < segment.size(); ++i) {
        row(segment.residual()[i], weight, i < segment.data_size(),
            [&, i](auto&& derivatives, double factor) {
              derivatives.head(problem.shared_count()) = factor * segment.by_shared().row(i);
              derivatives.segment(first_of(k), problem.own_count()) = factor * segment.by_own().row(i);
              if (segment.segment().joined)
                derivatives.segment(first_of(k + 1), problem.own_count()) = factor * segment.by_next().row(i);
            });
      }
    }
    for (const PriorTerm& prior : problem.priors) {
      row(prior.residual(q), 1.0, false, [&](auto&& derivatives, double factor) {
        for (const auto& [unknown, weight] : prior.weights())
          derivatives[unknown] += factor * weight * prior.slope(q);
      });
    }
  }
};

FitObjective::FitObjective(const models::TrajectoryFamily& family, const FitProblem& problem,
                           const std::vector<SegmentResidual>& like, const FitPoint& answer,
                           double dispersion)
    : impl_(std::make_unique<Impl>(family, problem, like, answer, dispersion)) {}
FitObjective::~FitObjective() = default;

const std::vector<FitUnknown>& FitObjective::unknowns() const {
  return impl_->unknowns;
}

const Eigen::VectorXd& FitObjective::answer() const {
  return impl_->answer;
}

Eigen::Index FitObjective::residual_count() const {
  return impl_->rows;
}

bool FitObjective::residuals(std::span<const double> q, Eigen::Ref<Eigen::VectorXd> values,
                             Eigen::MatrixXd* jacobian) const {
  impl_->check(q);
  if (values.size() != impl_->rows)
    throw ArgumentError(fmt::format("room for {} residuals, expected {}", values.size(), impl_->rows));
  const std::scoped_lock lock(impl_->mutex);
  if (!impl_->evaluate(q.data(), jacobian != nullptr)) return false;
  if (jacobian) jacobian->setZero(impl_->rows, std::ssize(q));
  Eigen::Index i = 0;
  impl_->for_each_row(q.data(), [&](double r, double weight, bool is_data, const auto& fill) {
    double factor = weight, value = weight * r;
    if (is_data) {
      const LossValue loss = loss_value(impl_->problem.loss, r);
      const double size = std::sqrt(loss.rho);
      value = weight * std::copysign(size, r);
      if (size > 0.0) factor *= std::abs(loss.psi) / size;
    }
    values[i] = value;
    if (jacobian) fill(jacobian->row(i), factor);
    ++i;
  });
  return true;
}

double FitObjective::log_posterior(std::span<const double> q, Eigen::VectorXd* gradient) const {
  impl_->check(q);
  if (gradient) gradient->setZero(std::ssize(q));
  for (std::size_t k = 0; k < q.size(); ++k) {
    if (q[k] < impl_->unknowns[k].lower || q[k] > impl_->unknowns[k].upper) return -kUnbounded;
  }
  const std::scoped_lock lock(impl_->mutex);
  if (!impl_->evaluate(q.data(), gradient != nullptr)) return -kUnbounded;
  double sum = 0.0;
  for (int k = 0; k < impl_->problem.shared_count(); ++k) {
    if (!impl_->problem.shared_chart.is_logarithmic(k)) continue;
    const double value = q[static_cast<std::size_t>(k)];
    sum -= std::log(value);
    if (gradient) (*gradient)[k] -= 1.0 / value;
  }
  Eigen::RowVectorXd slope(std::ssize(q));
  impl_->for_each_row(q.data(), [&](double r, double weight, bool is_data, const auto& fill) {
    const LossValue loss = is_data ? loss_value(impl_->problem.loss, r) : LossValue{r * r, r, 1.0};
    const double share = weight * weight / (is_data ? impl_->dispersion : 1.0);
    sum -= 0.5 * share * loss.rho;
    if (!gradient) return;
    slope.setZero();
    fill(slope, -share * loss.psi);
    *gradient += slope.transpose();
  });
  return sum;
}

Outcome<Evidence> FitObjective::evidence() const {
  const std::scoped_lock lock(impl_->mutex);
  return laplace_evidence(impl_->family, impl_->problem, impl_->segments, impl_->point);
}

}  // namespace samara::identification
