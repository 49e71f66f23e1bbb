#include "samara/identification/solve/starts/start_point.h"

#include <array>
#include <cmath>

namespace samara::identification {

namespace {

/// Van der Corput's sequence: the digits of `index` in `base`, mirrored at the point.
double radical_inverse(int index, int base) {
  double value = 0.0;
  double weight = 1.0;
  for (int rest = index; rest > 0; rest /= base) {
    weight /= base;
    value += weight * (rest % base);
  }
  return value;
}

/// Place of start `index` in dimension `dimension`, from 0 to 1. The centre is the first Halton point in base
/// 2; leaving it out of all bases keeps the others apart from it.
double place(int index, int dimension) {
  constexpr std::array kPrimes = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53};
  if (index == 0) return 0.5;
  const int base = kPrimes[static_cast<std::size_t>(dimension) % kPrimes.size()];
  return 0.1 + 0.8 * radical_inverse(index + 1, base);
}

/// What the box gives for the parts of an attitude is no attitude.
void set_attitude(const FitProblem& problem, const Segment& segment, int index, Eigen::VectorXd& own) {
  if (!problem.own_attitude) return;
  const auto first = static_cast<Eigen::Index>(*problem.own_attitude);
  own.segment<4>(first) =
      index == 0 ? start_attitude(problem, segment) : unit_attitude(own.segment<4>(first));
}

}  // namespace

FitPoint start_point(const FitProblem& problem, std::vector<SegmentResidual>& residuals, int index) {
  int dimension = 0;
  const auto at = [&](const models::FamilyCoordinate& c, bool logarithmic) {
    const double part = place(index, dimension++);
    return logarithmic ? c.lower * std::pow(c.upper / c.lower, part) : c.lower + (c.upper - c.lower) * part;
  };
  FitPoint point;
  point.shared.setZero(problem.shared_count());
  for (int k = 0; k < problem.shared_count(); ++k)
    point.shared[k] = at(problem.shared[static_cast<std::size_t>(k)], problem.shared_chart.is_logarithmic(k));
  if (index == 0) {
    for (const auto& [k, value] : problem.initial) point.shared[k] = value;
  }
  Eigen::VectorXd own = Eigen::VectorXd::Zero(problem.own_count());
  for (std::size_t k = 0; k < problem.own.size(); ++k)
    own[static_cast<Eigen::Index>(k)] = at(problem.own[k], false);
  for (SegmentResidual& residual : residuals) {
    set_attitude(problem, residual.segment(), index, own);
    point.own.push_back(own);
    if (problem.offsets.empty()) continue;
    const double* next = residual.segment().joined ? own.data() : nullptr;
    if (residual.evaluate(point.shared.data(), own.data(), next, false))
      residual.centre_offsets(point.own.back());
  }
  return point;
}

}  // namespace samara::identification
