#include "samara/codebooks/compaction.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "samara/pgd/random.h"
#include "samara/pgd/slab_join.h"
#include "samara/pgd/train_points.h"

namespace samara::codebooks {

namespace {

/// Largest less smallest value of every output at random points of all pieces.
Eigen::VectorXd ranges(const std::vector<pgd::TrainField>& fields, const CompactionRequest& request) {
  constexpr int kPoints = 64;
  pgd::Random random(request.seed);
  Eigen::VectorXd smallest, largest;
  for (const pgd::TrainField& field : fields) {
    Eigen::MatrixXd points(field.axis_count(), kPoints);
    for (Eigen::Index j = 0; j < kPoints; ++j) {
      for (std::size_t k = 0; k < field.axes().size(); ++k) {
        const pgd::Axis& axis = field.axes()[k];
        const bool is_list = !axis.has_elements() && axis.basis() != pgd::Basis::fourier;
        points(static_cast<Eigen::Index>(k), j) = is_list ? axis.nodes()[random.below(axis.size())]
                                                          : axis.lower() + axis.length() * random.uniform();
      }
    }
    const Eigen::MatrixXd values = pgd::values_at(field.train(), field.axes(), points);
    if (smallest.size() == 0) smallest = largest = values.col(0);
    smallest = smallest.cwiseMin(values.rowwise().minCoeff());
    largest = largest.cwiseMax(values.rowwise().maxCoeff());
  }
  Eigen::VectorXd range = largest - smallest;
  for (Eigen::Index o = 0; o < range.size(); ++o) {
    const auto floor = request.absolute.find(fields.front().outputs()[static_cast<std::size_t>(o)].name);
    if (floor != request.absolute.end()) range[o] = std::max(range[o], floor->second);
    // An output that is constant is held to its size, and nothing to nothing.
    if (!(range[o] > 0.0)) range[o] = std::max(std::abs(largest[o]), 1e-300);
  }
  return range;
}

/// Trains of one cell each follow each other in time: pieces with the same box of parameters.
bool same_cell(const pgd::TrainField& a, const pgd::TrainField& b) {
  return std::equal(a.axes().begin() + 1, a.axes().end(), b.axes().begin() + 1, b.axes().end(),
                    [](const pgd::Axis& left, const pgd::Axis& right) {
                      return left.lower() == right.lower() && left.upper() == right.upper();
                    });
}

long entries(const std::vector<pgd::TrainField>& fields) {
  long sum = 0;
  for (const pgd::TrainField& field : fields) sum += field.entries();
  return sum;
}

}  // namespace

Solution compacted(const Solution& solution, const CompactionRequest& request) {
  // Errors of the builder are those of a few points: the certificate sees somewhat larger ones.
  const double left = request.tolerance - 1.5 * solution.spent.nonlinearity;
  if (solution.record.strategy != "slabs" || solution.record.status != "converged" || !(left > 0.0))
    return solution;
  std::vector<pgd::TrainField> fields;
  for (const Piece& piece : solution.pieces) {
    if (piece.groups().size() != 1 || piece.groups().front().train() == nullptr) return solution;
    fields.push_back(*piece.groups().front().train());
  }
  const Eigen::VectorXd scale = ranges(fields, request);
  const pgd::CompactOptions options{.tolerance = request.share * left, .seed = request.seed};
  std::vector<char> done(fields.size(), 0);
  Solution result = solution;
  result.pieces.clear();
  std::vector<pgd::TrainField> compact;
  for (std::size_t first = 0; first < fields.size(); ++first) {
    if (done[first]) continue;
    std::vector<pgd::TrainField> cell;
    for (std::size_t k = first; k < fields.size(); ++k) {
      if (done[k] || !same_cell(fields[first], fields[k])) continue;
      cell.push_back(fields[k]);
      done[k] = 1;
    }
    for (pgd::TrainField& field : pgd::compacted(cell, scale, options)) compact.push_back(std::move(field));
  }
  const long before = entries(fields), after = entries(compact);
  if (after >= before) return solution;
  for (pgd::TrainField& field : compact) result.pieces.push_back(Piece{{std::move(field)}});
  result.spent.compression += options.tolerance;
  result.record.message +=
      fmt::format("; {} numbers made {} in {} pieces", before, after, result.pieces.size());
  return result;
}

}  // namespace samara::codebooks
