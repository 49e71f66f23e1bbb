#include "samara/codebooks/statistics/input_draws.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/piece_finder.h"
#include "samara/codebooks/book/sobol_points.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"

namespace samara::codebooks {

namespace {

/// Most numbers of the answers that are kept at a time.
constexpr Eigen::Index kMostNumbers = 16'000'000;

/// Standard deviations of the inputs. @throws ArgumentError for a matrix that is no covariance to look at
Eigen::VectorXd deviations_of(const JointNormal& joint) {
  const Eigen::MatrixXd& covariance = joint.covariance;
  const auto name = [&](Eigen::Index k) { return joint.inputs[static_cast<std::size_t>(k)]; };
  for (Eigen::Index k = 0; k < covariance.rows(); ++k) {
    const double variance = covariance(k, k);
    if (!(variance >= 0.0) || !std::isfinite(variance))
      throw ArgumentError(
          fmt::format("the covariance of the inputs gives \"{}\" the variance {}, expected a finite number "
                      "of at least 0",
                      name(k), variance));
  }
  const Eigen::VectorXd deviations = covariance.diagonal().cwiseSqrt();
  // What is left of symmetry by the inverse of an ill-conditioned matrix.
  constexpr double kRoundOff = 1e-6;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const double lower = covariance(i, j), upper = covariance(j, i), size = deviations[i] * deviations[j];
      if (size == 0.0 && (lower != 0.0 || upper != 0.0))
        throw ArgumentError(
            fmt::format("\"{}\" and \"{}\" have the covariance {}, expected 0 beside a variance of 0",
                        name(j), name(i), lower != 0.0 ? lower : upper));
      if (!(std::abs(lower - upper) <= kRoundOff * size))
        throw ArgumentError(fmt::format(
            "\"{}\" and \"{}\" have the covariance {} above the diagonal and {} below it, expected "
            "the same finite number",
            name(j), name(i), upper, lower));
    }
  }
  return deviations;
}

/// F with F F^T = covariance. The root is taken of correlations, as round-off of eigenvalues is relative to the largest
/// one: of variances in SI units it would cover small ones.
/// @throws ArgumentError if it is none
Eigen::MatrixXd root_of(const JointNormal& joint) {
  const Eigen::VectorXd deviations = deviations_of(joint);
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(deviations.size(), deviations.size());
  for (Eigen::Index i = 0; i < deviations.size(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      if (deviations[i] == 0.0 || deviations[j] == 0.0) continue;
      const double both = 0.5 * (joint.covariance(i, j) + joint.covariance(j, i));
      correlation(i, j) = correlation(j, i) = both / deviations[i] / deviations[j];
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(correlation);
  const Eigen::VectorXd& values = solver.eigenvalues();
  constexpr double kRoundOff = 1e-10;
  if (solver.info() != Eigen::Success || values.minCoeff() < -kRoundOff * values.maxCoeff())
    throw ArgumentError("the covariance of the inputs has a negative variance, expected a covariance");
  return deviations.asDiagonal() * solver.eigenvectors() * values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// The value below which lies `share` of what is inside the box.
double value_inside(const Distribution& distribution, const Coordinate& box, double share) {
  const double below = probability_below(distribution, box.lower),
               inside = probability_below(distribution, box.upper) - below;
  // Of points next to a side, whose share is 0 or 1 to rounding, the side itself.
  const double total = below + share * inside;
  if (!(total > 0.0)) return box.lower;
  if (!(total < 1.0)) return box.upper;
  return std::clamp(quantile_of(distribution, total), box.lower, box.upper);
}

double value_of_list(const ListValues& list, double share) {
  double left = share * list.weights.sum();
  for (Eigen::Index i = 0; i + 1 < list.values.size(); ++i) {
    left -= list.weights[i];
    if (left < 0.0) return list.values[i];
  }
  return list.values[list.values.size() - 1];
}

/// Of sorted values, by linear interpolation between them.
double quantile_of_sorted(const Eigen::VectorXd& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<Eigen::Index>(place);
  if (below + 1 >= sorted.size()) return sorted[sorted.size() - 1];
  const double part = place - static_cast<double>(below);
  return (1.0 - part) * sorted[below] + part * sorted[below + 1];
}

/// Answers at some of the times: (times * outputs) x draws, times running fastest.
Eigen::MatrixXd answers_at(const Codebook& book, std::span<const double> times,
                           const Eigen::MatrixXd& points) {
  if (!book.has_time()) {
    Eigen::MatrixXd values(book.output_count(), points.cols());
    Query(book).batch(points, values, 0);
    return values;
  }
  Eigen::MatrixXd values(static_cast<Eigen::Index>(times.size()) * book.output_count(), points.cols());
  TrajectoryQuery(book, {times.begin(), times.end()}).batch(points, values, 0);
  return values;
}

/// Axes of those pieces that hold the values, without time.
std::vector<std::vector<pgd::Axis>> axes_of_pieces(const Codebook& book,
                                                   const std::map<std::string, double>& fixed) {
  std::vector<std::optional<double>> held(book.coordinates().size());
  for (const auto& [name, value] : fixed) held[static_cast<std::size_t>(book.coordinate_index(name))] = value;
  std::vector<std::vector<pgd::Axis>> all;
  for (const Piece& piece : book.pieces()) {
    if (!holds(piece, held, false)) continue;
    all.push_back(piece.outline().axes);
    if (book.has_time()) all.back().erase(all.back().begin());
  }
  if (all.empty())
    throw OutsideBoxError(
        "the held values lie in a gap between the pieces of the codebook or the values of a discrete axis");
  return all;
}

}  // namespace

std::vector<std::optional<ListValues>> list_values(const Codebook& book,
                                                   const std::map<std::string, double>& fixed) {
  std::vector<std::optional<ListValues>> lists(book.parameters().size());
  if (std::ranges::none_of(book.pieces().front().outline().axes, &pgd::Axis::is_list)) return lists;
  const std::vector<std::vector<pgd::Axis>> pieces = axes_of_pieces(book, fixed);
  for (std::size_t k = 0; k < lists.size(); ++k) {
    std::map<double, double> weights;
    for (const std::vector<pgd::Axis>& axes : pieces) {
      if (axes[k].is_list() != pieces.front()[k].is_list())
        throw ArgumentError(
            fmt::format("\"{}\" is a list of values in one piece of the codebook and an interval in another, "
                        "expected one of the two",
                        axes[k].name()));
      // The first piece that has a value says what it counts.
      for (int i = 0; axes[k].is_list() && i < axes[k].size(); ++i)
        weights.emplace(axes[k].nodes()[i], axes[k].weights()[i]);
    }
    if (weights.empty()) continue;
    lists[k] = ListValues{Eigen::VectorXd(std::ssize(weights)), Eigen::VectorXd(std::ssize(weights))};
    Eigen::Index place = 0;
    for (const auto& [value, weight] : weights) {
      lists[k]->values[place] = value;
      lists[k]->weights[place++] = weight;
    }
  }
  return lists;
}

InputDraws draw_inputs(const Codebook& book, const StatisticsRequest& request) {
  const std::span<const Coordinate> coordinates = book.parameters();
  const auto dimensions = static_cast<Eigen::Index>(coordinates.size());
  const Eigen::Index first = book.has_time() ? 1 : 0;
  InputDraws draws;
  draws.points = sobol_points(static_cast<int>(dimensions), request.draws, request.seed);
  const auto find = [&](const std::string& name) {
    return std::ranges::find(coordinates, name, &Coordinate::name) - coordinates.begin();
  };
  if (request.joint) {
    const JointNormal& joint = *request.joint;
    const Eigen::MatrixXd root = root_of(joint);
    Eigen::MatrixXd normal(root.cols(), request.draws);
    for (Eigen::Index k = 0; k < normal.rows(); ++k) {
      normal.row(k) =
          draws.points.row(find(joint.inputs[static_cast<std::size_t>(k)])).unaryExpr([](double share) {
            const double inside = std::clamp(share, 1e-15, 1.0 - 1e-15);
            return quantile_of({DistributionKind::normal, 0.0, 1.0}, inside);
          });
    }
    const Eigen::MatrixXd values = (root * normal).colwise() + joint.mean;
    for (Eigen::Index k = 0; k < values.rows(); ++k)
      draws.points.row(find(joint.inputs[static_cast<std::size_t>(k)])) = values.row(k);
  }
  const std::vector<pgd::Axis> axes = book.pieces().front().outline().axes;
  const std::vector<std::optional<ListValues>> lists = list_values(book, request.fixed);
  for (Eigen::Index k = 0; k < dimensions; ++k) {
    const Coordinate& box = coordinates[static_cast<std::size_t>(k)];
    const pgd::Axis& axis = axes[static_cast<std::size_t>(k + first)];
    if (request.joint && std::ranges::find(request.joint->inputs, box.name) != request.joint->inputs.end()) {
      require_no_list(axis);
      continue;
    }
    auto row = draws.points.row(k);
    if (const auto fixed = request.fixed.find(box.name); fixed != request.fixed.end()) {
      row.setConstant(fixed->second);
      continue;
    }
    const auto given = request.inputs.find(box.name);
    if (given != request.inputs.end()) require_no_list(axis);
    const Distribution distribution = given != request.inputs.end()
                                          ? given->second
                                          : Distribution{DistributionKind::uniform, box.lower, box.upper};
    if (const std::optional<ListValues>& list = lists[static_cast<std::size_t>(k)]) {
      row = row.unaryExpr([&](double share) { return value_of_list(*list, share); });
    } else {
      row = row.unaryExpr([&](double share) { return value_inside(distribution, box, share); });
    }
  }
  if (!request.joint) return draws;
  Eigen::Index kept = 0;
  for (Eigen::Index j = 0; j < draws.points.cols(); ++j) {
    bool is_inside = true;
    for (Eigen::Index k = 0; k < dimensions; ++k) {
      const Coordinate& box = coordinates[static_cast<std::size_t>(k)];
      is_inside = is_inside && draws.points(k, j) >= box.lower && draws.points(k, j) <= box.upper;
    }
    if (is_inside) draws.points.col(kept++) = draws.points.col(j).eval();
  }
  draws.share_inside = static_cast<double>(kept) / static_cast<double>(draws.points.cols());
  draws.points.conservativeResize(Eigen::NoChange, kept);
  return draws;
}

void add_from_draws(const Codebook& book, const StatisticsRequest& request, const InputDraws& draws,
                    BookStatistics& statistics) {
  const Eigen::Index rows = std::max<Eigen::Index>(statistics.times.size(), 1), count = draws.points.cols(),
                     quantiles = static_cast<Eigen::Index>(request.quantiles.size());
  const bool with_moments = request.joint || book.front() != nullptr;  // else they are integrals
  for (OutputStatistics& output : statistics.outputs) {
    output.quantiles.resize(rows, quantiles);
    if (with_moments) {
      output.mean.resize(rows);
      output.deviation.resize(rows);
    }
  }
  const Eigen::Index at_a_time = std::max<Eigen::Index>(1, kMostNumbers / (count * book.output_count()));
  Eigen::VectorXd sorted(count);
  for (Eigen::Index first = 0; first < rows; first += at_a_time) {
    const Eigen::Index block = std::min(at_a_time, rows - first);
    const std::span<const double> times =
        book.has_time() ? std::span(statistics.times.data() + first, static_cast<std::size_t>(block))
                        : std::span<const double>();
    const Eigen::MatrixXd answers = answers_at(book, times, draws.points);
    for (std::size_t o = 0; o < statistics.outputs.size(); ++o) {
      OutputStatistics& output = statistics.outputs[o];
      for (Eigen::Index i = 0; i < block; ++i) {
        sorted = answers.row(static_cast<Eigen::Index>(o) * block + i).transpose();
        if (with_moments) {
          output.mean[first + i] = sorted.mean();
          output.deviation[first + i] =
              std::sqrt((sorted.array() - sorted.mean()).square().sum() / static_cast<double>(count - 1));
        }
        std::sort(sorted.begin(), sorted.end());
        for (Eigen::Index q = 0; q < quantiles; ++q)
          output.quantiles(first + i, q) =
              quantile_of_sorted(sorted, request.quantiles[static_cast<std::size_t>(q)]);
      }
    }
  }
}

}  // namespace samara::codebooks
