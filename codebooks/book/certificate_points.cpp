#include "samara/codebooks/book/certificate_points.h"

#include <algorithm>
#include <set>

#include "samara/base/errors.h"
#include "samara/codebooks/book/sobol_points.h"
#include "samara/pgd/axes/axis_transform.h"

namespace samara::codebooks {

namespace {

/// The values of a coordinate that is a list in some piece, ascending; empty for an interval.
std::vector<double> listed_values(const Codebook& book, std::size_t coordinate) {
  std::set<double> values;
  for (const Piece& piece : book.pieces()) {
    const pgd::Axis& axis = piece.groups().front().axes()[coordinate];
    if (axis.is_list()) values.insert(axis.nodes().begin(), axis.nodes().end());
  }
  return {values.begin(), values.end()};
}

/// Equally spaced in every element (under its transform), twice as many as it has nodes, and the end.
void append_points_of_elements(const pgd::Axis& axis, std::vector<double>& points) {
  const int per_element = 2 * axis.degree() + 1;
  for (int e = 0; e < axis.elements(); ++e) {
    for (int i = 0; i < per_element; ++i) {
      const double fraction = static_cast<double>(i) / per_element;
      const double left = axis.borders()[e];
      const double width = transformed_distance(axis.transform(), left, axis.borders()[e + 1]);
      points.push_back(transformed_advance(axis.transform(), left, fraction * width));
    }
  }
  points.push_back(axis.upper());
}

/// The nodes, and the points halfway between neighbours (under the transform): where nodes crowd, as at the ends of
/// elements of high degree, they tell of layers that equally spaced points step over.
void append_nodes_and_midpoints(const pgd::Axis& axis, std::vector<double>& points) {
  const Eigen::VectorXd& nodes = axis.nodes();
  for (Eigen::Index i = 0; i + 1 < nodes.size(); ++i) {
    const double width = transformed_distance(axis.transform(), nodes[i], nodes[i + 1]);
    points.push_back(nodes[i]);
    points.push_back(transformed_advance(axis.transform(), nodes[i], 0.5 * width));
  }
  points.push_back(axis.upper());
}

void sort_out(std::vector<double>& points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
}

}  // namespace

std::vector<double> certificate_times(const Codebook& book) {
  std::vector<double> times;
  if (!book.has_time()) return times;
  for (const Piece& piece : book.pieces())
    append_points_of_elements(piece.groups().front().axes().front(), times);
  sort_out(times);
  return times;
}

Eigen::VectorXd certificate_places(const Codebook& book) {
  const std::optional<int> space = book.space();
  if (!space) throw ArgumentError("the codebook has no coordinate of space, or several; one was expected");
  const auto coordinate = static_cast<std::size_t>(*space);
  std::vector<double> places = listed_values(book, coordinate);
  for (const Piece& piece : book.pieces()) {
    const pgd::Axis& axis = piece.groups().front().axes()[coordinate];
    if (axis.has_elements()) {
      append_nodes_and_midpoints(axis, places);
    } else if (!axis.is_list()) {
      const Eigen::VectorXd all = Eigen::VectorXd::LinSpaced(2 * axis.size() + 1, axis.lower(), axis.upper());
      places.insert(places.end(), all.begin(), all.end());
    }
  }
  sort_out(places);
  return Eigen::Map<const Eigen::VectorXd>(places.data(), static_cast<Eigen::Index>(places.size()));
}

Eigen::MatrixXd certificate_points(const Codebook& book, int count, std::uint64_t seed) {
  if (book.parameters().empty())
    throw ArgumentError("a codebook of time alone has no box, in which points were expected");
  Eigen::MatrixXd q = sobol_points(static_cast<int>(book.parameters().size()), count, seed);
  for (Eigen::Index k = 0; k < q.rows(); ++k) {
    const Coordinate& c = book.parameters()[static_cast<std::size_t>(k)];
    const std::size_t coordinate = static_cast<std::size_t>(k) + (book.has_time() ? 1 : 0);
    const std::vector<double> values = listed_values(book, coordinate);
    for (double& u : q.row(k)) {
      u = values.empty() ? c.lower + u * (c.upper - c.lower)
                         : values[static_cast<std::size_t>(u * static_cast<double>(values.size()))];
    }
  }
  return q;
}

std::pair<Eigen::VectorXd, Eigen::VectorXd> certificate_box(const Codebook& book) {
  const auto d = static_cast<Eigen::Index>(book.parameters().size());
  Eigen::VectorXd lower(d), upper(d);
  for (Eigen::Index k = 0; k < d; ++k) {
    const Coordinate& c = book.parameters()[static_cast<std::size_t>(k)];
    const std::size_t coordinate = static_cast<std::size_t>(k) + (book.has_time() ? 1 : 0);
    lower[k] = c.lower;
    upper[k] = listed_values(book, coordinate).empty() ? c.upper : c.lower;
  }
  return {lower, upper};
}

}  // namespace samara::codebooks
