#include "samara/codebooks/build/stepped_builder.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/build/line_elements.h"
#include "samara/codebooks/build/line_nodes.h"
#include "samara/codebooks/build/stepped_grid.h"
#include "samara/codebooks/build/stepped_skeleton.h"
#include "samara/codebooks/build/stepped_state.h"
#include "samara/codebooks/build/stepped_trajectories.h"
#include "samara/codebooks/build/time_mesh.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/codebooks/source/sampled_source.h"
#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/fields/field_rounding.h"
#include "samara/pgd/tensors/number_archive.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::codebooks {

namespace {

using Eigen::Index;

// Shares of the plan's tolerance.
constexpr double kShareOfStep = 0.05;
constexpr double kShareOfStepAtFronts = 0.2;
constexpr double kShareOfMesh = 0.1;
constexpr double kShareOfSkeleton = 0.02;
constexpr double kShareOfCross = 0.5;
/// What fresh points off the grid must show: two thousand do not see the largest error of all.
constexpr double kFreshMargin = 0.6;
constexpr double kShareOfRounding = 0.1;

constexpr int kPilots = 64;
/// That states and times are chosen by.
constexpr int kFewestTrajectories = 400, kFewestAtFronts = 3200;
constexpr int kCheckPoints = 2000;
constexpr int kMaxRank = 400;
/// Trajectories of a cross that cannot meet the tolerance.
constexpr long kMostBeforeFront = 1'000'000;
/// Those of one over elements, where the plan sets no limit.
constexpr long kMostOverElements = 2'000'000;

class SteppedBuild {
 public:
  SteppedBuild(const Plan& plan, const models::ParametricModel& model, long max_calls,
               const ProgressCallback& progress, const CertifyClaim& certify_claim, const KeptState& kept)
      : plan_(plan),
        source_(model_source(plan, model)),
        certify_claim_(certify_claim),
        kept_(kept),
        trajectories_(model, plan.end / kFirstSteps, plan.builder.threads, max_calls, progress),
        random_(plan.builder.seed),
        max_rank_(plan.builder.max_rank.value_or(kMaxRank)),
        grid_(plan, source_.coordinates, trajectories_,
              [this](const Eigen::MatrixXd& points) { return scaled_values(points); }) {
    record_.builder = "sampling";
    record_.strategy = "steps";
  }

  Outcome<Solution> run() {
    try {
      trajectories_.tell("pilots", 0.0);
      pilots_ = corners_and_inside(plan_, kPilots, random_);
      choose_step(trajectories_, pilots_, plan_.end, source_.measure, kShareOfStep * plan_.relative);
      choose_times();
      grid_.look_along_lines(random_);
      if (grid_.has_elements()) look_at_fronts();
      begin();
      approximate_until_met();
    } catch (const SteppedEnd& end) {
      record_.status = end.ending.status;
      record_.message = end.ending.message;
      if (state_.best.cores.empty()) return end.ending;
    }
    return solution();
  }

 private:
  Index states() const { return static_cast<Index>(source_.outputs.size()); }

  /// All states at the times, a column per point, over their scales.
  Eigen::MatrixXd scaled_values(const Eigen::MatrixXd& points) {
    Eigen::MatrixXd values = trajectories_(points, times_);
    values.reshaped(states(), values.size() / states()).array().colwise() /= scale_.array();
    return values;
  }

  /// The pilots so far do not lie on fronts, where errors of the steps are largest and states part late.
  void look_at_fronts() {
    pgd::Random random(plan_.builder.seed);
    const Eigen::MatrixXd more = grid_.in_box(grid_.points_near_fronts(kPilots, random));
    const double step = trajectories_.step();
    trajectories_.set_step(4.0 * step);
    choose_step(trajectories_, more, plan_.end, source_.measure, kShareOfStepAtFronts * plan_.relative);
    trajectories_.set_step(std::min(step, trajectories_.step()));
    pilots_.conservativeResize(Eigen::NoChange, pilots_.cols() + more.cols());
    pilots_.rightCols(more.cols()) = more;
    choose_times();
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
    options.measure = source_.measure;
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

  /// The first round is a coarse one: its pivots make the next cheaper, and its field is there if the calls end. Where
  /// nodes do not suffice it is the only one: right away from the front. Over elements ranks are so high that pivots of
  /// a coarse round, twice as many with the first sweep, cost more than they help.
  void begin() {
    constexpr double kCoarse = 5.0;
    const bool is_coarse = !grid_.has_elements();
    state_.cross_share = (is_coarse ? kCoarse : 1.0) * kShareOfCross;
    state_.node_share = (is_coarse ? 2.0 * kCoarse : 1.0) * SteppedGrid::kFirstShare;
    state_.element_share = SteppedGrid::kFirstShare;
    state_.random = random_;
    state_.calls = trajectories_.calls();
    state_.times = times_;
    if (!kept_.state.empty()) go_on_from_kept();
  }

  void go_on_from_kept() {
    try {
      pgd::NumberReader reader(kept_.state);
      state_.transfer(reader);
      if (!reader.rest().empty()) throw ArgumentError("the stored state of a build by steps is too long");
    } catch (const ArgumentError& error) {
      throw bad_checkpoint(kept_.file, error.what());
    }
    grid_.halve_elements(state_.element_share);
    const auto rows = static_cast<std::size_t>(states()) * times_.size();
    if (state_.times != times_ || !state_.fits(plan_.box.size(), rows, grid_.nodes_within(state_.node_share)))
      throw bad_checkpoint(kept_.file,
                           "the stored state of a build by steps is of another grid or other times");
    trajectories_.go_on_from(state_.calls);
  }

  void keep() {
    state_.calls = trajectories_.calls();
    // A certificate that refutes a field has used up its points: what comes after is found again.
    if (!kept_.save || refuted_ > 0) return;
    pgd::NumberWriter writer;
    state_.transfer(writer);
    kept_.save(writer.numbers());
  }

  void approximate_until_met() {
    constexpr int kRounds = 6;
    for (; state_.round <= kRounds; ++state_.round) {
      record_.rounds = state_.round;
      random_ = state_.random;
      if (!state_.is_crossed) approximate();
      const bool is_claimed = state_.error <= kFreshMargin * plan_.relative;
      // A front was seen at points of lines: the field is wrong there, whatever others say.
      if (is_claimed && !grid_.front() && is_certified()) return;
      tighten(is_claimed);
    }
    throw SteppedEnd({Termination::stagnated, fmt::format("{} rounds did not meet the tolerance", kRounds)});
  }

  void approximate() {
    trajectories_.tell(state_.cross_share > kShareOfCross ? "coarse cross"
                       : state_.round == 1
                           ? "cross"
                           : fmt::format("cross {}, the last errs by {:.2g}", state_.round - 1, state_.error),
                       0.0);
    const double tolerance = state_.cross_share * plan_.relative;
    const Skeleton chosen = skeleton(kShareOfSkeleton / kShareOfCross * tolerance);
    const pgd::CrossResult cross = interpolate(grid_.nodes_within(state_.node_share), chosen, tolerance);
    state_.error = error_of(cross.train);
    state_.guard_error = cross.guard_error;
    // The first rank is that of the skeleton, which has no bound.
    const std::vector<int> ranks = cross.train.ranks();
    state_.are_ranks_used_up =
        std::any_of(ranks.begin() + 1, ranks.end(), [&](int rank) { return rank >= max_rank_; });
    if (state_.best.cores.empty() || state_.error < state_.best_error) {
      state_.best = cross.train;
      state_.best_error = state_.error;
      state_.nodes_of_best = state_.nodes;
    }
    state_.is_crossed = true;
    state_.random = random_;
    keep();
  }

  Skeleton skeleton(double bound) {
    const auto some = [&](int count) {
      return scaled_values(grid_.in_box(grid_.mixed_points(count, random_)));
    };
    const int fewest = grid_.has_elements() ? kFewestAtFronts : kFewestTrajectories;
    return find_skeleton(some, times_, scale_, fewest, 4 * max_rank_, bound);
  }

  /// The train of all states at all times over the grid, by crosses whose guards err by at most `tolerance`.
  pgd::CrossResult interpolate(const std::vector<int>& nodes, const Skeleton& skeleton, double tolerance) {
    const std::vector<pgd::Axis> axes = grid_.axes(nodes);
    const pgd::EntryFunction at_entries = [&](const pgd::IndexBatch& entries, Eigen::MatrixXd& values) {
      const Eigen::MatrixXd all =
          trajectories_(grid_.in_box(pgd::coordinates_at(axes, entries)), skeleton.times);
      for (Index j = 0; j < all.cols(); ++j)
        values.col(j) = skeleton.scale.asDiagonal().inverse() * all.col(j)(skeleton.places);
    };
    pgd::CrossOptions options;
    options.tolerance = tolerance;
    options.max_rank = max_rank_;
    options.max_sweeps = 8;
    options.guard_entries = plan_.builder.guards.value_or(500);
    options.first_pivots = 50;
    options.growth = 1.0;
    options.few_places = true;
    if (grid_.front()) options.max_evaluations = kMostBeforeFront;
    if (grid_.has_elements() && plan_.builder.max_calls == 0) options.max_evaluations = kMostOverElements;
    options.seed = random_.bits();
    // Pivots of the last cross do not lie on other elements.
    if (!state_.nodes.empty() && grid_.are_same_elements(nodes, state_.nodes))
      options.start = pgd::carried_over(state_.pivots, state_.nodes, nodes);
    options.checkpoint = [this](pgd::CrossState& sweep) {
      state_.sweep = {sweep};
      keep();
    };
    if (!state_.sweep.empty()) {
      options.state = state_.sweep.front();
      trajectories_.go_on_from(state_.calls);
    }
    const auto rows = static_cast<int>(skeleton.rows.size());
    pgd::CrossResult cross = pgd::interpolate(at_entries, rows, nodes, options);
    pgd::TrainCore first(1, static_cast<int>(skeleton.coefficients.rows()), rows);
    first.left_unfolding() = skeleton.coefficients;
    cross.train.cores[0] = std::move(first);
    state_.sweep.clear();
    state_.pivots = cross.pivots;
    state_.nodes = nodes;
    return cross;
  }

  /// Largest error at fresh points, off the grid, of all states at all times. Where there are fronts, half of the
  /// points lie about them.
  double error_of(const pgd::TensorTrain& train) {
    const std::vector<pgd::Axis> axes = grid_.axes(state_.nodes);
    Eigen::MatrixXd points(static_cast<Index>(plan_.box.size()), kCheckPoints);
    for (double& share : points.reshaped()) share = random_.uniform();
    for (Index k = 0; k < points.rows(); ++k) {
      const BoxEntry& entry = plan_.box[static_cast<std::size_t>(k)];
      points.row(k) = (entry.lower + (entry.upper - entry.lower) * points.row(k).array()).matrix();
    }
    if (grid_.has_elements())
      points.leftCols(kCheckPoints / 2) = grid_.points_near_fronts(kCheckPoints / 2, random_);
    double largest = 0.0;
    constexpr Index kTogether = 500;
    for (Index first = 0; first < points.cols(); first += kTogether) {
      const Eigen::MatrixXd some = points.middleCols(first, kTogether);
      const Eigen::MatrixXd error =
          pgd::many_values_at(train, axes, some) - scaled_values(grid_.in_box(some));
      largest = std::max(largest, error.cwiseAbs().maxCoeff());
    }
    return largest;
  }

  /// The best field, with fewer numbers, before the certificate. What is wrong is built again, smaller.
  bool is_certified() {
    const double unused = std::max(0.0, 0.5 * plan_.relative - state_.best_error);
    const pgd::TrainField field = best_field();
    round_off(field, std::ldexp(kShareOfRounding * plan_.relative + unused, -refuted_));
    Measured measured = certify_claim_(piece(), static_cast<double>(trajectories_.calls()));
    if (measured.wrong.cols() > 0) {
      ++refuted_;
      // Any field that errs by less takes its place, and it is not claimed again.
      state_.best_error = std::max(state_.best_error, measured.certificate.max_error);
      return false;
    }
    certificate_ = std::move(measured.certificate);
    record_.status = Termination::converged;
    record_.message = fmt::format("largest error {:.3g} <= {:.3g} at {} points of the check",
                                  state_.best_error, plan_.relative, kCheckPoints);
    return true;
  }

  /// The first core, over states and times, becomes one of the states and one of time: the same numbers in the same
  /// order.
  pgd::TrainField best_field() const {
    pgd::TensorTrain train = state_.best;
    pgd::TrainCore& first = train.cores.front();
    first.left = static_cast<int>(states());
    first.size = mesh_->axis.size();
    pgd::TrainCore outputs(1, static_cast<int>(states()), static_cast<int>(states()));
    outputs.left_unfolding() = scale_.asDiagonal();
    train.cores.insert(train.cores.begin(), std::move(outputs));
    std::vector<pgd::Axis> axes = grid_.axes(state_.nodes_of_best);
    axes.insert(axes.begin(), mesh_->axis);
    return {std::move(axes), source_.outputs, std::move(train)};
  }

  /// Of what is rounded.
  Piece piece() const {
    const FrontMap* map = grid_.counted_from();
    return map == nullptr ? Piece{{rounded_->field}} : Piece({rounded_->field}, map->shifted(1));
  }

  /// Mean squares over all nodes know of fronts, points of the whole box hardly: some are told.
  void round_off(const pgd::TrainField& field, double tolerance) {
    Eigen::MatrixXd centres;
    if (grid_.has_elements()) {
      constexpr int kCentres = 1000;
      pgd::Random random(plan_.builder.seed);
      centres = points_by_elements(field.axes(), kCentres, random);
    }
    rounded_ = pgd::rounded(field, scale_, tolerance, plan_.builder.seed, centres);
  }

  /// For the next round. @param is_refuted by the certificate, at points that tell nodes from ranks no more than fresh
  /// ones have  @throws SteppedEnd where there is none
  void tighten(bool is_refuted) {
    // Left by a cross that did not end.
    if (grid_.has_elements() && !state_.are_ranks_used_up &&
        state_.guard_error > 2.0 * state_.cross_share * plan_.relative) {
      throw SteppedEnd({Termination::exhausted,
                        fmt::format("fronts move through the box: a cross over {} nodes still errs by {:.2g}",
                                    fmt::join(state_.nodes, " x "), state_.guard_error)});
    }
    // The cross errs at nodes already, or only between them.
    const bool needs_nodes = state_.error > 2.0 * state_.guard_error;
    if (state_.cross_share > kShareOfCross) {
      state_.cross_share = kShareOfCross;
      state_.node_share = SteppedGrid::kFirstShare;
    } else {
      if (needs_nodes || is_refuted) state_.node_share *= SteppedGrid::kTighter;
      if (!needs_nodes || is_refuted || state_.guard_error > state_.cross_share * plan_.relative)
        state_.cross_share *= 0.5;
    }
    const auto is_same_grid = [&] { return grid_.nodes_within(state_.node_share) == state_.nodes; };
    // Polynomials first: a cross over the same elements goes on from the pivots of the last.
    if (grid_.has_elements() && needs_nodes && !state_.are_ranks_used_up && is_same_grid()) {
      state_.element_share *= SteppedGrid::kTighter;
      grid_.halve_elements(state_.element_share);
    }
    refuse_in_vain(needs_nodes && is_same_grid());
    state_.is_crossed = false;
  }

  /// @param is_same_grid although nodes are needed  @throws SteppedEnd where ranks or nodes do not allow another round
  void refuse_in_vain(bool is_same_grid) const {
    // One that errs by little is worth a fine round.
    constexpr double kLittle = 10.0;
    const Front* front = grid_.front();
    if (front != nullptr && (state_.round > 1 || front->error > kLittle * plan_.relative)) {
      throw SteppedEnd(
          {Termination::exhausted,
           fmt::format("{}; {}",
                       described(*front, source_.coordinates, source_.outputs, times_, source_.time_unit),
                       front->allowed == LineNodes::kMostNodes ? "steps take no more"
                                                               : "the nodes allowed do not suffice")});
    }
    const bool are_nodes_used_up = (state_.round > 1 || grid_.has_elements()) && is_same_grid;
    if (state_.are_ranks_used_up || are_nodes_used_up) {
      throw SteppedEnd(
          {Termination::exhausted, state_.are_ranks_used_up ? "the ranks allowed do not suffice"
                                   : grid_.has_elements() && !grid_.are_polynomials_used_up(state_.node_share)
                                       ? "the nodes that lines ask for do not suffice between them"
                                       : "the nodes allowed do not suffice"});
    }
  }

  Outcome<Solution> solution() {
    const pgd::TrainField field = best_field();
    if (record_.status != Termination::converged) {
      round_off(field, kShareOfRounding * plan_.relative);
      record_.message +=
          fmt::format("; the best field errs by {:.3g} where it was checked", state_.best_error);
    }
    record_.message += fmt::format(
        ", with {} trajectories in steps of {:.3g} s; {} elements of time; {} nodes; rounded from {} numbers "
        "to {}",
        trajectories_.calls(), trajectories_.step(), mesh_->axis.elements(),
        fmt::join(state_.nodes_of_best, " x "), field.entries(), rounded_->field.entries());
    for (const pgd::Axis& axis : grid_.axes(state_.nodes_of_best)) {
      if (axis.elements() > 1)
        record_.message += fmt::format("; {} elements along {}", axis.elements(), axis.name());
    }
    if (const FrontMap* map = grid_.counted_from()) {
      record_.message += fmt::format("; {} is counted from a front",
                                     source_.coordinates[static_cast<std::size_t>(map->coordinate())].name);
    }
    record_.evaluations = static_cast<double>(trajectories_.calls());
    record_.grid_size = 1.0;
    for (const int n : state_.nodes_of_best) record_.grid_size *= n;
    const ErrorBudget spent{.discretisation = mesh_->error,
                            .compression = state_.best_error + rounded_->error};
    return Solution{{piece()}, std::move(record_), spent, std::move(certificate_)};
  }

  const Plan& plan_;
  const SampledSource source_;
  const CertifyClaim& certify_claim_;
  const KeptState& kept_;
  SteppedTrajectories trajectories_;
  pgd::Random random_;
  const int max_rank_;
  Eigen::MatrixXd pilots_;
  std::optional<TimeMesh> mesh_;
  Eigen::VectorXd scale_;
  std::vector<double> times_;
  SteppedGrid grid_;
  SteppedState state_;
  int refuted_ = 0;  ///< by certificates
  std::optional<pgd::RoundedField> rounded_;
  std::optional<Certificate> certificate_;
  BuildRecord record_;
};

}  // namespace

Outcome<Solution> solve_by_steps(const Plan& plan, const models::ParametricModel& model, long max_calls,
                                 const ProgressCallback& progress, const CertifyClaim& certify_claim,
                                 const KeptState& kept) {
  return SteppedBuild(plan, model, max_calls, progress, certify_claim, kept).run();
}

}  // namespace samara::codebooks
