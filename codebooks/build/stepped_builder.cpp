#include "samara/codebooks/build/stepped_builder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/codebooks/build/stepped_trajectories.h"
#include "samara/codebooks/build/time_mesh.h"
#include "samara/codebooks/source/sampled_source.h"
#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/cross/max_volume.h"
#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/fields/field_rounding.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::codebooks {

namespace {

using Eigen::Index;

// Shares of the plan's tolerance.
constexpr double kShareOfStep = 0.05;
constexpr double kShareOfMesh = 0.1;
constexpr double kShareOfNodes = 0.1;
constexpr double kShareOfSkeleton = 0.02;
constexpr double kShareOfCross = 0.25;
/// What fresh points off the grid must show: two thousand do not see the largest error of all.
constexpr double kFreshMargin = 0.6;
constexpr double kShareOfRounding = 0.1;

constexpr int kPilots = 64;
constexpr int kCheckPoints = 2000;
constexpr int kMaxNodes = 128;
constexpr int kMaxRank = 400;

/// Half of the points in corners of the box, half inside.
Eigen::MatrixXd corners_and_inside(const Plan& plan, int count, pgd::Random& random) {
  Eigen::MatrixXd points(static_cast<Index>(plan.box.size()), count);
  for (Index j = 0; j < points.cols(); ++j) {
    for (Index k = 0; k < points.rows(); ++k) {
      const BoxEntry& entry = plan.box[static_cast<std::size_t>(k)];
      const double share = 2 * j < points.cols() ? random.below(2) : random.uniform();
      points(k, j) = entry.lower + (entry.upper - entry.lower) * share;
    }
  }
  return points;
}

/// From values at `count` Chebyshev-Lobatto points to the sizes of coefficients: rows are coefficients.
Eigen::MatrixXd chebyshev_transform(int count) {
  const int degree = count - 1;
  const auto end = [&](int i) { return i == 0 || i == degree ? 0.5 : 1.0; };
  Eigen::MatrixXd transform(count, count);
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < count; ++i) {
      transform(j, i) =
          2.0 / degree * end(i) * end(j) * std::cos(std::numbers::pi * (i * j % (2 * degree)) / degree);
    }
  }
  return transform;
}

class SteppedBuild {
 public:
  SteppedBuild(const Plan& plan, const models::ParametricModel& model, long max_calls,
               const ProgressCallback& progress, const CertifyClaim& certify_claim)
      : plan_(plan),
        source_(model_source(plan, model)),
        certify_claim_(certify_claim),
        trajectories_(model, plan.end / kFirstSteps, plan.builder.threads, max_calls, progress),
        random_(plan.builder.seed),
        max_rank_(plan.builder.max_rank.value_or(kMaxRank)),
        max_nodes_(std::min(plan.builder.max_nodes.value_or(kMaxNodes), kMostLine)) {
    record_.builder = "sampling";
    record_.strategy = "steps";
  }

  Outcome<Solution> run() {
    try {
      choose_step();
      choose_times();
      find_decay();
      approximate_until_met();
    } catch (const SteppedEnd& end) {
      record_.status = end.ending.status;
      record_.message = end.ending.message;
      if (!field_) return end.ending;
    }
    return solution();
  }

 private:
  static constexpr int kFirstSteps = 32;
  static constexpr int kMostLine = 129;

  Index states() const { return static_cast<Index>(source_.outputs.size()); }
  Index coordinates() const { return static_cast<Index>(plan_.box.size()); }

  /// All states at the times, a column per point, over their scales.
  Eigen::MatrixXd scaled_values(const Eigen::MatrixXd& points, const std::vector<double>& times) {
    Eigen::MatrixXd values = trajectories_(points, times);
    values.reshaped(states(), values.size() / states()).array().colwise() /= scale_.array();
    return values;
  }

  /// The finer of two steps is kept. What it errs by follows from how fast differences fall: in the fourth order where
  /// f is smooth, slower at kinks.
  void choose_step() {
    constexpr int kMostHalvings = 8;
    constexpr double kFourthOrder = 16.0;
    trajectories_.tell("pilots", 0.0);
    pilots_ = corners_and_inside(plan_, kPilots, random_);
    std::vector<double> times;
    for (int i = 0; i <= kFirstSteps; ++i) times.push_back(plan_.end * i / kFirstSteps);
    Eigen::MatrixXd coarse = trajectories_(pilots_, times);
    double before = 0.0;
    for (int halvings = 1;; ++halvings) {
      trajectories_.halve_step();
      const Eigen::MatrixXd fine = trajectories_(pilots_, times);
      const double difference = largest_difference(fine, coarse);
      const double falls = std::min(before / difference, kFourthOrder);
      const double error = falls > 2.0 ? difference / (falls - 1.0) : difference;
      if (error <= kShareOfStep * plan_.relative) return;
      if (halvings == kMostHalvings) {
        throw SteppedEnd(
            {Termination::not_resolved,
             fmt::format("Runge-Kutta steps of {:.3g} s still err by {:.3g}", trajectories_.step(), error)});
      }
      coarse = fine;
      before = difference;
    }
  }

  /// Over the ranges of the states.
  double largest_difference(const Eigen::MatrixXd& fine, const Eigen::MatrixXd& coarse) const {
    const auto by_state = fine.reshaped(states(), fine.size() / states());
    const Eigen::VectorXd difference =
        (by_state - coarse.reshaped(states(), coarse.size() / states())).cwiseAbs().rowwise().maxCoeff();
    const Eigen::VectorXd range = by_state.rowwise().maxCoeff() - by_state.rowwise().minCoeff();
    double largest = 0.0;
    for (Index s = 0; s < states(); ++s) {
      if (difference[s] > 0.0) largest = std::max(largest, difference[s] / std::max(range[s], floor_of(s)));
    }
    return largest;
  }

  double floor_of(Index state) const {
    const auto floor = plan_.absolute.find(source_.outputs[static_cast<std::size_t>(state)].name);
    return floor == plan_.absolute.end() ? 0.0 : floor->second;
  }

  void choose_times() {
    const PilotTrajectories pilots =
        [&](const std::vector<double>& times) -> Outcome<std::vector<Eigen::MatrixXd>> {
      const Eigen::MatrixXd values = trajectories_(pilots_, times);
      std::vector<Eigen::MatrixXd> trajectories;
      for (Index j = 0; j < values.cols(); ++j)
        trajectories.push_back(values.col(j).reshaped(states(), values.rows() / states()).transpose());
      return trajectories;
    };
    TimeMeshOptions options;
    options.tolerance = kShareOfMesh * plan_.relative;
    options.floors.resize(states());
    for (Index s = 0; s < states(); ++s) options.floors[s] = floor_of(s);
    Outcome<TimeMesh> mesh =
        mesh_time({"t", source_.time_unit, pgd::AxisRole::time}, plan_.end, pilots, options);
    if (!mesh) throw SteppedEnd(mesh.ending());
    mesh_.emplace(std::move(*mesh));
    scale_ = mesh_->scale;
    times_.assign(mesh_->axis.nodes().begin(), mesh_->axis.nodes().end());
    if (mesh_->resolved) return;
    throw SteppedEnd({Termination::not_resolved,
                      fmt::format("{} elements of time do not follow the motion", mesh_->axis.elements())});
  }

  pgd::Axis axis_of(Index coordinate, int nodes) const {
    const BoxEntry& entry = plan_.box[static_cast<std::size_t>(coordinate)];
    return pgd::Axis::chebyshev(source_.coordinates[static_cast<std::size_t>(coordinate)], entry.lower,
                                entry.upper, nodes);
  }

  /// Per coordinate, what the coefficients from each number on sum to: the error of so many nodes, along the worst
  /// of some lines.
  void find_decay() {
    for (Index k = 0; k < coordinates(); ++k) {
      trajectories_.tell("lines", static_cast<double>(k) / static_cast<double>(coordinates()));
      const Eigen::MatrixXd bases = corners_and_inside(plan_, kLines, random_);
      Eigen::VectorXd tail;
      for (int count = 9; count <= kMostLine; count = 2 * count - 1) {
        tail = tail_along(k, bases, count);
        if (nodes_for(tail, 0.1 * kShareOfNodes * plan_.relative) < count - 1) break;
        if (count >= max_nodes_) break;
      }
      tails_.push_back(std::move(tail));
    }
  }

  static constexpr int kLines = 32;

  Eigen::VectorXd tail_along(Index coordinate, const Eigen::MatrixXd& bases, int count) {
    const Eigen::VectorXd nodes = axis_of(coordinate, count).nodes();
    const Eigen::MatrixXd transform = chebyshev_transform(count);
    Eigen::VectorXd tail = Eigen::VectorXd::Zero(count);
    constexpr Index kTogether = 8;
    for (Index first = 0; first < bases.cols(); first += kTogether) {
      Eigen::MatrixXd points(coordinates(), kTogether * count);
      for (Index line = 0; line < kTogether; ++line) {
        points.middleCols(line * count, count) = bases.col(first + line).replicate(1, count);
        points.block(coordinate, line * count, 1, count) = nodes.transpose();
      }
      const Eigen::MatrixXd values = scaled_values(points, times_);
      for (Index line = 0; line < kTogether; ++line) {
        Eigen::MatrixXd coefficients =
            (values.middleCols(line * count, count) * transform.transpose()).cwiseAbs();
        for (Index j = count - 1; j > 0; --j) coefficients.col(j - 1) += coefficients.col(j);
        tail = tail.cwiseMax(coefficients.colwise().maxCoeff().transpose());
      }
    }
    return tail;
  }

  /// The fewest nodes behind which less than `bound` is left.
  static int nodes_for(const Eigen::VectorXd& tail, double bound) {
    int nodes = 2;
    while (nodes < tail.size() && tail[nodes] > bound) ++nodes;
    return nodes;
  }

  std::vector<int> nodes_within(double bound) const {
    std::vector<int> nodes;
    for (const Eigen::VectorXd& tail : tails_)
      nodes.push_back(std::clamp(nodes_for(tail, bound), 2, std::max(2, max_nodes_)));
    return nodes;
  }

  /// States at times, between which those of all others are interpolated, over any point of the box.
  struct Skeleton {
    std::vector<int> rows;         ///< of a trajectory
    Eigen::MatrixXd coefficients;  ///< (states x times) x rows
    std::vector<double> times;     ///< those that occur
    std::vector<Index> places;     ///< of the rows in trajectories at these times
  };

  Skeleton find_skeleton(double bound) {
    constexpr int kFewest = 400, kMost = 6400;
    for (int count = kFewest;; count *= 2) {
      const Eigen::MatrixXd values = scaled_values(corners_and_inside(plan_, count, random_), times_);
      pgd::MaxVolume volume = pgd::max_volume(values, std::min(count, 4 * max_rank_), bound);
      const auto found = static_cast<int>(volume.rows.size());
      if (3 * found > count && count < kMost) continue;
      Skeleton skeleton{std::move(volume.rows), std::move(volume.coefficients), {}, {}};
      std::vector<Index> used;
      for (const int row : skeleton.rows) used.push_back(row / states());
      std::ranges::sort(used);
      used.erase(std::unique(used.begin(), used.end()), used.end());
      for (const Index time : used) skeleton.times.push_back(times_[static_cast<std::size_t>(time)]);
      for (const int row : skeleton.rows) {
        const auto time = std::ranges::lower_bound(used, row / states()) - used.begin();
        skeleton.places.push_back(row % states() + states() * time);
      }
      return skeleton;
    }
  }

  /// The train of all states at all times over the grid, by crosses whose guards err by at most `tolerance`.
  pgd::CrossResult interpolate(const std::vector<int>& nodes, const Skeleton& skeleton, double tolerance) {
    std::vector<pgd::Axis> axes;
    for (Index k = 0; k < coordinates(); ++k) axes.push_back(axis_of(k, nodes[static_cast<std::size_t>(k)]));
    const pgd::EntryFunction at_entries = [&](const pgd::IndexBatch& entries, Eigen::MatrixXd& values) {
      values = scaled_values(pgd::coordinates_at(axes, entries), skeleton.times)(skeleton.places, Eigen::all);
    };
    pgd::CrossOptions options;
    options.tolerance = tolerance;
    options.max_rank = max_rank_;
    options.max_sweeps = 8;
    options.guard_entries = plan_.builder.guards.value_or(500);
    options.first_pivots = 50;
    options.growth = 1.0;
    options.seed = random_.bits();
    if (!nodes_.empty()) options.start = pgd::carried_over(pivots_, nodes_, nodes);
    const auto rows = static_cast<int>(skeleton.rows.size());
    pgd::CrossResult cross = pgd::interpolate(at_entries, rows, nodes, options);
    pgd::TrainCore first(1, static_cast<int>(skeleton.coefficients.rows()), rows);
    first.left_unfolding() = skeleton.coefficients;
    cross.train.cores[0] = std::move(first);
    pivots_ = cross.pivots;
    nodes_ = nodes;
    axes_ = std::move(axes);
    return cross;
  }

  /// Largest error at fresh points, off the grid, of all states at all times.
  double error_of(const pgd::TensorTrain& train) {
    Eigen::MatrixXd points(coordinates(), kCheckPoints);
    for (double& share : points.reshaped()) share = random_.uniform();
    for (Index k = 0; k < coordinates(); ++k) {
      const BoxEntry& entry = plan_.box[static_cast<std::size_t>(k)];
      points.row(k) = (entry.lower + (entry.upper - entry.lower) * points.row(k).array()).matrix();
    }
    double largest = 0.0;
    constexpr Index kTogether = 500;
    for (Index first = 0; first < points.cols(); first += kTogether) {
      const Eigen::MatrixXd some = points.middleCols(first, kTogether);
      const Eigen::MatrixXd error = pgd::many_values_at(train, axes_, some) - scaled_values(some, times_);
      largest = std::max(largest, error.cwiseAbs().maxCoeff());
    }
    return largest;
  }

  /// The first core, over states and times, becomes one of the states and one of time: the same numbers in the same
  /// order.
  pgd::TrainField field_of(pgd::TensorTrain train) const {
    pgd::TrainCore& first = train.cores.front();
    first.left = static_cast<int>(states());
    first.size = mesh_->axis.size();
    pgd::TrainCore outputs(1, static_cast<int>(states()), static_cast<int>(states()));
    outputs.left_unfolding() = scale_.asDiagonal();
    train.cores.insert(train.cores.begin(), std::move(outputs));
    std::vector<pgd::Axis> axes = axes_;
    axes.insert(axes.begin(), mesh_->axis);
    return {std::move(axes), source_.outputs, std::move(train)};
  }

  /// The first round is a coarse one: its pivots make the next cheaper, and its field is there if the calls end.
  void approximate_until_met() {
    constexpr int kRounds = 6;
    constexpr double kCoarse = 10.0;
    const double tolerance = plan_.relative;
    double last_error = 0.0;
    double cross_share = kCoarse * kShareOfCross, node_share = kCoarse * kShareOfNodes;
    for (int round = 1; round <= kRounds; ++round) {
      trajectories_.tell(round == 1 ? "coarse cross"
                                    : fmt::format("cross {}, the last errs by {:.2g}", round - 1, last_error),
                         0.0);
      const Skeleton skeleton = find_skeleton(kShareOfSkeleton / kShareOfCross * cross_share * tolerance);
      const pgd::CrossResult cross =
          interpolate(nodes_within(node_share * tolerance), skeleton, cross_share * tolerance);
      const double error = error_of(cross.train);
      last_error = error;
      record_.rounds = round;
      if (!field_ || error < error_) {
        field_ = field_of(cross.train);
        error_ = error;
        nodes_of_field_ = nodes_;
      }
      if (error <= kFreshMargin * tolerance && is_certified()) return;
      // The first rank is that of the skeleton, which has no bound.
      const std::vector<int> ranks = cross.train.ranks();
      const bool ranks_used_up =
          std::any_of(ranks.begin() + 1, ranks.end(), [&](int rank) { return rank >= max_rank_; });
      // The cross errs at nodes already, or only between them.
      const bool needs_nodes = error > 2.0 * cross.guard_error;
      if (round == 1) {
        cross_share = kShareOfCross;
        node_share = kShareOfNodes;
      } else {
        if (needs_nodes) node_share *= 0.2;
        if (!needs_nodes || cross.guard_error > cross_share * tolerance) cross_share *= 0.5;
      }
      const bool nodes_used_up = round > 1 && needs_nodes && nodes_within(node_share * tolerance) == nodes_;
      if (!ranks_used_up && !nodes_used_up) continue;
      throw SteppedEnd({Termination::exhausted,
                        fmt::format("the {} allowed do not suffice", ranks_used_up ? "ranks" : "nodes")});
    }
    throw SteppedEnd({Termination::stagnated, fmt::format("{} rounds did not meet the tolerance", kRounds)});
  }

  /// The best field, with fewer numbers, before the certificate. What is wrong is built again, smaller.
  bool is_certified() {
    const double unused = std::max(0.0, 0.5 * plan_.relative - error_);
    rounded_ =
        pgd::rounded(*field_, scale_, std::ldexp(kShareOfRounding * plan_.relative + unused, -refuted_),
                     plan_.builder.seed);
    Measured measured = certify_claim_(rounded_->field, static_cast<double>(trajectories_.calls()));
    if (measured.wrong.cols() > 0) {
      ++refuted_;
      return false;
    }
    certificate_ = std::move(measured.certificate);
    record_.status = Termination::converged;
    record_.message = fmt::format("largest error {:.3g} <= {:.3g} at {} points of the check", error_,
                                  plan_.relative, kCheckPoints);
    return true;
  }

  Outcome<Solution> solution() {
    if (record_.status != Termination::converged) {
      rounded_ = pgd::rounded(*field_, scale_, kShareOfRounding * plan_.relative, plan_.builder.seed);
      record_.message += fmt::format("; the best field errs by {:.3g} at {} points", error_, kCheckPoints);
    }
    record_.message += fmt::format(
        ", with {} trajectories in steps of {:.3g} s; {} elements of time; {} nodes; rounded from {} numbers "
        "to {}",
        trajectories_.calls(), trajectories_.step(), mesh_->axis.elements(),
        fmt::join(nodes_of_field_, " x "), field_->entries(), rounded_->field.entries());
    record_.evaluations = static_cast<double>(trajectories_.calls());
    record_.grid_size = 1.0;
    for (const int n : nodes_of_field_) record_.grid_size *= n;
    const ErrorBudget spent{.discretisation = mesh_->error, .compression = error_ + rounded_->error};
    return Solution{
        {Piece{{std::move(rounded_->field)}}}, std::move(record_), spent, std::move(certificate_)};
  }

  const Plan& plan_;
  const SampledSource source_;
  const CertifyClaim& certify_claim_;
  SteppedTrajectories trajectories_;
  pgd::Random random_;
  const int max_rank_, max_nodes_;
  Eigen::MatrixXd pilots_;
  std::optional<TimeMesh> mesh_;
  Eigen::VectorXd scale_;
  std::vector<double> times_;
  std::vector<Eigen::VectorXd> tails_;
  pgd::CrossPivots pivots_;  ///< of the last cross, as are nodes and axes
  std::vector<int> nodes_;
  std::vector<pgd::Axis> axes_;
  std::optional<pgd::TrainField> field_;  ///< the best so far
  double error_ = 0.0;
  int refuted_ = 0;  ///< by certificates
  std::vector<int> nodes_of_field_;
  std::optional<pgd::RoundedField> rounded_;
  std::optional<Certificate> certificate_;
  BuildRecord record_;
};

}  // namespace

Outcome<Solution> solve_by_steps(const Plan& plan, const models::ParametricModel& model, long max_calls,
                                 const ProgressCallback& progress, const CertifyClaim& certify_claim) {
  return SteppedBuild(plan, model, max_calls, progress, certify_claim).run();
}

}  // namespace samara::codebooks
