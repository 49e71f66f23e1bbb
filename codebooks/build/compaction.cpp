#include "samara/codebooks/build/compaction.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "samara/codebooks/source/model_measure.h"
#include "samara/pgd/evolution/slab_join.h"
#include "samara/pgd/fields/error_scale.h"
#include "samara/pgd/fields/field_algebra.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::codebooks {

namespace {

Eigen::MatrixXd random_points(const std::vector<pgd::Axis>& axes, int count, pgd::Random& random) {
  Eigen::MatrixXd points(static_cast<Eigen::Index>(axes.size()), count);
  for (Eigen::Index j = 0; j < count; ++j) {
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const pgd::Axis& axis = axes[k];
      points(static_cast<Eigen::Index>(k), j) = axis.is_list()
                                                    ? axis.nodes()[random.below(axis.size())]
                                                    : axis.lower() + axis.length() * random.uniform();
    }
  }
  return points;
}

Eigen::MatrixXd values_of(const pgd::SeparatedField& sum, const Eigen::MatrixXd& points) {
  pgd::SeparatedField::Workspace workspace = sum.make_workspace();
  Eigen::MatrixXd values(sum.output_count(), points.cols());
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    sum.evaluate({points.col(j).data(), static_cast<std::size_t>(points.rows())}, values.col(j), workspace);
  }
  return values;
}

/// What errors of every output are divided by.
/// @param values outputs x points
Eigen::VectorXd ranges(const Eigen::MatrixXd& values, const std::vector<pgd::OutputLabel>& outputs,
                       const CompactionRequest& request) {
  const Eigen::VectorXd floors = floors_of(request.absolute, outputs);
  Eigen::VectorXd range =
      pgd::error_scales(values.rowwise().minCoeff(), values.rowwise().maxCoeff(), {.floors = floors});
  for (Eigen::Index o = 0; o < range.size(); ++o) {
    // Nothing is held to nothing.
    if (floors[o] == 0.0 && values.row(o).isZero(0.0)) range[o] = 1e-300;
  }
  return range;
}

Eigen::VectorXd ranges(const std::vector<pgd::TrainField>& fields, const CompactionRequest& request) {
  constexpr int kPoints = 64;  // of a piece
  pgd::Random random(request.seed);
  Eigen::MatrixXd values(fields.front().output_count(), kPoints * static_cast<Eigen::Index>(fields.size()));
  for (std::size_t p = 0; p < fields.size(); ++p) {
    const pgd::TrainField& field = fields[p];
    values.middleCols(kPoints * static_cast<Eigen::Index>(p), kPoints) =
        pgd::values_at(field.train(), field.axes(), random_points(field.axes(), kPoints, random));
  }
  return ranges(values, fields.front().outputs(), request);
}

/// Trains of one cell each follow each other in time: pieces with the same box of parameters.
bool same_cell(const pgd::TrainField& a, const pgd::TrainField& b) {
  return std::equal(a.axes().begin() + 1, a.axes().end(), b.axes().begin() + 1, b.axes().end(),
                    [](const pgd::Axis& left, const pgd::Axis& right) {
                      return left.lower() == right.lower() && left.upper() == right.upper();
                    });
}

/// All trains of the pieces, cell by cell with fewer numbers.
/// @param tolerance over the ranges of the outputs
std::vector<Piece> joined(const std::vector<Piece>& pieces, double tolerance,
                          const CompactionRequest& request) {
  std::vector<pgd::TrainField> fields;
  for (const Piece& piece : pieces) fields.push_back(*piece.groups().front().train());
  const Eigen::VectorXd scale = ranges(fields, request);
  std::vector<char> done(fields.size(), 0);
  std::vector<Piece> result;
  for (std::size_t first = 0; first < fields.size(); ++first) {
    if (done[first]) continue;
    std::vector<pgd::TrainField> cell;
    for (std::size_t k = first; k < fields.size(); ++k) {
      if (done[k] || !same_cell(fields[first], fields[k])) continue;
      cell.push_back(fields[k]);
      done[k] = 1;
    }
    for (pgd::TrainField& field : pgd::compacted(
             cell, scale, {.tolerance = tolerance, .seed = request.seed, .kept_axes = request.kept_axes})) {
      result.push_back(Piece{{std::move(field)}});
    }
  }
  return result;
}

/// A sum over time and parameters as its value at the start, constant in time, and the rest, every term of
/// which is zero there.
struct StartAndRest {
  pgd::SeparatedField start, rest;
};

/// @param scale of the outputs: what is less than round-off of it at the start is nothing
StartAndRest split(const pgd::SeparatedField& sum, const Eigen::VectorXd& scale) {
  std::vector<Eigen::MatrixXd> constant = sum.factors(), vanishing = sum.factors();
  const Eigen::RowVectorXd first = sum.factors()[0].row(0);
  constant[0].rowwise() = first;
  vanishing[0].rowwise() -= first;
  Eigen::MatrixXd weights = sum.weights();
  const pgd::SeparatedField start(sum.axes(), sum.outputs(), constant, weights);
  const Eigen::VectorXd size = pgd::root_mean_square(start);
  for (Eigen::Index o = 0; o < scale.size(); ++o) {
    if (size[o] <= 1e-14 * scale[o]) weights.row(o).setZero();
  }
  return {pgd::SeparatedField(sum.axes(), sum.outputs(), std::move(constant), std::move(weights)),
          pgd::SeparatedField(sum.axes(), sum.outputs(), std::move(vanishing), sum.weights())};
}

/// The sum with fewer terms, and with its initial values to round-off. Terms are left out by root mean
/// squares, errors count by the largest: the bound of the one is lowered until random points see no more than
/// the other.
pgd::SeparatedField shortened(const pgd::SeparatedField& sum, double tolerance,
                              const CompactionRequest& request) {
  constexpr int kPoints = 2000, kTries = 4;
  constexpr double kRoundOff = 1e-14;
  pgd::Random random(request.seed);
  const Eigen::MatrixXd points = random_points(sum.axes(), kPoints, random);
  const Eigen::MatrixXd exact = values_of(sum, points);
  const Eigen::VectorXd scale = ranges(exact, sum.outputs(), request);
  const StartAndRest parts = split(sum, scale);
  const pgd::SeparatedField start = pgd::compress(parts.start, kRoundOff).field;
  double bound = tolerance;
  for (int i = 0; i < kTries; ++i) {
    pgd::SeparatedField shorter = pgd::sum(start, pgd::compress(parts.rest, bound).field);
    const Eigen::ArrayXd difference = (values_of(shorter, points) - exact).cwiseAbs().rowwise().maxCoeff();
    const double error = (difference / scale.array()).maxCoeff();
    if (error <= tolerance) return shorter;
    bound *= 0.7 * tolerance / error;
  }
  return sum;
}

bool is_train(const Piece& piece) {
  return piece.groups().front().train() != nullptr;
}

long entries(const std::vector<Piece>& pieces) {
  long sum = 0;
  for (const Piece& piece : pieces) {
    for (const FieldGroup& group : piece.groups()) sum += group.entries();
  }
  return sum;
}

}  // namespace

CompactionRequest compaction_of(const Plan& plan, double share) {
  CompactionRequest request{
      .tolerance = plan.relative, .share = share, .absolute = plan.absolute, .seed = plan.builder.seed};
  for (const BoxEntry& entry : plan.box) {
    if (entry.prescribes_axis()) request.kept_axes.push_back(entry.name);
  }
  return request;
}

std::optional<Solution> compacted(const Solution& solution, const CompactionRequest& request) {
  // Errors of the builder are those of a few points: the certificate sees somewhat larger ones.
  const double tolerance = request.share * (request.tolerance - 1.5 * solution.spent.total());
  if (solution.record.builder != "pgd" || solution.record.status != Termination::converged ||
      !(tolerance > 0.0))
    return std::nullopt;
  Solution result = solution;
  if (std::all_of(solution.pieces.begin(), solution.pieces.end(), is_train)) {
    result.pieces = joined(solution.pieces, tolerance, request);
  } else {
    for (Piece& piece : result.pieces) {
      if (!is_train(piece)) piece = Piece{{shortened(*piece.groups().front().sum(), tolerance, request)}};
    }
  }
  const long before = entries(solution.pieces), after = entries(result.pieces);
  if (after >= before) return std::nullopt;
  result.spent.compression += tolerance;
  result.record.message += fmt::format("; {} numbers made {} in {} piece{}", before, after,
                                       result.pieces.size(), result.pieces.size() == 1 ? "" : "s");
  return result;
}

}  // namespace samara::codebooks
