#include "samara/pgd/slab_march.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/nodal_approximation.h"
#include "samara/pgd/train_algebra.h"
#include "samara/pgd/train_points.h"

namespace samara::pgd {

namespace {

// The local tolerance of a slab is shared: time 0.2, the iteration 0.01, the cross 0.4, rounding 0.3.
constexpr double kTimeShare = 0.2;
constexpr double kIterationShare = 0.01;
constexpr double kCrossShare = 0.4;
constexpr double kRoundingShare = 0.3;
/// Largest over root mean square of what rounding leaves out.
constexpr double kPeak = 4.0;
/// Proposals of the next length stay this far from the one that would just do.
constexpr double kCaution = 0.9;
/// States larger than this many scales: the solution is on its way to infinity.
constexpr double kBeyond = 1e4;
/// Guard points that are asked which axis is too coarse.
constexpr std::ptrdiff_t kWorstGuards = 8;
/// Of the local tolerance, the error at nodes that is left to the cross.
constexpr double kOnGridShare = 0.7;
/// How far the tolerances of the cross and of rounding may be tightened for a slab.
constexpr double kMostStrict = 0.1;

/// Adds grid entries (modes x entries) to the right sets of every mode.
void add_pivots(CrossPivots& pivots, const IndexBatch& entries) {
  for (std::size_t k = 1; k < pivots.right.size(); ++k) {
    IndexBatch& set = pivots.right[k];
    if (set.rows() == 0) continue;
    const IndexBatch more = entries.bottomRows(set.rows());
    set.conservativeResize(Eigen::NoChange, set.cols() + more.cols());
    set.rightCols(more.cols()) = more;
  }
}

}  // namespace

SlabMarch::SlabMarch(const AdaptiveProblem& problem, const SlabOptions& options,
                     const Eigen::VectorXd& scales, double local_tolerance, long evaluations_left)
    : problem_(problem),
      options_(options),
      scales_(scales),
      tolerance_(local_tolerance),
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
  cells_to_go_.push_back(std::move(cell));
}

void SlabMarch::run() {
  attempt_begin_ = std::chrono::steady_clock::now();
  reached_ = problem_.end;
  while (!cells_to_go_.empty()) {
    // The cell that is least far goes first: where the march must end, nothing was done in vain.
    const auto first = std::min_element(cells_to_go_.begin(), cells_to_go_.end(),
                                        [](const SlabCell& a, const SlabCell& b) { return a.time < b.time; });
    if (first->time >= problem_.end) break;
    if (!may_go_on() || attempt(*first) == Outcome::ended) {
      reached_ = first->time;
      return;
    }
  }
}

bool SlabMarch::may_go_on() {
  if (evaluations_left_ >= 0 && evaluations() >= evaluations_left_) {
    status_ = SlabStatus::max_evaluations;
    message_ = fmt::format("{} evaluations used, {} allowed", evaluations(), evaluations_left_);
    return false;
  }
  double done = 0.0;
  for (const SlabCell& cell : cells_to_go_) done += cell.time;
  done /= problem_.end * static_cast<double>(cells_to_go_.size());
  const std::string stage = cells_ == 1 ? fmt::format("slab {}", history_.size() + 1)
                                        : fmt::format("slab {}, {} cells", history_.size() + 1, cells_);
  if (!options_.progress || options_.progress({stage, done})) return true;
  status_ = SlabStatus::cancelled;
  message_ = fmt::format("cancelled at t = {:.6g}", cells_to_go_.front().time);
  return false;
}

SlabMarch::Outcome SlabMarch::end(SlabStatus status, std::string message, const Eigen::VectorXd& q) {
  status_ = status;
  message_ = std::move(message);
  where_.assign(q.begin(), q.end());
  return Outcome::ended;
}

/// Solves the slab at the guard points, from the train: a polynomial in time must follow them.
SlabMarch::Outcome SlabMarch::probe(SlabCell& cell, double length, SlabPoints& solved) {
  const Eigen::MatrixXd start = values_at(cell.start, cell.axes, cell.guards);
  solved = collocation_.solve(cell.time, length, start, cell.guards, kIterationShare * tolerance_);
  attempt_evaluations_ += solved.evaluations;
  if (solved.first_failed() >= 0 || solved.values.cwiseAbs().maxCoeff() > kBeyond)
    return shorten(cell, length, 0.5, solved, cell.guards);
  const SlabTime& time = collocation_.time();
  double tail = 0.0;
  for (Eigen::Index j = 0; j < solved.values.cols(); ++j) {
    const Eigen::Map<const Eigen::MatrixXd> values(solved.values.col(j).data(), collocation_.states(),
                                                   time.points() + 1);
    tail = std::max(tail, (values * time.highest.transpose()).cwiseAbs().rowwise().sum().maxCoeff());
  }
  const double wanted = kTimeShare * tolerance_;
  const double factor = kCaution * std::pow(wanted / std::max(tail, 1e-300), 1.0 / time.points());
  if (tail > wanted) return shorten(cell, length, std::clamp(factor, 0.2, 0.9), solved, cell.guards);
  next_length_ = length * std::clamp(factor, 0.5, 2.0);
  return Outcome::accepted;
}

SlabMarch::Outcome SlabMarch::shorten(SlabCell& cell, double length, double factor, const SlabPoints& points,
                                      const Eigen::MatrixXd& q) {
  cell.length = factor * length;
  if (cell.length >= options_.least_slab * problem_.end) return Outcome::shorter;
  Eigen::Index worst = points.first_failed();
  if (worst < 0) points.values.cwiseAbs().colwise().maxCoeff().maxCoeff(&worst);
  const Eigen::VectorXd at = q.col(worst);
  const std::string place = described(cell.axes, {at.begin(), at.end()});
  const bool unsolved = points.first_failed() >= 0 &&
                        points.status[static_cast<std::size_t>(worst)] == SlabPointStatus::no_contraction;
  // Close to where a solution ends it moves by its own size within the shortest slab.
  return end(
      unsolved ? SlabStatus::no_contraction : SlabStatus::ceases,
      fmt::format("at t = {:.6g} and {} {} even in slabs of {:.3g}", cell.time, place,
                  unsolved ? "the equations could not be solved" : "the solution grows beyond all bounds",
                  length),
      at);
}

CrossResult SlabMarch::interpolate_slab(SlabCell& cell, double length, SlabPoints& totals) {
  std::vector<int> sizes = sizes_of(cell.axes);
  const EntryFunction at_entries = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
    Eigen::MatrixXd q(entries.rows(), entries.cols());
    for (Eigen::Index k = 0; k < q.rows(); ++k) {
      const Eigen::VectorXd& nodes = cell.axes[static_cast<std::size_t>(k)].nodes();
      for (Eigen::Index j = 0; j < q.cols(); ++j) q(k, j) = nodes[entries(k, j)];
    }
    SlabPoints points = collocation_.solve(cell.time, length, values_at(cell.start, entries), q,
                                           kIterationShare * tolerance_);
    totals.evaluations += points.evaluations;
    totals.iterations += points.iterations;
    totals.contraction = std::max(totals.contraction, points.contraction);
    totals.status.resize(totals.status.size() + points.status.size());
    values = std::move(points.values);
  };
  CrossOptions cross;
  cross.tolerance = cell.strictness * kCrossShare * tolerance_;
  cross.max_rank = options_.max_rank;
  cross.guard_entries = options_.guards;
  cross.max_sweeps = 8;
  cross.seed = random_.bits();
  cross.start = cell.pivots;
  return interpolate(at_entries, collocation_.states() * (options_.time_points + 1), sizes, cross);
}

/// Euclidean tolerance at which a train is rounded.
double SlabMarch::rounding(const TensorTrain& train) const {
  double entries = 1.0;
  for (const TrainCore& core : train.cores) entries *= core.size;
  return kRoundingShare / kPeak * tolerance_ * std::sqrt(entries);
}

TrainField SlabMarch::field(const SlabCell& cell, double length, const TensorTrain& train) const {
  const int states = collocation_.states();
  const int nodes = options_.time_points + 1;
  std::vector<Axis> axes = {
      Axis::radau(problem_.time, cell.time, cell.time + length, 1, options_.time_points)};
  axes.insert(axes.end(), cell.axes.begin(), cell.axes.end());
  TensorTrain split;
  split.cores.emplace_back(1, states, states);
  split.cores[0].left_unfolding() = scales_.asDiagonal();
  // The joint mode of states and time, states first, lies in memory as a core of left size states.
  const int rank = train.cores[0].right;
  split.cores.emplace_back(states, nodes, rank);
  split.cores[1].data = train.cores[0].data;
  split.cores.insert(split.cores.end(), train.cores.begin() + 1, train.cores.end());
  return {std::move(axes), problem_.states, std::move(split)};
}

SlabMarch::Outcome SlabMarch::attempt(SlabCell& cell) {
  const double left = problem_.end - cell.time;
  double length = std::min(cell.length, options_.largest_slab * problem_.end);
  // The last two slabs share what is left, so that none is a crumb.
  if (length > left)
    length = left;
  else if (length > 0.5 * left)
    length = 0.5 * left;
  SlabPoints at_guards;
  if (const Outcome outcome = probe(cell, length, at_guards); outcome != Outcome::accepted) return outcome;
  SlabPoints totals;
  CrossResult cross = interpolate_slab(cell, length, totals);
  attempt_evaluations_ += totals.evaluations;
  const auto solved = static_cast<double>(totals.status.size());
  const double iterations = static_cast<double>(totals.iterations) / std::max(1.0, solved);
  const double on_grid = cross.grid_size * iterations * options_.time_points;
  if (cross.status == CrossStatus::not_finite) {
    Eigen::MatrixXd q(cell.guards.rows(), 1);
    const std::vector<double> at = coordinates(cell.axes, cross.bad_entry);
    std::copy(at.begin(), at.end(), q.data());
    SlabPoints points = collocation_.solve(cell.time, length, values_at(cell.start, cell.axes, q), q,
                                           kIterationShare * tolerance_);
    return shorten(cell, length, 0.5, points, q);
  }
  const TensorTrain train = rounded(cross.train, cell.strictness * rounding(cross.train));
  const Eigen::VectorXd errors =
      (values_at(train, cell.axes, cell.guards) - at_guards.values).cwiseAbs().colwise().maxCoeff();
  const double error = errors.maxCoeff();
  if (!(error <= tolerance_)) {
    grid_evaluations_ += on_grid;
    const std::vector<int> ranks = train.ranks();
    const bool exhausted = *std::max_element(ranks.begin(), ranks.end()) >= options_.max_rank;
    cell.pivots = std::move(cross.pivots);
    return refine(cell, length, train, errors, exhausted);
  }
  SlabRecord record;
  record.contraction = totals.contraction;
  record.iterations = iterations;
  record.local_error = error;
  record.grid_evaluations = on_grid;
  cell.pivots = std::move(cross.pivots);
  accept(cell, length, train, std::move(record));
  return Outcome::accepted;
}

/// The errors at the worst guard points, taken apart: with all coordinates but one moved to the nearest
/// nodes, it is what only more nodes on that axis will mend; with all of them moved, what the cross or the
/// rounding has left.
SlabMarch::Blame SlabMarch::blame(const SlabCell& cell, double length, const TensorTrain& train,
                                  const Eigen::VectorXd& errors) {
  std::vector<int> order(static_cast<std::size_t>(errors.size()));
  std::iota(order.begin(), order.end(), 0);
  const auto count = std::min<std::ptrdiff_t>(kWorstGuards, errors.size());
  std::partial_sort(order.begin(), order.begin() + count, order.end(),
                    [&](int a, int b) { return errors[a] > errors[b]; });
  order.resize(static_cast<std::size_t>(count));
  const Eigen::MatrixXd worst = cell.guards(Eigen::all, order);
  const Eigen::Index axes = worst.rows();
  Blame result;
  result.entries.resize(axes, count);
  Eigen::MatrixXd snapped = worst;
  for (Eigen::Index k = 0; k < axes; ++k) {
    const Eigen::VectorXd& nodes = cell.axes[static_cast<std::size_t>(k)].nodes();
    for (Eigen::Index j = 0; j < count; ++j) {
      Eigen::Index nearest = 0;
      (nodes.array() - worst(k, j)).abs().minCoeff(&nearest);
      result.entries(k, j) = static_cast<int>(nearest);
      snapped(k, j) = nodes[nearest];
    }
  }
  Eigen::MatrixXd q = snapped.replicate(1, axes + 1);
  for (Eigen::Index k = 0; k < axes; ++k) q.block(k, k * count, 1, count) = worst.row(k);
  const SlabPoints solved = collocation_.solve(cell.time, length, values_at(cell.start, cell.axes, q), q,
                                               kIterationShare * tolerance_);
  attempt_evaluations_ += solved.evaluations;
  const Eigen::MatrixXd difference = (values_at(train, cell.axes, q) - solved.values).cwiseAbs();
  for (Eigen::Index k = 0; k <= axes; ++k) {
    const double error = difference.middleCols(k * count, count).maxCoeff();
    result.by_axis.push_back(std::isfinite(error) ? error : std::numeric_limits<double>::infinity());
  }
  result.on_grid = result.by_axis.back();
  result.by_axis.pop_back();
  return result;
}

/// More nodes on the axes that do not resolve the train, or a stricter cross where it is wrong at the nodes
/// themselves; where that is used up, two cells.
SlabMarch::Outcome SlabMarch::refine(SlabCell& cell, double length, const TensorTrain& train,
                                     const Eigen::VectorXd& errors, bool ranks) {
  const Blame found = blame(cell, length, train, errors);
  const std::vector<double>& by_axis = found.by_axis;
  if (found.on_grid > kOnGridShare * tolerance_ && cell.strictness > kMostStrict) {
    cell.strictness *= 0.3;
    add_pivots(cell.pivots, found.entries);
    return Outcome::refined;
  }
  std::vector<int> nodes = sizes_of(cell.axes);
  const auto free = [&](std::size_t k) { return !problem_.parameters[k].nodes; };
  const std::size_t coarsest =
      static_cast<std::size_t>(std::max_element(by_axis.begin(), by_axis.end()) - by_axis.begin());
  bool grown = false;
  for (std::size_t k = 0; k < nodes.size() && !ranks; ++k) {
    const bool coarse = k == coarsest || by_axis[k] > 0.5 * tolerance_;
    if (!coarse || !free(k) || nodes[k] >= options_.max_nodes) continue;
    nodes[k] = std::min(nodes[k] + std::max(2, nodes[k] / 3), options_.max_nodes);
    grown = true;
  }
  if (grown) {
    resample(cell, problem_, nodes);
    return Outcome::refined;
  }
  const Basis basis = problem_.parameters[coarsest].basis;
  if (cells_ < options_.max_cells && basis != Basis::fourier) {
    std::vector<SlabCell> parts =
        halves(cell, problem_, static_cast<int>(coarsest), options_.guards, random_);
    parts[0].number = cell.number;
    parts[1].number = cells_++;
    // `cell` is an element of the list: it becomes the first half before the second is added.
    cell = std::move(parts[0]);
    cells_to_go_.push_back(std::move(parts[1]));
    return Outcome::split;
  }
  Eigen::Index worst = 0;
  const double error = errors.maxCoeff(&worst);
  const Eigen::VectorXd at = cell.guards.col(worst);
  const std::string limit = ranks ? fmt::format("ranks up to {} do not suffice", options_.max_rank)
                                  : fmt::format("{} nodes on the axis {} do not suffice", nodes[coarsest],
                                                cell.axes[coarsest].name());
  return end(
      SlabStatus::not_resolved,
      fmt::format("neighbours part: after t = {:.6g} {}{}, the error at {} is {:.3g} of the range", cell.time,
                  limit, options_.max_cells > 1 ? fmt::format(" in {} cells", cells_) : std::string(),
                  described(cell.axes, {at.begin(), at.end()}), error),
      at);
}

void SlabMarch::accept(SlabCell& cell, double length, const TensorTrain& train, SlabRecord record) {
  const int states = collocation_.states();
  const int last = states * options_.time_points;
  // The guard points' own states go on from their own starts.
  const SlabPoints carried =
      collocation_.solve(cell.time, length, cell.carried, cell.guards, kIterationShare * tolerance_);
  attempt_evaluations_ += carried.evaluations;
  const Eigen::MatrixXd here = values_at(train, cell.axes, cell.guards);
  if (carried.first_failed() < 0) {
    cell.carried = carried.values.middleRows(last, states);
    record.carried_error = (here - carried.values).cwiseAbs().maxCoeff();
    for (Eigen::Index j = 0; j < carried.values.cols(); ++j) {
      const Eigen::Map<const Eigen::MatrixXd> values(carried.values.col(j).data(), states,
                                                     options_.time_points + 1);
      smallest_ = smallest_.cwiseMin(values.rowwise().minCoeff());
      largest_ = largest_.cwiseMax(values.rowwise().maxCoeff());
    }
  } else {
    record.carried_error = std::numeric_limits<double>::infinity();
  }
  carried_error_ = std::max(carried_error_, record.carried_error);
  pieces_.push_back({cell.number, cell.time + length, field(cell, length, train)});
  record.cell = cell.number;
  record.begin = cell.time;
  record.end = cell.time + length;
  record.nodes = sizes_of(cell.axes);
  record.ranks = pieces_.back().field.train().ranks();
  cell.start = train;
  TrainCore end_core(1, states, train.cores[0].right);
  end_core.left_unfolding() = train.cores[0].left_unfolding().bottomRows(states);
  cell.start.cores[0] = std::move(end_core);
  cell.start = rounded(std::move(cell.start), rounding(cell.start));
  const double left = problem_.end - record.end;
  cell.time = left < 1e-12 * problem_.end ? problem_.end : record.end;
  cell.length = next_length_;
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
