#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/nodal_approximation.h"
#include "samara/pgd/slab_march.h"
#include "samara/pgd/train_points.h"

namespace samara::pgd {

namespace {

/// Of the local tolerance, for time.
constexpr double kTimeShare = 0.2;
/// Proposals of the next length stay this far from the one that would just do.
constexpr double kCaution = 0.9;
/// States larger than this many scales: the solution is on its way to infinity.
constexpr double kBeyond = 1e4;
/// Part of its own size by which a solution moves within the shortest element where it is about to end.
constexpr double kOwnSize = 0.02;
/// Orders of convergence in time, over that of smooth solutions, that speak of a kink.
constexpr double kKinked = 0.5;
/// And lengths of elements, over the usual one.
constexpr double kShort = 0.4;

}  // namespace

/// Largest difference, at the nodes of both halves of an element, from the solution on those halves: sees
/// kinks, which the decay of the coefficients of one element does not.
double SlabMarch::error_in_time(const SlabPoints& element, double begin, double end,
                                const Eigen::MatrixXd& q) {
  const Eigen::Index states = collocation_.states();
  const SlabTime& time = collocation_.time();
  const SlabPoints halves = collocation_.solve({begin, 0.5 * (begin + end), end},
                                               element.values.topRows(states), q, iteration_tolerance());
  attempt_evaluations_ += halves.evaluations;
  if (halves.first_failed() >= 0) return std::numeric_limits<double>::infinity();
  double error = 0.0;
  for (Eigen::Index j = 0; j < element.values.cols(); ++j) {
    const auto whole = element.values.col(j).reshaped(states, time.points() + 1);
    const auto fine = halves.values.col(j).reshaped(states, 2 * time.points() + 1);
    error = std::max(
        error,
        (whole * time.at_halves.transpose() - fine.rightCols(2 * time.points())).cwiseAbs().maxCoeff());
  }
  return error;
}

/// Marches the guard points, from the train, element by element, each as long as polynomials in time follow
/// all of them: the elements of the next slab.
SlabMarch::Outcome SlabMarch::probe(SlabCell& cell) {
  const double slab_end = std::min(cell.time + options_.largest_slab * problem_.end, problem_.end);
  const Eigen::Index states = collocation_.states();
  ProbedSlab slab;
  slab.borders = {cell.time};
  slab.values = values_at(cell.start, cell.axes, cell.guards);
  double length = cell.length;
  struct {
    double length = 0.0, error = 0.0;
  } refused;
  // Ranks grow with the length of a slab, so that only short elements are put together.
  const double together = cell.time + options_.joint_slab * problem_.end;
  const auto may_grow = [&] {
    const auto elements = static_cast<int>(slab.borders.size()) - 1;
    return elements == 0 || (elements < options_.max_elements && slab.end() + length <= together);
  };
  while (slab.end() < slab_end && may_grow()) {
    const double left = slab_end - slab.end();
    // The last two elements share what is left, so that none is a crumb.
    const double tried = length >= left ? left : std::min(length, 0.5 * left);
    const double end = tried == left ? slab_end : slab.end() + tried;
    const SlabPoints solved = collocation_.solve({slab.end(), end}, slab.values.bottomRows(states),
                                                 cell.guards, iteration_tolerance());
    attempt_evaluations_ += solved.evaluations;
    const bool failed = solved.first_failed() >= 0 || solved.values.cwiseAbs().maxCoeff() > kBeyond;
    double wanted = kTimeShare * cell.leniency * tolerance_;
    const double error = failed ? 0.0 : std::max(error_in_time(solved, slab.end(), end, cell.guards), 1e-300);
    const double factor = kCaution * std::pow(wanted / error, 1.0 / options_.time_points);
    const bool slow =
        refused.length > 0.0 &&
        std::log(refused.error / error) < kKinked * options_.time_points * std::log(refused.length / tried);
    if (!failed && error > wanted && cell.leniency < most_lenient_ &&
        (slow || tried < kShort * cell.usual_length)) {
      if (slab.borders.size() > 1) break;  // the kink has a slab of its own
      cell.leniency = most_lenient_;
      wanted = kTimeShare * cell.leniency * tolerance_;
    }
    if (failed || error > wanted) {
      if (!failed) refused = {tried, error};
      length = tried * (failed ? 0.5 : std::clamp(factor, 0.2, 0.9));
      if (length >= options_.least_slab * problem_.end) continue;
      if (slab.borders.size() > 1) break;  // what goes before it is a slab; the next one will end the march
      return give_up(cell, tried, solved, cell.guards);
    }
    refused = {};
    length = tried * std::clamp(factor, 0.5, 2.0);
    slab.borders.push_back(end);
    const Eigen::MatrixXd before = std::move(slab.values);
    slab.values.resize(before.rows() + solved.values.rows() - states, before.cols());
    slab.values << before, solved.values.bottomRows(solved.values.rows() - states);
  }
  slab.next_length = std::max(length, options_.least_slab * problem_.end);
  cell.slab = std::move(slab);
  return Outcome::accepted;
}

/// Half as many elements, or one of half the length.
SlabMarch::Outcome SlabMarch::shorten(SlabCell& cell, const SlabPoints& points, const Eigen::MatrixXd& q) {
  ProbedSlab& slab = *cell.slab;
  const std::size_t elements = slab.borders.size() - 1;
  const double first = slab.borders[1] - slab.borders[0];
  if (elements > 1) {
    slab.borders.resize(elements / 2 + 1);
    const Eigen::Index nodes = static_cast<Eigen::Index>(elements / 2) * options_.time_points + 1;
    slab.values.conservativeResize(nodes * collocation_.states(), Eigen::NoChange);
    slab.next_length = slab.end() - slab.borders[elements / 2 - 1];
    return Outcome::shorter;
  }
  cell.slab.reset();
  cell.length = 0.5 * first;
  if (cell.length >= options_.least_slab * problem_.end) return Outcome::shorter;
  return give_up(cell, first, points, q);
}

/// Whether the state at the start of an element moves by a good part of its own size within it, as solutions
/// do close to where they end.
bool SlabMarch::moves_by_its_size(double t, const Eigen::VectorXd& element, const Eigen::VectorXd& q,
                                  double length) const {
  const Eigen::VectorXd start = element.head(collocation_.states());
  Eigen::MatrixXd rate;
  problem_.system->rhs(Eigen::VectorXd::Constant(1, t), scales_.cwiseProduct(start), q, rate);
  const double moved = length * rate.col(0).cwiseQuotient(scales_).cwiseAbs().maxCoeff();
  return !(moved < kOwnSize * start.cwiseAbs().maxCoeff());
}

SlabMarch::Outcome SlabMarch::give_up(const SlabCell& cell, double length, const SlabPoints& points,
                                      const Eigen::MatrixXd& q) {
  Eigen::Index worst = points.first_failed();
  if (worst < 0) points.values.cwiseAbs().colwise().maxCoeff().maxCoeff(&worst);
  const Eigen::VectorXd at = q.col(worst);
  const std::string place = described(cell.axes, {at.begin(), at.end()});
  const bool unsolved = points.first_failed() >= 0 &&
                        points.status[static_cast<std::size_t>(worst)] == SlabPointStatus::no_contraction &&
                        !moves_by_its_size(cell.time, points.values.col(worst), at, length);
  return end(
      unsolved ? SlabStatus::no_contraction : SlabStatus::ceases,
      fmt::format("at t = {:.6g} and {} {} even in steps of {:.3g}", cell.time, place,
                  unsolved ? "the equations could not be solved" : "the solution grows beyond all bounds",
                  length),
      at);
}

}  // namespace samara::pgd
