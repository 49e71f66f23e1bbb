#include "samara/codebooks/book/certificate_points.h"

#include <algorithm>
#include <set>

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

}  // namespace

std::vector<double> certificate_times(const Codebook& book) {
  std::vector<double> times;
  if (!book.has_time()) return times;
  for (const Piece& piece : book.pieces()) {
    const pgd::Axis& time = piece.groups().front().axes().front();
    const int per_element = 2 * time.degree() + 1;
    for (int e = 0; e < time.elements(); ++e) {
      for (int i = 0; i < per_element; ++i) {
        const double fraction = static_cast<double>(i) / per_element;
        const double left = time.borders()[e];
        const double width = transformed_distance(time.transform(), left, time.borders()[e + 1]);
        times.push_back(transformed_advance(time.transform(), left, fraction * width));
      }
    }
    times.push_back(time.upper());
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

Eigen::MatrixXd certificate_points(const Codebook& book, int count, std::uint64_t seed) {
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
