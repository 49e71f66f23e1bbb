#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "commands.h"
#include "output.h"
#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/io/csv.h"
#include "samara/pgd/fields/field.h"
#include "samara/pgd/fields/statistics.h"
#include "terminal.h"

namespace samara::apps {

namespace {

using codebooks::Codebook;

/// Of one output: rows are times, or one where there is none.
struct OutputStatistics {
  std::string name, unit;
  Eigen::VectorXd mean, deviation;
  Eigen::MatrixXd first_order, total;  ///< times x inputs
};

struct BookStatistics {
  std::vector<std::string> inputs;  ///< that there are indices of
  Eigen::VectorXd times;            ///< empty where there is none
  std::vector<OutputStatistics> outputs;
};

/// Whether pieces are slabs of time, each over the whole box.
bool has_whole_pieces(const Codebook& book) {
  const std::size_t first = book.has_time() ? 1 : 0;
  for (const codebooks::Piece& piece : book.pieces()) {
    for (std::size_t k = first; k < book.coordinates().size(); ++k) {
      const codebooks::Coordinate& c = book.coordinates()[k];
      if (piece.lower()[k] != c.lower || piece.upper()[k] != c.upper) return false;
    }
  }
  return true;
}

pgd::Statistics statistics_of(const codebooks::FieldGroup& group, bool has_time) {
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
    for (const codebooks::FieldGroup& group : book.pieces()[p].groups()) {
      const pgd::Statistics s = statistics_of(group, book.has_time());
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
pgd::Statistics statistics_at(const codebooks::FieldGroup& group, double t) {
  return pgd::statistics(pgd::restricted(group, group.axes().front().name(), t));
}

/// Times of all pieces, each once.
std::vector<double> times_of(const Codebook& book) {
  std::vector<double> times;
  for (const codebooks::Piece& piece : book.pieces()) {
    const Eigen::VectorXd& nodes = piece.groups().front().axes().front().nodes();
    times.insert(times.end(), nodes.begin(), nodes.end());
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

/// The part of the box of parameters that is a piece's.
double share_of(const Codebook& book, const codebooks::Piece& piece) {
  double share = 1.0;
  for (std::size_t k = 1; k < book.coordinates().size(); ++k) {
    const codebooks::Coordinate& whole = book.coordinates()[k];
    share *= (piece.upper()[k] - piece.lower()[k]) / (whole.upper - whole.lower);
  }
  return share;
}

/// The pieces that answer at a time, one per cell: of those that meet there the lower one, which comes first.
std::vector<const codebooks::Piece*> cells_at(const Codebook& book, double t) {
  std::vector<const codebooks::Piece*> cells;
  for (const codebooks::Piece& piece : book.pieces()) {
    const auto same_cell = [&](const codebooks::Piece* other) {
      return std::equal(piece.lower().begin() + 1, piece.lower().end(), other->lower().begin() + 1) &&
             std::equal(piece.upper().begin() + 1, piece.upper().end(), other->upper().begin() + 1);
    };
    if (t >= piece.lower()[0] && t <= piece.upper()[0] && std::ranges::none_of(cells, same_cell))
      cells.push_back(&piece);
  }
  return cells;
}

/// Of all outputs at one time.
struct Moments {
  Eigen::VectorXd mean, variance;
};

Moments moments_of(const codebooks::Piece& piece, double t) {
  Moments moments;
  for (const codebooks::FieldGroup& group : piece.groups()) {
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
    for (const codebooks::Piece* piece : cells_at(book, t)) {
      const Moments part = moments_of(*piece, t);
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

BookStatistics statistics_of(const Codebook& book) {
  if (book.coordinate_count() == (book.has_time() ? 1 : 0))
    throw ArgumentError("the codebook has no free parameter to take statistics over");
  if (has_whole_pieces(book)) return statistics_of_slabs(book);
  warn("the box is split into cells: mean and deviation only, no Sobol' indices");
  return statistics_of_cells(book);
}

/// An error of the field moves its indices by about twice its share of the deviation. Where the deviation is not so
/// many times the largest error that the certificate has found, they may be the field's rather than the output's.
constexpr double kResolved = 2.0;

/// Takes indices away where the certificate does not stand for them.
void leave_out_unresolved(const Codebook& book, BookStatistics& s) {
  if (!book.certificate() || s.inputs.empty()) return;
  for (OutputStatistics& output : s.outputs) {
    const auto certified =
        std::ranges::find(book.certificate()->outputs, output.name, &codebooks::OutputError::name);
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
    narrate(fmt::format(
        "Sobol' indices of {} are left out at {} of {} {}: its deviation there is below {:g} times the "
        "certificate's largest error, {:.3g} {}",
        output.name, left_out, output.deviation.size(), book.has_time() ? "times" : "rows", kResolved,
        certified->max_si, output.unit));
  }
}

std::string to_csv(const Codebook& book, const BookStatistics& s) {
  std::vector<std::string> header;
  std::vector<Eigen::VectorXd> columns;
  if (book.has_time()) {
    header.push_back(fmt::format("{}[{}]", book.coordinates().front().name, book.coordinates().front().unit));
    columns.push_back(s.times);
  }
  for (const OutputStatistics& output : s.outputs) {
    header.push_back(fmt::format("mean({})[{}]", output.name, output.unit));
    header.push_back(fmt::format("deviation({})[{}]", output.name, output.unit));
    columns.push_back(output.mean);
    columns.push_back(output.deviation);
    for (std::size_t k = 0; k < s.inputs.size(); ++k) {
      header.push_back(fmt::format("first({},{})[1]", output.name, s.inputs[k]));
      header.push_back(fmt::format("total({},{})[1]", output.name, s.inputs[k]));
      columns.push_back(output.first_order.col(static_cast<Eigen::Index>(k)));
      columns.push_back(output.total.col(static_cast<Eigen::Index>(k)));
    }
  }
  Eigen::MatrixXd table(columns.front().size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) table.col(static_cast<Eigen::Index>(c)) = columns[c];
  return io::format_csv(header, table);
}

Json to_json(const Codebook& book, const BookStatistics& s) {
  const auto list = [](const auto& column) { return std::vector<double>(column.begin(), column.end()); };
  Json object = {{"schema", "samara-stats/1"}, {"inputs", s.inputs}, {"outputs", Json::array()}};
  if (book.has_time()) object["times"] = list(s.times);
  for (const OutputStatistics& output : s.outputs) {
    Json one = {{"name", output.name},
                {"unit", output.unit},
                {"mean", list(output.mean)},
                {"deviation", list(output.deviation)}};
    for (std::size_t k = 0; k < s.inputs.size(); ++k) {
      one["first_order"][s.inputs[k]] = list(output.first_order.col(static_cast<Eigen::Index>(k)));
      one["total"][s.inputs[k]] = list(output.total.col(static_cast<Eigen::Index>(k)));
    }
    object["outputs"].push_back(one);
  }
  return object;
}

}  // namespace

int run(const StatsArguments& arguments) {
  const Codebook book = codebooks::load(arguments.book);
  warn_of_missed_tolerance(book, arguments.book);
  BookStatistics statistics = statistics_of(book);
  leave_out_unresolved(book, statistics);
  if (arguments.json) {
    print(to_json(book, statistics));
  } else {
    print(to_csv(book, statistics));
  }
  return kDone;
}

}  // namespace samara::apps
