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
}  // namespace

TrajectoryQuery::TrajectoryQuery(const Codebook& book, std::vector<double> times,
                                 const std::vector<std::string>& outputs)
    : book_(book), times_(std::move(times)), answered_(times_.size()) {
  for (const double t : times_) require_inside(std::span(book.coordinates()).first(1), std::span(&t, 1));
  const std::vector<int> column = columns_of(book, outputs);
  output_count_ = outputs.empty() ? book.output_count() : static_cast<int>(outputs.size());
  for (const Piece& piece : book.pieces()) {
    int output = 0;
    for (const pgd::SeparatedField& field : piece.groups) {
      Part part;
      part.field = &field;
      for (int o = 0; o < field.output_count(); ++o, ++output) {
        if (column[static_cast<std::size_t>(output)] < 0) continue;
        part.field_outputs.push_back(o);
        part.columns.push_back(column[static_cast<std::size_t>(output)]);
      }
      for (std::size_t i = 0; i < times_.size(); ++i) {
        if (field.axes().front().contains(times_[i])) part.rows.push_back(static_cast<int>(i));
      }
      if (part.columns.empty() || part.rows.empty()) continue;
      const Eigen::Index rank = field.rank();
      const auto rows = static_cast<Eigen::Index>(part.rows.size());
      const auto chosen = static_cast<Eigen::Index>(part.columns.size());
      pgd::InterpolationStencil stencil = field.axes().front().make_stencil();
      Eigen::VectorXd factor(rank);
      part.time_factors.resize(rows, rank);
      for (Eigen::Index i = 0; i < rows; ++i) {
        field.factor_values(0, times_[static_cast<std::size_t>(part.rows[static_cast<std::size_t>(i)])],
                            stencil, factor);
        part.time_factors.row(i) = factor.transpose();
      }
      part.weights = field.weights()(part.field_outputs, Eigen::all).transpose();
      for (int k = 1; k < field.axis_count(); ++k) {
        part.stencils.push_back(field.axes()[static_cast<std::size_t>(k)].make_stencil());
      }
      part.factor_values.resize(rank, field.axis_count() - 1);
      part.factor_derivatives.resize(rank, field.axis_count() - 1);
      part.product.resize(rank);
      part.scaled_weights.resize(rank, chosen);
      part.result.resize(rows, chosen);
      parts_.push_back(std::move(part));
    }
  }
}

void TrajectoryQuery::Part::sum_terms() {
  scaled_weights = weights.array().colwise() * product.array();
  // Output by output: the product of two matrices would take scratch memory when it is large, and is not
  // faster for the few outputs there are.
  for (Eigen::Index o = 0; o < result.cols(); ++o)
    result.col(o).noalias() = time_factors * scaled_weights.col(o);
}

void TrajectoryQuery::check(std::span<const double> q) const {
  require_inside(std::span(book_.coordinates()).subspan(1), q);
}

void TrajectoryQuery::values(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values) {
  check(q);
  require_size("values", size_of(values), {time_count(), output_count_});
  std::fill(answered_.begin(), answered_.end(), char{0});
  // Pieces are visited from the last to the first, so that at a border the lower piece has the last word.
  for (std::size_t p = parts_.size(); p-- > 0;) {
    Part& part = parts_[p];
    if (!contains(std::span(part.field->axes()).subspan(1), q)) continue;
    part.product.setOnes();
    for (Eigen::Index k = 0; k < part.factor_values.cols(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      part.field->factor_values(static_cast<int>(k) + 1, q[i], part.stencils[i], part.factor_values.col(k));
      part.product.array() *= part.factor_values.col(k).array();
    }
    part.sum_terms();
    for (const int row : part.rows) answered_[static_cast<std::size_t>(row)] = 1;
    for (std::size_t o = 0; o < part.columns.size(); ++o) {
      for (std::size_t i = 0; i < part.rows.size(); ++i) {
        values(part.rows[i], part.columns[o]) =
            part.result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(o));
      }
    }
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
    if (!contains(std::span(part.field->axes()).subspan(1), q)) continue;
    for (Eigen::Index k = 0; k < part.factor_values.cols(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      part.field->factor_values(static_cast<int>(k) + 1, q[i], part.stencils[i], part.factor_values.col(k),
                                part.factor_derivatives.col(k));
    }
    for (Eigen::Index k = 0; k < part.factor_values.cols(); ++k) {
      part.product = part.factor_derivatives.col(k);
      for (Eigen::Index other = 0; other < part.factor_values.cols(); ++other) {
        if (other != k) part.product.array() *= part.factor_values.col(other).array();
      }
      part.sum_terms();
      for (std::size_t o = 0; o < part.columns.size(); ++o) {
        const Eigen::Index column = part.columns[o] + Eigen::Index{output_count_} * k;
        for (std::size_t i = 0; i < part.rows.size(); ++i) {
          derivatives(part.rows[i], column) =
              part.result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(o));
        }
      }
    }
  }
}

}  // namespace samara::codebooks
