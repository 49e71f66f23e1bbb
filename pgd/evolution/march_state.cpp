#include "samara/pgd/evolution/march_state.h"

#include <algorithm>
#include <utility>

#include "samara/base/errors.h"
#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/march_context.h"
#include "samara/pgd/tensors/number_archive.h"

namespace samara::pgd {

namespace {

/// Axes of parameters: those of the problem, on their own interval with their own nodes.
template <class Archive>
void transfer_axes(Archive& archive, const AdaptiveProblem& problem, int max_nodes, std::vector<Axis>& axes) {
  std::vector<Axis> read;
  for (std::size_t k = 0; k < problem.parameters.size(); ++k) {
    AdaptiveAxis axis = problem.parameters[k];
    int nodes = 0;
    if constexpr (!Archive::kReads) {
      axis.lower = axes[k].lower();
      axis.upper = axes[k].upper();
      nodes = axes[k].size();
    }
    archive(axis.lower, axis.upper, nodes);
    if constexpr (Archive::kReads) {
      if (nodes > std::max(max_nodes, axis.nodes.value_or(0)) + 1)  // p2 and fourier take an odd number
        throw ArgumentError("the stored state of a march in slabs has more nodes than its options allow");
      read.push_back(make_axis(axis, nodes));
    }
  }
  if constexpr (Archive::kReads) axes = std::move(read);
}

template <class Archive>
void transfer(Archive& archive, const AdaptiveProblem& problem, int max_nodes, SlabCell& cell) {
  transfer_axes(archive, problem, max_nodes, cell.axes);
  archive(cell.time, cell.length, cell.usual_length, cell.start, cell.pivots.right, cell.guards, cell.carried,
          cell.strictness, cell.leniency, cell.rate_of_error, cell.grows_slowly, cell.number);
}

template <class Archive>
void transfer(Archive& archive, SlabRecord& record) {
  archive(record.cell, record.begin, record.end, record.elements, record.nodes, record.ranks,
          record.contraction, record.iterations, record.local_error, record.carried_error, record.evaluations,
          record.grid_evaluations, record.seconds);
}

/// A cell whose parts belong together.
void check(const AdaptiveProblem& problem, const SlabCell& cell) {
  bool fits = cell.start.modes() == static_cast<int>(cell.axes.size()) + 1 &&
              cell.guards.rows() == static_cast<Eigen::Index>(cell.axes.size()) &&
              cell.carried.rows() == static_cast<Eigen::Index>(problem.states.size()) &&
              cell.carried.cols() == cell.guards.cols() && cell.guards.allFinite() && cell.time >= 0.0 &&
              cell.time <= problem.end && cell.length > 0.0 && cell.usual_length >= 0.0 &&
              cell.strictness > 0.0 && cell.leniency > 0.0;
  int left = 1;
  for (std::size_t k = 0; fits && k < cell.start.cores.size(); ++k) {
    const TrainCore& core = cell.start.cores[k];
    const int size = k == 0 ? static_cast<int>(problem.states.size()) : cell.axes[k - 1].size();
    fits = core.left == left && core.size == size && core.right >= 1 &&
           core.data.size() == Eigen::Index{core.left} * core.size * core.right;
    left = core.right;
  }
  if (!fits || left != 1)
    throw ArgumentError("the stored state of a march in slabs does not fit its problem");
}

/// What a march reads of the state besides its cells.
void check(const AdaptiveProblem& problem, const MarchState& state) {
  const auto states = static_cast<Eigen::Index>(problem.states.size());
  if (state.smallest.size() == states && state.largest.size() == states &&
      std::ranges::none_of(state.history, [](const SlabRecord& record) { return record.ranks.empty(); }))
    return;
  throw ArgumentError("the stored state of a march in slabs does not fit its problem");
}

template <class Archive>
void transfer_pieces(Archive& archive, const AdaptiveProblem& problem, const SlabOptions& options,
                     std::vector<MarchPiece>& pieces) {
  auto count = static_cast<Eigen::Index>(pieces.size());
  archive.size(count);
  for (Eigen::Index p = 0; p < count; ++p) {
    int cell = 0;
    std::vector<double> borders;
    std::vector<Axis> axes;
    TensorTrain train;
    if constexpr (!Archive::kReads) {
      const MarchPiece& piece = pieces[static_cast<std::size_t>(p)];
      cell = piece.cell;
      const std::vector<Axis>& all = piece.field.axes();
      borders.assign(all[0].borders().begin(), all[0].borders().end());
      axes.assign(all.begin() + 1, all.end());
      train = piece.field.train();
    }
    archive(cell, borders);
    transfer_axes(archive, problem, options.max_nodes, axes);
    archive(train);
    if constexpr (Archive::kReads) {
      axes.insert(axes.begin(), slab_axis(problem, borders));
      pieces.push_back({cell, borders.back(), TrainField(std::move(axes), problem.states, std::move(train))});
    }
  }
}

template <class Archive>
void transfer(Archive& archive, const AdaptiveProblem& problem, const SlabOptions& options,
              MarchState& state) {
  transfer_pieces(archive, problem, options, state.pieces);
  auto cells = static_cast<Eigen::Index>(state.cells.size());
  auto records = static_cast<Eigen::Index>(state.history.size());
  archive.size(cells);
  archive.size(records);
  if constexpr (Archive::kReads) {
    if (cells < 1) throw ArgumentError("the stored state of a march in slabs has no cell");
    state.cells.assign(static_cast<std::size_t>(cells), SlabCell());
    state.history.assign(static_cast<std::size_t>(records), SlabRecord());
  }
  for (SlabCell& cell : state.cells) {
    transfer(archive, problem, options.max_nodes, cell);
    if constexpr (Archive::kReads) check(problem, cell);
  }
  for (SlabRecord& record : state.history) transfer(archive, record);
  archive(state.random, state.evaluations, state.grid_evaluations, state.carried_error, state.left,
          state.smallest, state.largest);
  if constexpr (Archive::kReads) check(problem, state);
}

}  // namespace

Axis slab_axis(const AdaptiveProblem& problem, const std::vector<double>& borders) {
  return Axis::radau(
      problem.time,
      Eigen::Map<const Eigen::VectorXd>(borders.data(), static_cast<Eigen::Index>(borders.size())),
      MarchContext::kTimePoints);
}

std::vector<double> archived(MarchState& state, const AdaptiveProblem& problem, const SlabOptions& options) {
  NumberWriter writer;
  transfer(writer, problem, options, state);
  return writer.numbers();
}

MarchState restored(std::span<const double> numbers, const AdaptiveProblem& problem,
                    const SlabOptions& options) {
  NumberReader reader(numbers);
  MarchState state;
  transfer(reader, problem, options, state);
  if (!reader.rest().empty())
    throw ArgumentError("the stored state of a march in slabs is longer than its march");
  return state;
}

}  // namespace samara::pgd
