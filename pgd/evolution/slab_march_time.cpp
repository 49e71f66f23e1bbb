#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/slab_march.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Of the local tolerance, for time.
constexpr double kShareOfTime = 0.2;
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
constexpr const char* kGrows = "the solution grows beyond all bounds";

}  // namespace

/// Largest difference, at the nodes of both halves of an element, from the solution on those halves: sees
/// kinks, which the decay of the coefficients of one element does not. Infinite where a half was not solved.
SlabMarch::WorstPoint SlabMarch::error_in_time(const SlabPoints& element, double begin, double end,
                                               const Eigen::MatrixXd& q) {
  const Eigen::Index states = collocation_.states();
  const SlabTime& time = collocation_.time();
  const SlabPoints halves = collocation_.solve({begin, 0.5 * (begin + end), end},
                                               element.values.topRows(states), q, iteration_tolerance());
  attempt_evaluations_ += halves.evaluations;
  if (const int failed = halves.first_failed(); failed >= 0)
    return {std::numeric_limits<double>::infinity(), failed};
  WorstPoint worst;
  for (Eigen::Index j = 0; j < element.values.cols(); ++j) {
    const auto whole = element.values.col(j).reshaped(states, time.points() + 1);
    const auto fine = halves.values.col(j).reshaped(states, 2 * time.points() + 1);
    const double error =
        (whole * time.at_halves.transpose() - fine.rightCols(2 * time.points())).cwiseAbs().maxCoeff();
    if (error > worst.error) worst = {error, j};
  }
  return worst;
}

/// Marches the guard points, from the train, element by element, each as long as polynomials in time follow
/// all of them: the elements of the next slab.
SlabMarch::Outcome SlabMarch::probe(SlabCell& cell) {
  const double least = options_.least_slab * problem_.end;
  double slab_end = std::min(cell.time + options_.largest_slab * problem_.end, problem_.end);
  if (problem_.end - slab_end < least) slab_end = problem_.end;  // what is left would be a crumb
  const Eigen::Index states = collocation_.states();
  ProbedSlab slab;
  slab.borders = {cell.time};
  slab.values = values_at(cell.start, cell.axes, cell.guards);
  double length = cell.length;
  struct {
    double length = 0.0, error = 0.0;
  } refused;
  // Ranks grow with the length of a slab, so that only short elements are put together. Kinks, which may err
  // by more, get slabs of their own; those too hold several elements, as each slab rounds the state anew.
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
    const WorstPoint worst = failed ? WorstPoint() : error_in_time(solved, slab.end(), end, cell.guards);
    const double error = std::max(worst.error, 1e-300);
    const auto wanted = [&] { return kShareOfTime * cell.leniency * tolerance_; };
    const auto factor = [&] { return kCaution * std::pow(wanted() / error, 1.0 / options_.time_points); };
    const bool slow =
        refused.length > 0.0 &&
        std::log(refused.error / error) < kKinked * options_.time_points * std::log(refused.length / tried);
    if (!failed && error > wanted() && cell.leniency < most_lenient_ &&
        (slow || tried < kShort * cell.usual_length)) {
      if (slab.borders.size() > 1) break;
      cell.leniency = most_lenient_;
    }
    if (failed || error > wanted()) {
      if (!failed) refused = {tried, error};
      length = tried * (failed ? 0.5 : std::clamp(factor(), 0.2, 0.9));
      if (length >= least) continue;
      if (slab.borders.size() > 1) break;  // what goes before it is a slab; the next one will end the march
      return failed ? give_up(cell, tried, solved, cell.guards)
                    : give_up_on_time(cell, tried, cell.guards.col(worst.point));
    }
    refused = {};
    length = tried * std::clamp(factor(), 0.5, 2.0);
    slab.borders.push_back(end);
    const Eigen::MatrixXd before = std::move(slab.values);
    slab.values.resize(before.rows() + solved.values.rows() - states, before.cols());
    slab.values << before, solved.values.bottomRows(solved.values.rows() - states);
  }
  slab.next_length = std::max(length, least);
  cell.slab = std::move(slab);
  return Outcome::accepted;
}

/// Half as many elements, or one of half the length; where there is none, the equations at the entry that
/// the cross could not have tell why.
SlabMarch::Outcome SlabMarch::shorten(SlabCell& cell, const std::vector<int>& bad_entry) {
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
  const std::vector<double> borders = slab.borders;
  cell.slab.reset();
  cell.length = 0.5 * first;
  if (cell.length >= options_.least_slab * problem_.end) return Outcome::shorter;
  const IndexBatch entry = Eigen::Map<const Eigen::VectorXi>(bad_entry.data(), cell.guards.rows());
  const Eigen::MatrixXd q = coordinates_at(cell.axes, entry);
  const SlabPoints points =
      collocation_.solve(borders, values_at(cell.start, entry), q, iteration_tolerance());
  attempt_evaluations_ += points.evaluations;
  return give_up(cell, first, points, q);
}

/// Whether the state at the start of an element moves by a good part of its own size within it, as solutions
/// do close to where they end.
bool SlabMarch::moves_by_its_size(double t, const Eigen::VectorXd& start, const Eigen::VectorXd& q,
                                  double length) const {
  Eigen::MatrixXd rate;
  problem_.system->rhs(Eigen::VectorXd::Constant(1, t), scales_.cwiseProduct(start), q, rate);
  const double moved = length * rate.col(0).cwiseQuotient(scales_).cwiseAbs().maxCoeff();
  return !(moved < kOwnSize * start.cwiseAbs().maxCoeff());
}

/// At points some of which were not solved, or have gone too far.
SlabMarch::Outcome SlabMarch::give_up(const SlabCell& cell, double length, const SlabPoints& points,
                                      const Eigen::MatrixXd& q) {
  Eigen::Index worst = points.first_failed();
  const bool failed = worst >= 0;
  if (!failed) points.values.cwiseAbs().colwise().maxCoeff().maxCoeff(&worst);
  const Eigen::VectorXd start = points.values.col(worst).head(collocation_.states());
  const bool unsolved = failed &&
                        points.status[static_cast<std::size_t>(worst)] == SlabPointStatus::no_contraction &&
                        !moves_by_its_size(cell.time, start, q.col(worst), length);
  return unsolved ? end_at(cell, Termination::no_contraction, "the equations could not be solved", length,
                           q.col(worst))
                  : end_at(cell, Termination::ceases, kGrows, length, q.col(worst));
}

/// At a point that was solved, but that no polynomial follows.
SlabMarch::Outcome SlabMarch::give_up_on_time(const SlabCell& cell, double length, const Eigen::VectorXd& q) {
  const Eigen::VectorXd start = values_at(cell.start, cell.axes, q).col(0);
  return start.cwiseAbs().maxCoeff() > 1.0 && moves_by_its_size(cell.time, start, q, length)
             ? end_at(cell, Termination::ceases, kGrows, length, q)
             : end_at(cell, Termination::not_resolved, "no polynomial follows the solution", length, q);
}

SlabMarch::Outcome SlabMarch::end_at(const SlabCell& cell, Termination status, const char* what,
                                     double length, const Eigen::VectorXd& q) {
  return end(status,
             fmt::format("at t = {:.6g} and {} {} even in steps of {:.3g}", cell.time,
                         described(cell.axes, {q.begin(), q.end()}), what, length),
             q);
}

}  // namespace samara::pgd
