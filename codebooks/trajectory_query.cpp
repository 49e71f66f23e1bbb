#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/box.h"
#include "samara/codebooks/query.h"

namespace samara::codebooks {

namespace {
/// Places of the chosen outputs, -1 for those not chosen.
/// @throws ArgumentError for one that is unknown or chosen twice
std::vector<int> columns_of(const Codebook& book, const std::vector<std::string>& outputs) {
  std::vector<int> column(static_cast<std::size_t>(book.output_count()), -1);
  if (outputs.empty()) {
    for (std::size_t o = 0; o < column.size(); ++o) column[o] = static_cast<int>(o);
  }
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    int& place = column[static_cast<std::size_t>(book.output_index(outputs[o]))];
    if (place >= 0) throw ArgumentError(fmt::format("output \"{}\" is chosen twice", outputs[o]));
    place = static_cast<int>(o);
  }
  return column;
}

GroupAtTimes at_times(const FieldGroup& group, const std::vector<double>& times,
                      const std::vector<int>& outputs) {
  if (const pgd::TrainField* train = group.train()) return TrainAtTimes(*train, times, outputs);
  return SumAtTimes(*group.sum(), times, outputs);
}
}  // namespace

TrajectoryQuery::TrajectoryQuery(const Codebook& book, std::vector<double> times,
                                 const std::vector<std::string>& outputs)
    : book_(book), times_(std::move(times)), answered_(times_.size()) {
  book.time("a query of trajectories");
  for (const double t : times_) require_inside(std::span(book.coordinates()).first(1), std::span(&t, 1));
  const std::vector<int> column = columns_of(book, outputs);
  output_count_ = outputs.empty() ? book.output_count() : static_cast<int>(outputs.size());
  for (const Piece& piece : book.pieces()) {
    int output = 0;
    for (const FieldGroup& field : piece.groups) {
      std::vector<int> rows, columns, field_outputs;
      for (int o = 0; o < field.output_count(); ++o, ++output) {
        if (column[static_cast<std::size_t>(output)] < 0) continue;
        field_outputs.push_back(o);
        columns.push_back(column[static_cast<std::size_t>(output)]);
      }
      std::vector<double> held;
      for (std::size_t i = 0; i < times_.size(); ++i) {
        if (!field.axes().front().contains(times_[i])) continue;
        rows.push_back(static_cast<int>(i));
        held.push_back(times_[i]);
      }
      if (columns.empty() || rows.empty()) continue;
      Eigen::MatrixXd result(static_cast<Eigen::Index>(rows.size()),
                             static_cast<Eigen::Index>(columns.size()));
      parts_.push_back({std::span(field.axes()).subspan(1), std::move(rows), std::move(columns),
                        at_times(field, held, field_outputs), std::move(result)});
    }
  }
}

void TrajectoryQuery::check(std::span<const double> q) const {
  require_inside(std::span(book_.coordinates()).subspan(1), q);
}

void TrajectoryQuery::Part::copy_result(Eigen::Ref<Eigen::MatrixXd> target, Eigen::Index first_column) const {
  for (std::size_t o = 0; o < columns.size(); ++o) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      target(rows[i], first_column + columns[o]) =
          result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(o));
    }
  }
}

void TrajectoryQuery::values(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values) {
  check(q);
  require_size("values", size_of(values), {time_count(), output_count_});
  std::fill(answered_.begin(), answered_.end(), char{0});
  // Pieces are visited from the last to the first, so that at a border the lower piece has the last word.
  for (std::size_t p = parts_.size(); p-- > 0;) {
    Part& part = parts_[p];
    if (!contains(part.axes, q)) continue;
    std::visit(
        [&](auto& group) {
          group.load(q, false);
          group.values(part.result);
        },
        part.group);
    for (const int row : part.rows) answered_[static_cast<std::size_t>(row)] = 1;
    part.copy_result(values, 0);
  }
  const auto missing = std::find(answered_.begin(), answered_.end(), char{0});
  if (missing == answered_.end()) return;
  throw OutsideBoxError(fmt::format("at t = {} the point lies in a gap between the pieces of the codebook",
                                    times_[static_cast<std::size_t>(missing - answered_.begin())]));
}

void TrajectoryQuery::values(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values,
                             Eigen::Ref<Eigen::MatrixXd> derivatives) {
  require_size("derivatives", size_of(derivatives), {time_count(), output_count_ * parameter_count()});
  this->values(q, values);
  for (std::size_t p = parts_.size(); p-- > 0;) {
    Part& part = parts_[p];
    if (!contains(part.axes, q)) continue;
    std::visit([&](auto& group) { group.load(q, true); }, part.group);
    for (Eigen::Index k = 0; k < parameter_count(); ++k) {
      std::visit([&](auto& group) { group.derivative(k, part.result); }, part.group);
      part.copy_result(derivatives, output_count_ * k);
    }
  }
}

}  // namespace samara::codebooks
