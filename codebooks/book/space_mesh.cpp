#include "samara/codebooks/book/space_mesh.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/base/units.h"

namespace samara::codebooks {

namespace {

/// Edges from the first corner: directions x (corners - 1).
Eigen::MatrixXd edges_of(const Eigen::MatrixXd& points, const Eigen::MatrixXi& cells, Eigen::Index cell) {
  Eigen::MatrixXd edges(points.rows(), cells.rows() - 1);
  for (Eigen::Index c = 1; c < cells.rows(); ++c)
    edges.col(c - 1) = points.col(cells(c, cell)) - points.col(cells(0, cell));
  return edges;
}

void check_shape(const std::vector<std::string>& directions, const Eigen::MatrixXd& points,
                 const Eigen::MatrixXi& cells) {
  const auto d = static_cast<Eigen::Index>(directions.size());
  const std::set<std::string> names(directions.begin(), directions.end());
  if (d < 1 || d > 3 || names.size() != directions.size() || names.contains(""))
    throw ArgumentError(
        fmt::format("a mesh with {} directions, expected one to three with names that differ", d));
  for (const std::string& name : directions) {
    if (printable(name) != name || name.find('=') != std::string::npos) {
      throw ArgumentError(fmt::format(
          "a direction of a mesh has the name {}, expected one without \"=\" and control characters",
          in_quotes(name)));
    }
  }
  if (points.rows() != d || points.cols() == 0) {
    throw ArgumentError(fmt::format("the points of a mesh are {} x {}, expected {} directions x nodes",
                                    points.rows(), points.cols(), d));
  }
  if (cells.rows() != d + 1 || cells.cols() == 0) {
    throw ArgumentError(
        fmt::format("the cells of a mesh are {} x {}, expected {} corners x cells in {} directions",
                    cells.rows(), cells.cols(), d + 1, d));
  }
  const Eigen::VectorXd extent = points.rowwise().maxCoeff() - points.rowwise().minCoeff();
  if (!points.allFinite() || !extent.allFinite())
    throw ArgumentError("a point of a mesh is not finite, or too far from another");
}

void check_cells(const Eigen::MatrixXd& points, const Eigen::MatrixXi& cells) {
  for (Eigen::Index cell = 0; cell < cells.cols(); ++cell) {
    for (const int node : cells.col(cell)) {
      if (node >= 0 && node < points.cols()) continue;
      throw ArgumentError(fmt::format("cell {} of a mesh has the corner {}, expected a node from 0 to {}",
                                      cell, node, points.cols() - 1));
    }
    const Eigen::MatrixXd edges = edges_of(points, cells, cell);
    const Eigen::MatrixXd shape = edges / edges.cwiseAbs().maxCoeff();
    const double size = std::pow(shape.colwise().norm().maxCoeff(), static_cast<double>(edges.cols()));
    constexpr double kFlat = 1e-12;
    if (!(std::abs(shape.determinant()) > kFlat * size))
      throw ArgumentError(fmt::format("cell {} of a mesh has no volume", cell));
  }
  // A share of it must be no zero.
  constexpr double kSmallest = 1e-290;
  const double extent = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).minCoeff();
  if (extent < kSmallest)
    throw ArgumentError(fmt::format("a mesh has the extent {}, expected at least {}", extent, kSmallest));
}

}  // namespace

SpaceMesh::SpaceMesh(std::vector<std::string> directions, std::string unit, Eigen::MatrixXd points,
                     Eigen::MatrixXi cells) {
  check_shape(directions, points, cells);
  parse_unit(unit);
  check_cells(points, cells);
  const auto content = std::make_shared<Content>();
  content->directions = std::move(directions);
  content->unit = std::move(unit);
  content->points = std::move(points);
  content->cells = std::move(cells);
  content_ = content;
}

const SpaceMesh::Bins& SpaceMesh::bins() const {
  const Content& content = *content_;
  std::call_once(content.has_bins, [&] { content.bins = bins_of(content.points, content.cells); });
  return content.bins;
}

SpaceMesh::Bins SpaceMesh::bins_of(const Eigen::MatrixXd& points, const Eigen::MatrixXi& cells) {
  const Eigen::Index d = points.rows();
  const double per_direction = std::pow(static_cast<double>(cells.cols()), 1.0 / static_cast<double>(d));
  // Cells of a mesh touch a few boxes each; where they lie over each other in heaps, fewer boxes must do.
  const auto most = 64 * static_cast<std::size_t>(cells.cols()) + 1'000'000;
  Bins bins;
  bins.lower = points.rowwise().minCoeff();
  bins.counts = Eigen::VectorXi::Constant(d, std::max(1, static_cast<int>(per_direction)));
  const Eigen::VectorXd extent = points.rowwise().maxCoeff() - bins.lower;
  for (;; bins.counts = (bins.counts / 2).cwiseMax(1)) {
    bins.width = extent.cwiseQuotient(bins.counts.cast<double>());
    if (fill(bins, points, cells, most)) return bins;
  }
}

bool SpaceMesh::fill(Bins& bins, const Eigen::MatrixXd& points, const Eigen::MatrixXi& cells,
                     std::size_t most) {
  const Eigen::Index d = points.rows();
  bins.cells.assign(static_cast<std::size_t>(bins.counts.prod()), {});
  std::size_t entries = 0;
  for (int cell = 0; cell < cells.cols(); ++cell) {
    Eigen::VectorXi first(d), last(d);
    for (Eigen::Index k = 0; k < d; ++k) {
      double low = points(k, cells(0, cell)), high = low;
      for (const int node : cells.col(cell)) {
        low = std::min(low, points(k, node));
        high = std::max(high, points(k, node));
      }
      // A point on the border of two boxes may be rounded into either.
      constexpr double kMargin = 1e-6;
      const auto box = [&](double x) {
        return std::clamp(static_cast<int>(std::floor((x - bins.lower[k]) / bins.width[k])), 0,
                          bins.counts[k] - 1);
      };
      first[k] = box(low - kMargin * bins.width[k]);
      last[k] = box(high + kMargin * bins.width[k]);
    }
    Eigen::VectorXi at = first;
    for (bool is_left = true; is_left;) {
      if (++entries > most) return false;
      int place = 0;
      for (Eigen::Index k = d - 1; k >= 0; --k) place = place * bins.counts[k] + at[k];
      bins.cells[static_cast<std::size_t>(place)].push_back(cell);
      is_left = false;
      for (Eigen::Index k = 0; k < d && !is_left; ++k) {
        is_left = at[k] < last[k];
        at[k] = is_left ? at[k] + 1 : first[k];
      }
    }
  }
  return true;
}

std::optional<SpaceMesh::Place> SpaceMesh::find(std::span<const double> point) const {
  const Eigen::Index d = points().rows();
  if (static_cast<Eigen::Index>(point.size()) != d)
    throw ArgumentError(fmt::format("a point of a mesh has {} numbers, expected {}", point.size(), d));
  const Eigen::Map<const Eigen::VectorXd> x(point.data(), d);
  if (!x.allFinite()) throw ArgumentError("a point of a mesh has a number that is not finite");
  const Bins& bins = this->bins();
  int place = 0;
  for (Eigen::Index k = d - 1; k >= 0; --k) {
    const double box = std::floor((x[k] - bins.lower[k]) / bins.width[k]);
    place = place * bins.counts[k] + static_cast<int>(std::clamp(box, 0.0, bins.counts[k] - 1.0));
  }
  constexpr double kRounding = 1e-9;
  for (const int cell : bins.cells[static_cast<std::size_t>(place)]) {
    const Eigen::MatrixXd edges = edges_of(points(), cells(), cell);
    const double size = edges.cwiseAbs().maxCoeff();
    const Eigen::MatrixXd inverse = (edges / size).inverse() / size;
    const Eigen::VectorXd inner = inverse * (x - points().col(cells()(0, cell)));
    Eigen::VectorXd weights(d + 1);
    weights << 1.0 - inner.sum(), inner;
    if (!(weights.minCoeff() >= -kRounding)) continue;
    Place found;
    for (const int node : cells().col(cell)) found.nodes.push_back(node);
    found.weights = std::move(weights);
    found.slopes.resize(d + 1, d);
    found.slopes << -inverse.colwise().sum(), inverse;
    return found;
  }
  return {};
}

}  // namespace samara::codebooks
