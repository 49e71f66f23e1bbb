#include "samara/pgd/evolution/slab_march.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/slab_train.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

// Of the local tolerance, for the cross and for rounding; time has 0.2, the iteration 0.01.
constexpr double kCrossShare = 0.4;
constexpr double kRoundingShare = 0.3;
/// Largest over root mean square of what rounding leaves out.
constexpr double kPeak = 4.0;
/// The usual length follows those of slabs with kinks so slowly.
constexpr double kForget = 0.9;

}  // namespace

SlabMarch::SlabMarch(const AdaptiveProblem& problem, const SlabOptions& options,
                     const Eigen::VectorXd& scales, LocalTolerance tolerance, long evaluations_left)
    : problem_(problem),
      options_(options),
      scales_(scales),
      tolerance_(tolerance.wanted),
      most_lenient_(std::max(1.0, tolerance.largest / tolerance.wanted)),
      evaluations_left_(evaluations_left),
      collocation_(*problem.system, scales, options.time_points),
      random_(options.seed) {
  std::vector<int> nodes;
  for (const AdaptiveAxis& axis : problem.parameters)
    nodes.push_back(axis.nodes.value_or(options.first_nodes));
  SlabCell cell = whole_box(problem, scales, nodes, options.guards, random_);
  cell.length = options.largest_slab * problem.end;
  smallest_ = cell.carried.rowwise().minCoeff();
  largest_ = cell.carried.rowwise().maxCoeff();
  cells_.push_back(std::move(cell));
}

void SlabMarch::run(const std::function<void()>& between_slabs) {
  attempt_begin_ = std::chrono::steady_clock::now();
  reached_ = problem_.end;
  // The cell that is least far goes first: where the march must end, nothing was done in vain.
  const auto first = [this]() -> SlabCell& {
    return *std::min_element(cells_.begin(), cells_.end(),
                             [](const SlabCell& a, const SlabCell& b) { return a.time < b.time; });
  };
  while (first().time < problem_.end) {
    const Outcome outcome = may_go_on(first()) ? attempt(first()) : Outcome::ended;
    if (outcome == Outcome::ended) {
      reached_ = first().time;
      return;
    }
    if (outcome == Outcome::accepted && between_slabs) between_slabs();
  }
}

bool SlabMarch::may_go_on(const SlabCell& first) {
  if (evaluations_left_ >= 0 && evaluations() >= evaluations_left_) {
    out_of_evaluations(first);
    return false;
  }
  double done = 0.0;
  for (const SlabCell& cell : cells_) done += cell.time;
  done /= problem_.end * cells();
  const std::string stage = cells() == 1 ? fmt::format("slab {}", history_.size() + 1)
                                         : fmt::format("slab {}, {} cells", history_.size() + 1, cells());
  if (!options_.progress || options_.progress({stage, done})) return true;
  status_ = Termination::cancelled;
  message_ = fmt::format("cancelled at t = {:.6g}", first.time);
  return false;
}

/// Says where the march stands, and what it took there last.
void SlabMarch::out_of_evaluations(const SlabCell& cell) {
  Eigen::VectorXd middle(static_cast<Eigen::Index>(cell.axes.size()));
  for (std::size_t k = 0; k < cell.axes.size(); ++k)
    middle[static_cast<Eigen::Index>(k)] = 0.5 * (cell.axes[k].lower() + cell.axes[k].upper());
  std::string last;
  const auto record = std::find_if(history_.rbegin(), history_.rend(),
                                   [&](const SlabRecord& r) { return r.cell == cell.number; });
  if (record != history_.rend()) {
    last = fmt::format("; the last slab there, of {:.3g}, took {} of them and ranks up to {}",
                       record->end - record->begin, record->evaluations,
                       *std::max_element(record->ranks.begin(), record->ranks.end()));
  }
  end(Termination::max_calls,
      fmt::format("{} evaluations used, {} allowed, at t = {:.6g} in {} about {}{}", evaluations(),
                  evaluations_left_, cell.time,
                  cells() == 1 ? std::string("the box") : fmt::format("one of {} cells,", cells()),
                  described(cell.axes, {middle.begin(), middle.end()}), last),
      middle);
}

SlabMarch::Outcome SlabMarch::end(Termination status, std::string message, const Eigen::VectorXd& q) {
  status_ = status;
  message_ = std::move(message);
  where_.assign(q.begin(), q.end());
  return Outcome::ended;
}

CrossResult SlabMarch::interpolate_slab(SlabCell& cell, Totals& totals) {
  std::vector<int> sizes = sizes_of(cell.axes);
  const EntryFunction at_entries = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
    SlabPoints points = collocation_.solve(cell.slab->borders, values_at(cell.start, entries),
                                           coordinates_at(cell.axes, entries), iteration_tolerance());
    totals.entries += entries.cols();
    totals.evaluations += points.evaluations;
    totals.iterations += points.iterations;
    totals.contraction = std::max(totals.contraction, points.contraction);
    values = std::move(points.values);
  };
  CrossOptions cross;
  cross.tolerance = cell.strictness * cell.leniency * kCrossShare * tolerance_;
  cross.max_rank = options_.max_rank;
  cross.guard_entries = options_.guards;
  cross.max_sweeps = 8;
  cross.seed = random_.bits();
  cross.start = cell.pivots;
  return interpolate(at_entries, static_cast<int>(cell.slab->values.rows()), sizes, cross);
}

/// Euclidean tolerance at which a train is rounded.
double SlabMarch::rounding(const SlabCell& cell, const TensorTrain& train) const {
  return kRoundingShare / kPeak * cell.leniency * tolerance_ * std::sqrt(full_size(train));
}

Axis SlabMarch::time_axis(const std::vector<double>& borders) const {
  return Axis::radau(
      problem_.time,
      Eigen::Map<const Eigen::VectorXd>(borders.data(), static_cast<Eigen::Index>(borders.size())),
      options_.time_points);
}

SlabMarch::Outcome SlabMarch::attempt(SlabCell& cell) {
  if (!cell.slab) {
    if (const Outcome outcome = probe(cell); outcome != Outcome::accepted) return outcome;
  }
  Totals totals;
  CrossResult cross = interpolate_slab(cell, totals);
  attempt_evaluations_ += totals.evaluations;
  if (cross.status == CrossStatus::not_finite) return shorten(cell, cross.bad_entry);
  const double iterations =
      static_cast<double>(totals.iterations) / static_cast<double>(std::max(1L, totals.entries));
  const double on_grid = cross.grid_size * iterations * options_.time_points;
  const TensorTrain train = rounded(cross.train, cell.strictness * rounding(cell, cross.train));
  const Eigen::VectorXd errors =
      (values_at(train, cell.axes, cell.guards) - cell.slab->values).cwiseAbs().colwise().maxCoeff();
  const double error = errors.maxCoeff();
  if (!(error <= cell.leniency * tolerance_)) {
    grid_evaluations_ += on_grid;
    const std::vector<int> ranks = train.ranks();
    const bool exhausted = *std::max_element(ranks.begin(), ranks.end()) >= options_.max_rank;
    cell.pivots = std::move(cross.pivots);
    return refine(cell, train, errors, exhausted);
  }
  SlabRecord record;
  record.contraction = totals.contraction;
  record.iterations = iterations;
  record.local_error = error;
  record.grid_evaluations = on_grid;
  cell.pivots = std::move(cross.pivots);
  accept(cell, train, std::move(record));
  return Outcome::accepted;
}

/// The guard points' own states go on from their own starts, in elements of half the length: the difference
/// is the error of the march so far, at the ends of the elements, that of time included. A point whose own
/// equations were not solved is left out from there on; the error is infinite.
double SlabMarch::carry_on(SlabCell& cell, const TensorTrain& train) {
  const Eigen::Index states = collocation_.states();
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
  const SlabPoints carried = collocation_.solve(halved, cell.carried(Eigen::all, sound),
                                                cell.guards(Eigen::all, sound), iteration_tolerance());
  attempt_evaluations_ += carried.evaluations;
  cell.carried(Eigen::all, sound) = carried.values.bottomRows(states);
  const Eigen::MatrixXd here = values_at(train, cell.axes, cell.guards(Eigen::all, sound));
  const Eigen::Index element = states * options_.time_points;
  double error = 0.0;
  for (Eigen::Index j = 0; j < carried.values.cols(); ++j) {
    if (carried.status[static_cast<std::size_t>(j)] != SlabPointStatus::solved) {
      error = std::numeric_limits<double>::infinity();
      continue;
    }
    for (Eigen::Index e = 0; e < static_cast<Eigen::Index>(borders.size()); ++e) {
      const auto own = carried.values.col(j).segment(2 * e * element, states);
      error = std::max(error, (here.col(j).segment(e * element, states) - own).cwiseAbs().maxCoeff());
    }
    const auto values = carried.values.col(j).reshaped(states, carried.values.rows() / states);
    smallest_ = smallest_.cwiseMin(values.rowwise().minCoeff());
    largest_ = largest_.cwiseMax(values.rowwise().maxCoeff());
  }
  return error;
}

void SlabMarch::accept(SlabCell& cell, const TensorTrain& train, SlabRecord record) {
  const int states = collocation_.states();
  record.carried_error = carry_on(cell, train);
  carried_error_ = std::max(carried_error_, record.carried_error);
  pieces_.push_back({cell.number, cell.slab->end(),
                     slab_field(time_axis(cell.slab->borders), cell.axes, problem_.states, scales_, train)});
  record.cell = cell.number;
  record.begin = cell.time;
  record.end = cell.slab->end();
  record.elements = static_cast<int>(cell.slab->borders.size()) - 1;
  record.nodes = sizes_of(cell.axes);
  record.ranks = pieces_.back().field.train().ranks();
  cell.start = last_rows(train, states);
  cell.start = rounded(std::move(cell.start), rounding(cell, cell.start));
  cell.time = record.end;
  cell.length = cell.slab->next_length;
  cell.slab.reset();
  cell.usual_length = cell.leniency < most_lenient_ ? (record.end - record.begin) / record.elements
                                                    : kForget * cell.usual_length;
  cell.leniency = 1.0;
  cell.strictness = std::min(1.0, 2.0 * cell.strictness);
  record.evaluations = std::exchange(attempt_evaluations_, 0);
  evaluations_ += record.evaluations;
  grid_evaluations_ += record.grid_evaluations;
  const auto now = std::chrono::steady_clock::now();
  record.seconds = std::chrono::duration<double>(now - attempt_begin_).count();
  attempt_begin_ = now;
  history_.push_back(std::move(record));
}

}  // namespace samara::pgd
