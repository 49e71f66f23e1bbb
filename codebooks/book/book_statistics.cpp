#include "samara/codebooks/book/book_statistics.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/fields/field.h"
#include "samara/pgd/fields/statistics.h"

namespace samara::codebooks {

namespace {

/// Whether pieces are slabs of time, each over the whole box.
bool has_whole_pieces(const Codebook& book) {
  const std::size_t first = book.has_time() ? 1 : 0;
  for (const Piece& piece : book.pieces()) {
    for (std::size_t k = first; k < book.coordinates().size(); ++k) {
      const Coordinate& c = book.coordinates()[k];
      if (piece.lower()[k] != c.lower || piece.upper()[k] != c.upper) return false;
    }
  }
  return true;
}

pgd::Statistics group_statistics(const FieldGroup& group, bool has_time) {
  const pgd::StatisticsOptions options{.free_axis = has_time ? group.axes().front().name() : ""};
  return pgd::statistics(group, options);
}

/// Appends the columns of `from` to the rows that are there.
void append(Eigen::VectorXd& rows, const Eigen::RowVectorXd& columns, Eigen::Index from) {
  const Eigen::Index before = rows.size(), more = columns.size() - from;
  rows.conservativeResize(before + more);
  rows.tail(more) = columns.tail(more).transpose();
}

BookStatistics statistics_of_slabs(const Codebook& book) {
  BookStatistics result;
  for (const pgd::OutputLabel& output : book.outputs())
    result.outputs.push_back({output.name, output.unit, {}, {}, {}, {}});
  for (std::size_t p = 0; p < book.pieces().size(); ++p) {
    // The lower piece answers where two of them meet.
    const Eigen::Index from = p > 0 ? 1 : 0;
    std::size_t place = 0;
    for (const FieldGroup& group : book.pieces()[p].groups()) {
      const pgd::Statistics s = group_statistics(group, book.has_time());
      result.inputs = s.inputs;
      if (place == 0 && book.has_time()) append(result.times, s.free_nodes.transpose(), from);
      for (Eigen::Index o = 0; o < s.mean.rows(); ++o, ++place) {
        OutputStatistics& output = result.outputs[place];
        append(output.mean, s.mean.row(o), from);
        append(output.deviation, s.variance.row(o).cwiseSqrt(), from);
        const Eigen::Index before = output.first_order.rows(), more = s.mean.cols() - from;
        const auto inputs = static_cast<Eigen::Index>(s.inputs.size());
        output.first_order.conservativeResize(before + more, inputs);
        output.total.conservativeResize(before + more, inputs);
        for (Eigen::Index k = 0; k < inputs; ++k) {
          const auto input = static_cast<std::size_t>(k);
          output.first_order.col(k).tail(more) = s.first_order[input].row(o).tail(more).transpose();
          output.total.col(k).tail(more) = s.total[input].row(o).tail(more).transpose();
        }
      }
    }
  }
  return result;
}

/// Of a group at one time, over its own part of the box.
pgd::Statistics statistics_at(const FieldGroup& group, double t) {
  return pgd::statistics(pgd::restricted(group, group.axes().front().name(), t));
}

/// Times of all pieces, each once.
std::vector<double> times_of(const Codebook& book) {
  std::vector<double> times;
  for (const Piece& piece : book.pieces()) {
    const Eigen::VectorXd& nodes = piece.groups().front().axes().front().nodes();
    times.insert(times.end(), nodes.begin(), nodes.end());
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

/// The part of the box of parameters that is a piece's.
double share_of(const Codebook& book, const Piece& piece) {
  double share = 1.0;
  for (std::size_t k = 1; k < book.coordinates().size(); ++k) {
    const Coordinate& whole = book.coordinates()[k];
    share *= (piece.upper()[k] - piece.lower()[k]) / (whole.upper - whole.lower);
  }
  return share;
}

/// The pieces that answer at a time, one per cell: of those that meet there the lower one, which comes first.
std::vector<const Piece*> cells_at(const Codebook& book, double t) {
  std::vector<const Piece*> cells;
  for (const Piece& piece : book.pieces()) {
    const auto same_cell = [&](const Piece* other) {
      return std::equal(piece.lower().begin() + 1, piece.lower().end(), other->lower().begin() + 1) &&
             std::equal(piece.upper().begin() + 1, piece.upper().end(), other->upper().begin() + 1);
    };
    if (t >= piece.lower()[0] && t <= piece.upper()[0] && std::ranges::none_of(cells, same_cell))
      cells.push_back(&piece);
  }
  return cells;
}

/// Of all outputs at one time.
struct MomentsAtTime {
  Eigen::VectorXd mean, variance;
};

MomentsAtTime moments_of(const Piece& piece, double t) {
  MomentsAtTime moments;
  for (const FieldGroup& group : piece.groups()) {
    const pgd::Statistics s = statistics_at(group, t);
    append(moments.mean, s.mean.transpose(), 0);
    append(moments.variance, s.variance.transpose(), 0);
  }
  return moments;
}

/// A box that is split into cells: means and variances of the parts, weighted by their volumes. Conditional
/// means, of which the indices are made, would have to be put together along the coordinates.
BookStatistics statistics_of_cells(const Codebook& book) {
  book.time("the statistics of a split box");
  const std::vector<double> times = times_of(book);
  BookStatistics result;
  result.times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(result.times.size());
  for (const pgd::OutputLabel& output : book.outputs())
    result.outputs.push_back({output.name, output.unit, none, none, {}, {}});
  for (Eigen::Index i = 0; i < result.times.size(); ++i) {
    const double t = result.times[i];
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(book.output_count()), variance = mean;
    double weight = 0.0;
    for (const Piece* piece : cells_at(book, t)) {
      const MomentsAtTime part = moments_of(*piece, t);
      const double share = share_of(book, *piece), before = weight;
      weight += share;
      // Of two parts with weights a and b: (a V_1 + b V_2)/(a + b) + a b/(a + b)^2 (m_1 - m_2)^2.
      const Eigen::VectorXd apart = part.mean - mean;
      variance = (before * variance + share * part.variance) / weight +
                 before * share / (weight * weight) * apart.cwiseAbs2();
      mean += share / weight * apart;
    }
    for (std::size_t o = 0; o < result.outputs.size(); ++o) {
      result.outputs[o].mean[i] = mean[static_cast<Eigen::Index>(o)];
      result.outputs[o].deviation[i] = std::sqrt(variance[static_cast<Eigen::Index>(o)]);
    }
  }
  return result;
}

/// An error of the field moves its indices by about twice its share of the deviation. Where the deviation is not so
/// many times the largest error that the certificate has found, they may be the field's rather than the output's.
constexpr double kResolved = 2.0;

/// Takes indices away where the certificate does not stand for them.
void leave_out_unresolved(const Codebook& book, BookStatistics& s) {
  if (!book.certificate() || s.inputs.empty()) return;
  for (OutputStatistics& output : s.outputs) {
    const auto certified = std::ranges::find(book.certificate()->outputs, output.name, &OutputError::name);
    if (certified == book.certificate()->outputs.end()) continue;
    Eigen::Index left_out = 0;
    for (Eigen::Index i = 0; i < output.deviation.size(); ++i) {
      // Where the certificate has no number, nothing is resolved.
      if (output.deviation[i] >= kResolved * certified->max_si) continue;
      output.first_order.row(i).setConstant(std::nan(""));
      output.total.row(i).setConstant(std::nan(""));
      ++left_out;
    }
    if (left_out == 0) continue;
    s.notes.push_back(fmt::format(
        "Sobol' indices of {} are left out at {} of {} {}: its deviation there is below {:g} times the "
        "certificate's largest error, {:.3g} {}",
        output.name, left_out, output.deviation.size(), book.has_time() ? "times" : "rows", kResolved,
        certified->max_si, output.unit));
  }
}

}  // namespace

BookStatistics statistics_of(const Codebook& book) {
  if (book.coordinate_count() == (book.has_time() ? 1 : 0))
    throw ArgumentError("the codebook has no free parameter to take statistics over");
  BookStatistics result;
  if (has_whole_pieces(book)) {
    result = statistics_of_slabs(book);
  } else {
    result = statistics_of_cells(book);
    result.warnings.emplace_back("the box is split into cells: mean and deviation only, no Sobol' indices");
  }
  leave_out_unresolved(book, result);
  return result;
}

}  // namespace samara::codebooks
