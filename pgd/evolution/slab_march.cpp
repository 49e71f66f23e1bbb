#include "samara/pgd/evolution/slab_march.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/slab_refiner.h"
#include "samara/pgd/evolution/slab_train.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// The usual length follows those of slabs with kinks so slowly.
constexpr double kForget = 0.9;
/// Where slabs had to be shortened for the solver, the next one is at most so much longer than the last.
constexpr double kSlowGrowth = 1.3;

}  // namespace

SlabMarch::SlabMarch(const AdaptiveProblem& problem, const SlabOptions& options, SlabSolver& solver,
                     const Eigen::VectorXd& scales, LocalTolerance tolerance, long evaluations_before)
    : solver_(solver),
      context_(problem, options, solver, scales, tolerance),
      stepper_(context_),
      refiner_(context_),
      evaluations_before_(evaluations_before) {
  state_.random = Random(options.seed);
  std::vector<int> nodes;
  for (const AdaptiveAxis& axis : problem.parameters)
    nodes.push_back(axis.nodes.value_or(options.first_nodes));
  SlabCell cell = whole_box(problem, scales, nodes, options.guards, state_.random);
  cell.length = context_.longest();
  state_.smallest = cell.carried.rowwise().minCoeff();
  state_.largest = cell.carried.rowwise().maxCoeff();
  state_.cells.push_back(std::move(cell));
}

void SlabMarch::run(const std::function<void()>& between_slabs) {
  attempt_begin_ = std::chrono::steady_clock::now();
  reached_ = context_.problem().end;
  // The cell that is least far goes first: where the march must end, nothing was done in vain.
  const auto first = [this]() -> SlabCell& {
    return *std::min_element(state_.cells.begin(), state_.cells.end(),
                             [](const SlabCell& a, const SlabCell& b) { return a.time < b.time; });
  };
  while (first().time < context_.problem().end) {
    const std::size_t done = state_.history.size();
    ending_ = reason_to_stop(first());
    if (!ending_) ending_ = attempt(first());
    if (ending_) {
      reached_ = first().time;
      return;
    }
    if (state_.history.size() > done && between_slabs) between_slabs();
  }
}

std::optional<Ending> SlabMarch::reason_to_stop(const SlabCell& first) {
  const long most = context_.options().max_evaluations;
  if (most > 0 && evaluations_before_ + evaluations() >= most) return out_of_evaluations(first);
  double done = 0.0;
  for (const SlabCell& cell : state_.cells) done += cell.time;
  done /= context_.problem().end * cells();
  const std::size_t slab = state_.history.size() + 1;
  const std::string stage =
      cells() == 1 ? fmt::format("slab {}", slab) : fmt::format("slab {}, {} cells", slab, cells());
  if (!context_.is_cancelled(Progress{stage, done})) return std::nullopt;
  return Ending{Termination::cancelled, fmt::format("cancelled at t = {:.6g}", first.time)};
}

/// Says where the march stands, and what it took there last.
Ending SlabMarch::out_of_evaluations(const SlabCell& cell) const {
  Eigen::VectorXd middle(static_cast<Eigen::Index>(cell.axes.size()));
  for (std::size_t k = 0; k < cell.axes.size(); ++k)
    middle[static_cast<Eigen::Index>(k)] = 0.5 * (cell.axes[k].lower() + cell.axes[k].upper());
  std::string last;
  const auto record = std::find_if(state_.history.rbegin(), state_.history.rend(),
                                   [&](const SlabRecord& r) { return r.cell == cell.number; });
  if (record != state_.history.rend()) {
    last = fmt::format("; the last slab there, of {:.3g}, took {} of them and ranks up to {}",
                       record->end - record->begin, record->evaluations,
                       *std::max_element(record->ranks.begin(), record->ranks.end()));
  }
  return {Termination::max_calls,
          fmt::format("{} evaluations used, {} allowed, at t = {:.6g} in {} about {}{}",
                      evaluations_before_ + evaluations(), context_.options().max_evaluations, cell.time,
                      cells() == 1 ? std::string("the box") : fmt::format("one of {} cells,", cells()),
                      described(cell.axes, {middle.begin(), middle.end()}), last),
          {middle.begin(), middle.end()}};
}

std::optional<Ending> SlabMarch::attempt(SlabCell& cell) {
  if (!cell.slab) {
    const Eigen::MatrixXd starts = starts_at(cell, context_.problem(), context_.scales(), cell.guards);
    if (std::optional<Ending> ending = stepper_.probe(cell, starts)) return ending;
  }
  const Outcome<SolvedSlab> solved = solver_.solve(context_, cell, state_.random);
  if (!solved) return shorten(cell, solved.ending());
  state_.grid_evaluations += solved->grid_evaluations;
  const TensorTrain& train = solved->train;
  const Eigen::VectorXd errors =
      (values_at(train, cell.axes, cell.guards) - cell.slab->values).cwiseAbs().colwise().maxCoeff();
  if (!(errors.maxCoeff() <= cell.leniency * context_.tolerance())) {
    Outcome<Refinement> refinement = refine(cell, train, errors);
    if (!refinement) return refinement.ending();
    if (*refinement != Refinement::none) return std::nullopt;
    ++state_.left;
  } else {
    cell.rate_of_error = 0.0;
  }
  accept(cell, *solved, errors.maxCoeff());
  return std::nullopt;
}

/// What the solver cannot do on a slab it may do on a shorter one; but for a caller who wants no more.
std::optional<Ending> SlabMarch::shorten(SlabCell& cell, const Ending& why) {
  if (why.status == Termination::cancelled || why.status == Termination::max_calls) return why;
  cell.grows_slowly = cell.grows_slowly || solver_.max_elements() == 1;
  return stepper_.shorten(cell, why);
}

Outcome<Refinement> SlabMarch::refine(SlabCell& cell, const TensorTrain& train,
                                      const Eigen::VectorXd& errors) {
  const std::vector<int> ranks = train.ranks();
  const bool exhausted = *std::max_element(ranks.begin(), ranks.end()) >= context_.options().max_rank;
  const Outcome<Refinement> refinement = refiner_.refine(cell, train, errors, exhausted, cells());
  if (refinement && *refinement == Refinement::halves) split(cell);
  if (refinement && *refinement == Refinement::shorter) {
    cell.grows_slowly = true;
    stepper_.halve(cell);
  }
  return refinement;
}

void SlabMarch::split(SlabCell& cell) {
  std::vector<SlabCell> parts = refiner_.halves(cell, state_.random);
  parts[0].number = cell.number;
  parts[1].number = cells();
  // `cell` is an element of the list: it becomes the first half before the second is added.
  cell = std::move(parts[0]);
  state_.cells.push_back(std::move(parts[1]));
}

/// The guard points' own states go on from their own starts, in elements of half the length: the difference
/// is the error of the march so far, at the ends of the elements, that of time included. A point whose own
/// equations were not solved is left out from there on; the error is infinite.
double SlabMarch::carry_on(SlabCell& cell, const TensorTrain& train) {
  const Eigen::Index states = context_.states();
  const std::vector<double>& borders = cell.slab->borders;
  std::vector<double> halved = {borders.front()};
  for (std::size_t e = 1; e < borders.size(); ++e) {
    halved.push_back(0.5 * (borders[e - 1] + borders[e]));
    halved.push_back(borders[e]);
  }
  std::vector<int> sound;
  for (Eigen::Index j = 0; j < cell.guards.cols(); ++j) {
    if (cell.carried.col(j).allFinite()) sound.push_back(static_cast<int>(j));
  }
  const SlabPoints carried =
      context_.solve(halved, cell.carried(Eigen::all, sound), cell.guards(Eigen::all, sound));
  cell.carried(Eigen::all, sound) = carried.values.bottomRows(states);
  const Eigen::MatrixXd here = values_at(train, cell.axes, cell.guards(Eigen::all, sound));
  const Eigen::Index element = states * MarchContext::kTimePoints;
  double error = 0.0;
  for (Eigen::Index j = 0; j < carried.values.cols(); ++j) {
    if (carried.status[static_cast<std::size_t>(j)] != Termination::converged) {
      error = std::numeric_limits<double>::infinity();
      continue;
    }
    for (Eigen::Index e = 0; e < static_cast<Eigen::Index>(borders.size()); ++e) {
      const auto own = carried.values.col(j).segment(2 * e * element, states);
      error = std::max(error, (here.col(j).segment(e * element, states) - own).cwiseAbs().maxCoeff());
    }
    const auto values = carried.values.col(j).reshaped(states, carried.values.rows() / states);
    state_.smallest = state_.smallest.cwiseMin(values.rowwise().minCoeff());
    state_.largest = state_.largest.cwiseMax(values.rowwise().maxCoeff());
  }
  return error;
}

void SlabMarch::accept(SlabCell& cell, const SolvedSlab& solved, double error) {
  const AdaptiveProblem& problem = context_.problem();
  const TensorTrain& train = solved.train;
  SlabRecord record;
  record.contraction = solved.contraction;
  record.iterations = solved.iterations;
  record.grid_evaluations = solved.grid_evaluations;
  record.local_error = error;
  record.carried_error = carry_on(cell, train);
  state_.carried_error = std::max(state_.carried_error, record.carried_error);
  const Axis time = slab_axis(problem, cell.slab->borders);
  state_.pieces.push_back(
      {cell.number, cell.slab->end(), slab_field(time, cell.axes, problem.states, context_.scales(), train)});
  record.cell = cell.number;
  record.begin = cell.time;
  record.end = cell.slab->end();
  record.elements = static_cast<int>(cell.slab->borders.size()) - 1;
  record.nodes = sizes_of(cell.axes);
  record.ranks = state_.pieces.back().field.train().ranks();
  cell.start = last_rows(train, context_.states());
  cell.start = rounded(std::move(cell.start), context_.rounding(cell, cell.start));
  cell.time = record.end;
  cell.length = cell.slab->next_length;
  if (cell.grows_slowly) cell.length = std::min(cell.length, kSlowGrowth * (record.end - record.begin));
  cell.slab.reset();
  cell.usual_length = cell.leniency < context_.most_lenient() ? (record.end - record.begin) / record.elements
                                                              : kForget * cell.usual_length;
  cell.leniency = 1.0;
  cell.strictness = std::min(1.0, 2.0 * cell.strictness);
  record.evaluations = context_.take_evaluations();
  state_.evaluations += record.evaluations;
  const auto now = std::chrono::steady_clock::now();
  record.seconds = std::chrono::duration<double>(now - attempt_begin_).count();
  attempt_begin_ = now;
  state_.history.push_back(std::move(record));
}

std::vector<double> SlabMarch::state() {
  return archived(state_, context_.problem(), context_.options());
}

void SlabMarch::restore(std::span<const double> state) {
  state_ = restored(state, context_.problem(), context_.options());
}

}  // namespace samara::pgd
