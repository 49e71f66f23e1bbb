#include "samara/pgd/evolution/time_stepper.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Of the local tolerance, for time.
constexpr double kShareOfTime = 0.2;
/// Proposals of the next length stay this far from the one that would just do.
constexpr double kCaution = 0.9;
/// States that are larger than at the start by this many scales belong to a solution that grows beyond all bounds.
constexpr double kBeyond = 1e4;
/// Part of its own size by which a solution moves within the shortest element where it is about to end.
constexpr double kOwnSize = 0.02;
/// Orders of convergence in time, over that of smooth solutions, that indicate a kink.
constexpr double kKinked = 0.5;
/// And lengths of elements, over the usual one.
constexpr double kShort = 0.4;
constexpr const char* kGrows = "the solution grows beyond all bounds";

Ending ending_at(const SlabCell& cell, Termination status, const std::string& what, double length,
                 const Eigen::VectorXd& q) {
  const std::vector<double> at(q.begin(), q.end());
  return {status,
          fmt::format("at t = {:.6g} and {} {} even in steps of {:.3g}", cell.time, described(cell.axes, at),
                      what, length),
          at};
}

/// Of the states at one point, SI. @param start in scales
Eigen::VectorXd rates_at(const MarchContext& context, double t, const Eigen::VectorXd& start,
                         const Eigen::VectorXd& q) {
  Eigen::MatrixXd rate;
  context.problem().system->rhs(Eigen::VectorXd::Constant(1, t), context.scales().cwiseProduct(start), q,
                                rate);
  return rate.col(0);
}

}  // namespace

/// Largest difference, at the nodes of both halves of an element, from the solution on those halves: sees
/// kinks, which the decay of the coefficients of one element does not. Infinite where a half was not solved.
TimeStepper::WorstPoint TimeStepper::error_in_time(const SlabPoints& element, double begin, double end,
                                                   const Eigen::MatrixXd& q) {
  const Eigen::Index states = context_.states();
  const SlabTime& time = context_.time();
  const SlabPoints halves =
      context_.solve({begin, 0.5 * (begin + end), end}, element.values.topRows(states), q);
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

/// By how many scales the states at every point become larger than any is at t = 0.
Eigen::RowVectorXd TimeStepper::growth_of(const Eigen::MatrixXd& values) const {
  const Eigen::VectorXd& starts = context_.start_sizes();
  const Eigen::VectorXd all_starts = starts.replicate(values.rows() / starts.size(), 1);
  return (values.cwiseAbs().colwise() - all_starts).colwise().maxCoeff();
}

bool TimeStepper::goes_too_far(const Eigen::MatrixXd& values) const {
  return growth_of(values).maxCoeff() > kBeyond;
}

std::optional<Ending> TimeStepper::probe(SlabCell& cell, const Eigen::MatrixXd& start) {
  const SlabOptions& options = context_.options();
  const double whole = context_.problem().end;
  const double least = context_.shortest();
  double slab_end = std::min(cell.time + context_.longest(), whole);
  if (whole - slab_end < least) slab_end = whole;  // what is left would be shorter than any slab
  const Eigen::Index states = context_.states();
  ProbedSlab slab;
  slab.borders = {cell.time};
  slab.values = start;
  double length = cell.length;
  struct {
    double length = 0.0, error = 0.0;
  } refused;
  // Ranks grow with the length of a slab, so that only short elements are put together. Kinks, which may err
  // by more, get slabs of their own; those too hold several elements, as each slab rounds the state anew.
  const double together = cell.time + options.joint_slab * whole;
  const auto may_grow = [&] {
    const auto elements = static_cast<int>(slab.borders.size()) - 1;
    return elements == 0 || (elements < options.max_elements && slab.end() + length <= together);
  };
  while (slab.end() < slab_end && may_grow()) {
    const double left = slab_end - slab.end();
    // The last two elements share what is left, so that none is far shorter than the other.
    const double tried = length >= left ? left : std::min(length, 0.5 * left);
    const double end = tried == left ? slab_end : slab.end() + tried;
    const SlabPoints solved = context_.solve({slab.end(), end}, slab.values.bottomRows(states), cell.guards);
    const bool failed = solved.first_failed() >= 0 || goes_too_far(solved.values);
    const WorstPoint worst = failed ? WorstPoint() : error_in_time(solved, slab.end(), end, cell.guards);
    const double error = std::max(worst.error, 1e-300);
    const auto wanted = [&] { return kShareOfTime * cell.leniency * context_.tolerance(); };
    const auto factor = [&] {
      return kCaution * std::pow(wanted() / error, 1.0 / MarchContext::kTimePoints);
    };
    const bool slow =
        refused.length > 0.0 && std::log(refused.error / error) <
                                    kKinked * MarchContext::kTimePoints * std::log(refused.length / tried);
    if (!failed && error > wanted() && cell.leniency < context_.most_lenient() &&
        (slow || tried < kShort * cell.usual_length)) {
      if (slab.borders.size() > 1) break;
      cell.leniency = context_.most_lenient();
    }
    if (failed || error > wanted()) {
      if (!failed) refused = {tried, error};
      length = tried * (failed ? 0.5 : std::clamp(factor(), 0.2, 0.9));
      if (length >= least) continue;
      if (slab.borders.size() > 1) break;  // what goes before it is a slab; the next one will end the march
      return failed ? give_up(cell, tried, solved, cell.guards)
                    : give_up_on_time(cell, tried, start.col(worst.point), cell.guards.col(worst.point));
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
  return std::nullopt;
}

bool TimeStepper::halve(SlabCell& cell) const {
  ProbedSlab& slab = *cell.slab;
  const std::size_t elements = slab.borders.size() - 1;
  if (elements == 1) {
    const double half = 0.5 * (slab.borders[1] - slab.borders[0]);
    if (half < context_.shortest()) return false;
    cell.length = half;
    cell.slab.reset();
    return true;
  }
  slab.borders.resize(elements / 2 + 1);
  const Eigen::Index nodes = static_cast<Eigen::Index>(elements / 2) * MarchContext::kTimePoints + 1;
  slab.values.conservativeResize(nodes * context_.states(), Eigen::NoChange);
  slab.next_length = slab.end() - slab.borders[elements / 2 - 1];
  return true;
}

/// Where elements cannot be shorter, the equations at the point that was not solved tell why, if it is known.
std::optional<Ending> TimeStepper::shorten(SlabCell& cell, const Ending& why) {
  if (halve(cell)) return std::nullopt;
  if (why.status != Termination::not_finite || why.where.empty()) return why;
  const std::vector<double>& borders = cell.slab->borders;
  const Eigen::MatrixXd q =
      Eigen::Map<const Eigen::VectorXd>(why.where.data(), static_cast<Eigen::Index>(why.where.size()));
  const SlabPoints points = context_.solve(borders, values_at(cell.start, cell.axes, q), q);
  const bool failed = points.first_failed() >= 0 || goes_too_far(points.values);
  return failed ? give_up(cell, borders[1] - borders[0], points, q) : why;
}

/// Whether the state at the start of an element moves by a good part of its own size within it, as solutions
/// do close to where they end.
bool TimeStepper::moves_by_its_size(double t, const Eigen::VectorXd& start, const Eigen::VectorXd& q,
                                    double length) const {
  const Eigen::VectorXd rates = rates_at(context_, t, start, q).cwiseQuotient(context_.scales());
  const double moved = length * rates.cwiseAbs().maxCoeff();
  return !(moved < kOwnSize * start.cwiseAbs().maxCoeff());
}

/// At points some of which were not solved, or have gone too far.
Ending TimeStepper::give_up(const SlabCell& cell, double length, const SlabPoints& points,
                            const Eigen::MatrixXd& q) const {
  Eigen::Index worst = points.first_failed();
  const bool failed = worst >= 0;
  if (!failed) growth_of(points.values).maxCoeff(&worst);
  const Eigen::VectorXd start = points.values.col(worst).head(context_.states());
  const Eigen::VectorXd rates = rates_at(context_, cell.time, start, q.col(worst));
  if (const auto bad = std::ranges::find_if_not(rates, [](double rate) { return std::isfinite(rate); });
      bad != rates.end()) {
    const auto state = static_cast<std::size_t>(bad - rates.begin());
    return ending_at(cell, Termination::not_finite,
                     fmt::format("the right-hand side is not finite (the rate of \"{}\" is {})",
                                 context_.problem().states[state].name, *bad),
                     length, q.col(worst));
  }
  const bool unsolved = failed &&
                        points.status[static_cast<std::size_t>(worst)] == Termination::no_contraction &&
                        !moves_by_its_size(cell.time, start, q.col(worst), length);
  return unsolved ? ending_at(cell, Termination::no_contraction, "the equations could not be solved", length,
                              q.col(worst))
                  : ending_at(cell, Termination::ceases, kGrows, length, q.col(worst));
}

/// At a point that was solved, but that no polynomial follows.
Ending TimeStepper::give_up_on_time(const SlabCell& cell, double length, const Eigen::VectorXd& start,
                                    const Eigen::VectorXd& q) const {
  return start.cwiseAbs().maxCoeff() > 1.0 && moves_by_its_size(cell.time, start, q, length)
             ? ending_at(cell, Termination::ceases, kGrows, length, q)
             : ending_at(cell, Termination::not_resolved, "no polynomial follows the solution", length, q);
}

}  // namespace samara::pgd
