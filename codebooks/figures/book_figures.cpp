#include "samara/codebooks/figures/book_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/certificate_points.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/codebooks/statistics/book_statistics.h"

namespace samara::codebooks {

namespace {

using io::SvgPanel;
using io::SvgSeries;

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit == "1" ? name : fmt::format("{} [{}]", name, unit);
}

std::string time_label(const Codebook& book) {
  const Coordinate& time = book.time("a picture over time");
  return with_unit(time.name, time.unit);
}

/// Places of outputs by their names; all if there are none.
std::vector<int> places_of(const Codebook& book, const std::vector<std::string>& names) {
  std::vector<int> places;
  for (const std::string& name : names) places.push_back(book.output_index(name));
  for (int o = 0; names.empty() && o < book.output_count(); ++o) places.push_back(o);
  return places;
}

SvgPanel output_panel(const Codebook& book, int output) {
  const pgd::OutputLabel& label = book.outputs()[static_cast<std::size_t>(output)];
  return {.title = label.name,
          .x_label = time_label(book),
          .y_label = with_unit(label.name, label.unit),
          .series = {}};
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The same point in the order of a family.
std::vector<double> in_order_of(const models::TrajectoryFamily& family, const Codebook& book,
                                const Eigen::VectorXd& q) {
  std::vector<double> point;
  for (const models::FamilyCoordinate& c : family.info().coordinates)
    point.push_back(q[book.coordinate_index(c.name) - 1]);
  return point;
}

/// Values of both at the times, for every point that could be integrated.
struct Compared {
  std::vector<Eigen::MatrixXd> book, reference;
};

Compared compare(const Codebook& book, const std::vector<double>& times,
                 const std::vector<std::string>& names, const Eigen::MatrixXd& points) {
  const auto ours = codebook_trajectories(book);
  const auto theirs = reference_trajectories(book);
  Compared compared;
  std::string failure;
  for (const auto& point : points.colwise()) {
    const models::FamilyTrajectory a =
        models::trajectory(*ours, in_order_of(*ours, book, point), times, names);
    const models::FamilyTrajectory b =
        models::trajectory(*theirs, in_order_of(*theirs, book, point), times, names);
    if (!a.outcome || !b.outcome) {
      failure = a.outcome ? b.outcome.message : a.outcome.message;
      continue;
    }
    compared.book.push_back(a.values);
    compared.reference.push_back(b.values);
  }
  if (compared.book.empty()) throw NoResultError(fmt::format("no point could be compared: {}", failure));
  return compared;
}

}  // namespace

Eigen::VectorXd middle_of_box(const Codebook& book) {
  Eigen::VectorXd q(std::ssize(book.parameters()));
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const Coordinate& c = book.parameters()[static_cast<std::size_t>(k)];
    const double middle = 0.5 * (c.lower + c.upper);
    q[k] = middle;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Piece& piece : book.pieces()) {
      const pgd::Axis& axis =
          piece.groups().front().axes()[static_cast<std::size_t>(book.coordinate_index(c.name))];
      if (!axis.is_list()) continue;
      for (const double node : axis.nodes()) {
        if (std::abs(node - middle) >= nearest) continue;
        nearest = std::abs(node - middle);
        q[k] = node;
      }
    }
  }
  return q;
}

std::vector<SvgPanel> trajectory_panels(const Codebook& book, const Eigen::VectorXd& q,
                                        const std::vector<std::string>& outputs) {
  const Coordinate& time = book.time("a picture over time");
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(301, time.lower, time.upper);
  TrajectoryQuery query(book, {times.begin(), times.end()});
  Eigen::MatrixXd values(times.size(), book.output_count());
  query.values({q.data(), static_cast<std::size_t>(q.size())}, values);
  std::vector<SvgPanel> panels;
  for (const int o : places_of(book, outputs)) {
    panels.push_back(output_panel(book, o));
    panels.back().series.push_back({.name = {}, .x = times, .y = values.col(o)});
  }
  return panels;
}

std::vector<SvgPanel> error_panels(const Codebook& book, int points, std::uint64_t seed,
                                   const std::vector<std::string>& outputs) {
  if (points < 1) throw ArgumentError(fmt::format("the number of points is {}, expected at least 1", points));
  book.time("a picture over time");
  const std::vector<int> places = places_of(book, outputs);
  std::vector<std::string> names;
  for (const int o : places) names.push_back(book.outputs()[static_cast<std::size_t>(o)].name);
  std::vector<double> times = certificate_times(book);
  const Compared compared = compare(book, times, names, certificate_points(book, points, seed));
  const Eigen::VectorXd t = Eigen::Map<const Eigen::VectorXd>(times.data(), std::ssize(times));
  std::vector<SvgPanel> panels;
  for (Eigen::Index k = 0; k < std::ssize(places); ++k) {
    double lower = std::numeric_limits<double>::infinity(), upper = -lower;
    for (const Eigen::MatrixXd& values : compared.reference) {
      lower = std::min(lower, values.col(k).minCoeff());
      upper = std::max(upper, values.col(k).maxCoeff());
    }
    double range = upper - lower;
    if (book.certificate()) {
      const auto& errors = book.certificate()->outputs;
      const auto error = std::ranges::find(errors, names[static_cast<std::size_t>(k)], &OutputError::name);
      if (error != errors.end()) range = error->range;
    }
    Eigen::VectorXd largest(t.size()), median(t.size());
    for (Eigen::Index i = 0; i < t.size(); ++i) {
      std::vector<double> errors;
      for (std::size_t p = 0; p < compared.book.size(); ++p)
        errors.push_back(std::abs(compared.book[p](i, k) - compared.reference[p](i, k)) / range);
      largest[i] = *std::ranges::max_element(errors);
      median[i] = median_of(std::move(errors));
    }
    panels.push_back(output_panel(book, places[static_cast<std::size_t>(k)]));
    panels.back().y_label = "error, of the range";
    panels.back().has_log_y = true;
    panels.back().series = {
        {.name = fmt::format("largest of {}", compared.book.size()), .x = t, .y = largest},
        {.name = "median", .x = t, .y = median, .kind = SvgSeries::Kind::dashes, .colour = 1}};
    if (book.certificate()) panels.back().rules = {{.at = book.certificate()->tolerance}};
  }
  return panels;
}

std::vector<SvgPanel> rank_panels(const Codebook& book) {
  const std::string label = time_label(book);
  std::set<double> borders;
  struct Outlined {
    double lower, upper, rank, numbers;
  };
  std::vector<Outlined> pieces;
  for (const Piece& piece : book.pieces()) {
    Outlined outlined{piece.lower().front(), piece.upper().front(), 0.0, 0.0};
    for (const GroupOutline& group : piece.outline().groups) {
      for (const int rank : group.ranks) outlined.rank = std::max(outlined.rank, static_cast<double>(rank));
      outlined.numbers += static_cast<double>(group.entries);
    }
    borders.insert({outlined.lower, outlined.upper});
    pieces.push_back(outlined);
  }
  // Steps: each slab has both of its ends.
  const std::vector<double> ends(borders.begin(), borders.end());
  const auto slabs = std::ssize(ends) - 1;
  Eigen::VectorXd t(2 * slabs), rank = Eigen::VectorXd::Zero(2 * slabs), numbers = rank;
  for (Eigen::Index s = 0; s < slabs; ++s) {
    t[2 * s] = ends[static_cast<std::size_t>(s)];
    t[2 * s + 1] = ends[static_cast<std::size_t>(s + 1)];
    for (const Outlined& piece : pieces) {
      if (piece.lower > t[2 * s] || piece.upper < t[2 * s + 1]) continue;
      rank[2 * s] = rank[2 * s + 1] = std::max(rank[2 * s], piece.rank);
      numbers[2 * s] = numbers[2 * s + 1] = numbers[2 * s] + piece.numbers;
    }
  }
  return {{.title = "Largest rank",
           .x_label = label,
           .y_label = "rank",
           .series = {{.name = {}, .x = t, .y = rank}},
           .from_zero = true},
          {.title = "Numbers stored",
           .x_label = label,
           .y_label = "in the slab",
           .series = {{.name = {}, .x = t, .y = numbers}},
           .from_zero = true}};
}

std::vector<SvgPanel> index_panels(const Codebook& book, const std::vector<std::string>& outputs) {
  const std::string label = time_label(book);
  const std::vector<int> places = places_of(book, outputs);
  const BookStatistics statistics = take_statistics(book);
  if (statistics.inputs.empty()) {
    throw NoResultError(statistics.notes.empty() ? "there are no indices of this codebook"
                                                 : statistics.notes.front());
  }
  std::vector<SvgPanel> panels;
  for (const int o : places) {
    const OutputStatistics& output = statistics.outputs[static_cast<std::size_t>(o)];
    panels.push_back({.title = output.name,
                      .x_label = label,
                      .y_label = "share of the variance",
                      .series = {},
                      .from_zero = true});
    for (std::size_t k = 0; k < statistics.inputs.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      const int colour = static_cast<int>(k);
      panels.back().series.push_back({.name = statistics.inputs[k],
                                      .x = statistics.times,
                                      .y = output.first_order.col(column),
                                      .colour = colour});
      panels.back().series.push_back({.name = statistics.inputs[k] + ", total",
                                      .x = statistics.times,
                                      .y = output.total.col(column),
                                      .kind = SvgSeries::Kind::dashes,
                                      .colour = colour});
    }
  }
  return panels;
}

}  // namespace samara::codebooks
