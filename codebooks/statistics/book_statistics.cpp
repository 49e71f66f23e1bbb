#include "samara/codebooks/statistics/book_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <span>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/book/book_slice.h"
#include "samara/codebooks/statistics/input_draws.h"
#include "samara/pgd/fields/statistics.h"

namespace samara::codebooks {

namespace {

/// Of a distribution, the least share that must lie inside the box; and what may lie outside without a note.
constexpr double kLeastInside = 0.5, kUnnoticed = 1e-3;

const Coordinate& coordinate_of(const Codebook& book, const std::string& name) {
  std::vector<std::string> known;
  for (const Coordinate& coordinate : book.parameters()) {
    if (coordinate.name == name) return coordinate;
    known.push_back(coordinate.name);
  }
  if (book.has_time() && name == book.coordinates().front().name)
    throw ArgumentError(fmt::format("\"{}\" is the time, at which statistics are given, and no input", name));
  throw ArgumentError(fmt::format("\"{}\" is no input of the codebook{}", name, suggestion(name, known)));
}

void check_distribution(const Coordinate& box, const Distribution& distribution, BookStatistics& result) {
  require_distribution("\"" + box.name + "\"", distribution);
  const double inside =
      probability_below(distribution, box.upper) - probability_below(distribution, box.lower);
  if (inside >= 1.0 - kUnnoticed) return;
  const std::string sentence = fmt::format(
      "{:.3g} % of the distribution {} of \"{}\" lies outside the codebook's box, from {} to {}{}",
      100.0 * (1.0 - inside), to_string(distribution), box.name, box.lower, box.upper, unit_suffix(box.unit));
  if (!(inside >= kLeastInside)) throw ArgumentError(sentence + ": expected less than half");
  result.notes.push_back(sentence + ", and is left out");
}

void check_joint(const Codebook& book, const StatisticsRequest& request) {
  const JointNormal& joint = *request.joint;
  const auto count = static_cast<Eigen::Index>(joint.inputs.size());
  if (joint.mean.size() != count || joint.covariance.rows() != count || joint.covariance.cols() != count)
    throw ArgumentError(
        fmt::format("{} inputs that are normal together have {} means and a covariance of {} by {}", count,
                    joint.mean.size(), joint.covariance.rows(), joint.covariance.cols()));
  if (count == 0) throw ArgumentError("a joint distribution has no inputs, expected at least one");
  std::set<std::string> names;
  for (const std::string& name : joint.inputs) {
    coordinate_of(book, name);
    if (!names.insert(name).second)
      throw ArgumentError(fmt::format("a joint distribution holds \"{}\" twice", name));
    if (request.fixed.contains(name) || request.inputs.contains(name))
      throw ArgumentError(fmt::format("\"{}\" is given by a joint distribution, and once more", name));
  }
  if (!request.groups.empty())
    throw ArgumentError("a joint distribution has no indices of groups: these stand for independent inputs");
}

void check(const Codebook& book, const StatisticsRequest& request, BookStatistics& result) {
  for (const auto& [name, value] : request.fixed) {
    const Coordinate& box = coordinate_of(book, name);
    if (!std::isfinite(value))
      throw ArgumentError(fmt::format("\"{}\" is {}, expected a finite number", name, value));
    if (value < box.lower || value > box.upper)
      throw OutsideBoxError(fmt::format("\"{}\" is {}, outside the codebook's box, from {} to {}{}", name,
                                        value, box.lower, box.upper, unit_suffix(box.unit)));
    if (request.inputs.contains(name))
      throw ArgumentError(fmt::format("\"{}\" is held, and has a distribution", name));
  }
  if (book.parameters().size() == request.fixed.size())
    throw ArgumentError("the codebook has no free parameter to take statistics over");
  for (const auto& [name, distribution] : request.inputs)
    check_distribution(coordinate_of(book, name), distribution, result);
  std::set<double> shares;
  for (const double share : request.quantiles) {
    if (!(share > 0.0 && share < 1.0))
      throw ArgumentError(
          fmt::format("a quantile is asked for at {}, expected a share above 0 and below 1", share));
    if (!shares.insert(share).second)
      throw ArgumentError(
          fmt::format("the quantile at {} is asked for twice, expected each share once", share));
  }
  constexpr int kFewest = 100, kMost = 10'000'000;
  require(request.draws >= kFewest && request.draws <= kMost, "draws", request.draws,
          fmt::format("{} to {}", kFewest, kMost));
  for (const std::vector<std::string>& group : request.groups) {
    std::set<std::string> names;
    if (group.empty()) throw ArgumentError("a group of inputs is empty, expected at least one");
    for (const std::string& name : group) {
      if (request.fixed.contains(coordinate_of(book, name).name))
        throw ArgumentError(fmt::format("a group of inputs holds \"{}\", which is held", name));
      if (!names.insert(name).second)
        throw ArgumentError(fmt::format("a group of inputs holds \"{}\" twice", name));
    }
  }
  if (request.joint) check_joint(book, request);
}

/// Whether pieces are slabs of time, each over the whole box.
bool are_whole(const Codebook& book) {
  const std::size_t first = book.has_time() ? 1 : 0;
  return std::ranges::all_of(book.pieces(), [&](const Piece& piece) {
    for (std::size_t k = first; k < book.coordinates().size(); ++k) {
      const Coordinate& box = book.coordinates()[k];
      if (piece.lower()[k] != box.lower || piece.upper()[k] != box.upper) return false;
    }
    return true;
  });
}

pgd::StatisticsOptions options_of(const pgd::Field& field, const StatisticsRequest& request) {
  pgd::StatisticsOptions options;
  for (const pgd::Axis& axis : field.axes()) {
    const auto given = request.inputs.find(axis.name());
    if (given != request.inputs.end()) options.distributions[axis.name()] = rule_of(given->second, axis);
  }
  return options;
}

/// Appends the columns of `from` to the rows that are there.
void append(Eigen::VectorXd& rows, const Eigen::RowVectorXd& columns, Eigen::Index from) {
  const Eigen::Index before = rows.size(), more = columns.size() - from;
  rows.conservativeResize(before + more);
  rows.tail(more) = columns.tail(more).transpose();
}

/// The same with a matrix of one column for each of `columns`.
template <class Get>
void append(Eigen::MatrixXd& rows, std::size_t columns, Eigen::Index more, Get&& get) {
  const Eigen::Index before = rows.rows();
  rows.conservativeResize(before + more, static_cast<Eigen::Index>(columns));
  for (std::size_t k = 0; k < columns; ++k)
    rows.col(static_cast<Eigen::Index>(k)).tail(more) = get(k).tail(more).transpose();
}

void take_of_slabs(const Codebook& book, const StatisticsRequest& request, BookStatistics& result) {
  result.groups = request.groups;
  for (std::size_t p = 0; p < book.pieces().size(); ++p) {
    // The lower piece answers where two of them meet.
    const Eigen::Index from = p > 0 ? 1 : 0;
    std::size_t place = 0;
    for (const FieldGroup& field : book.pieces()[p].groups()) {
      pgd::StatisticsOptions options = options_of(field, request);
      if (book.has_time()) options.free_axis = book.coordinates().front().name;
      options.subsets = request.groups;
      const pgd::Statistics s = pgd::statistics(field, options);
      result.inputs = s.inputs;
      if (place == 0 && book.has_time()) append(result.times, s.free_nodes.transpose(), from);
      const Eigen::Index more = s.mean.cols() - from;
      for (Eigen::Index o = 0; o < s.mean.rows(); ++o, ++place) {
        OutputStatistics& output = result.outputs[place];
        append(output.mean, s.mean.row(o), from);
        append(output.deviation, s.variance.row(o).cwiseSqrt(), from);
        append(output.first_order, s.inputs.size(), more,
               [&](std::size_t k) { return s.first_order[k].row(o); });
        append(output.total, s.inputs.size(), more, [&](std::size_t k) { return s.total[k].row(o); });
        append(output.group_closed, s.subsets.size(), more,
               [&](std::size_t k) { return s.subsets[k].closed.row(o); });
        append(output.group_total, s.subsets.size(), more,
               [&](std::size_t k) { return s.subsets[k].total.row(o); });
      }
    }
  }
}

/// Nodes of time of all pieces, each once.
Eigen::VectorXd times_of(const Codebook& book) {
  std::vector<double> times;
  for (const Piece& piece : book.pieces()) {
    const Eigen::VectorXd nodes = piece.outline().axes.front().nodes();
    times.insert(times.end(), nodes.begin(), nodes.end());
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
}

/// Of the values of a list, the part that a piece has, by their weights.
double share_of_list(const ListValues& list, const pgd::Axis& axis) {
  double share = 0.0, all = 0.0;
  for (Eigen::Index i = 0; i < list.values.size(); ++i) {
    all += list.weights[i];
    if (axis.contains(list.values[i])) share += list.weights[i];
  }
  return share / all;
}

/// The probability of a piece, without time, among those beside it. @param lists as of list_values()
double share_of(const Codebook& book, const Piece& piece, const std::vector<std::optional<ListValues>>& lists,
                const StatisticsRequest& request) {
  double share = 1.0;
  for (std::size_t k = 0; k < lists.size(); ++k) {
    if (lists[k]) {
      share *= share_of_list(*lists[k], piece.groups().front().axes()[k]);
      continue;
    }
    const Coordinate& box = book.parameters()[k];
    const auto given = request.inputs.find(box.name);
    const Distribution distribution = given != request.inputs.end()
                                          ? given->second
                                          : Distribution{DistributionKind::uniform, box.lower, box.upper};
    share *=
        probability_below(distribution, piece.upper()[k]) - probability_below(distribution, piece.lower()[k]);
  }
  return share;
}

/// Of all outputs at one time.
struct Moments {
  Eigen::VectorXd mean, variance;
};

Moments moments_of(const Piece& piece, const StatisticsRequest& request) {
  Moments moments;
  for (const FieldGroup& field : piece.groups()) {
    const pgd::Statistics s = pgd::statistics(field, options_of(field, request));
    append(moments.mean, s.mean.transpose(), 0);
    append(moments.variance, s.variance.transpose(), 0);
  }
  return moments;
}

/// A box that is split into cells: means and variances of the cells, weighted by their probabilities. Conditional
/// means, of which the indices are made, would have to be put together along the coordinates.
void take_of_cells(const Codebook& book, const StatisticsRequest& request, BookStatistics& result) {
  if (!request.groups.empty())
    throw ArgumentError("the box of the codebook is split into cells, which have no indices of groups");
  if (book.has_time()) result.times = times_of(book);
  const std::vector<std::optional<ListValues>> lists = list_values(book, {});
  const Eigen::Index rows = std::max<Eigen::Index>(result.times.size(), 1);
  for (OutputStatistics& output : result.outputs)
    output.mean = output.deviation = Eigen::VectorXd::Zero(rows);
  constexpr double kNegligible = 1e-14;
  bool some_overlap = false;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const std::vector<Piece> cells = book.has_time() ? pieces_at(book, result.times[i]) : book.pieces();
    some_overlap = some_overlap || pieces_overlap(cells);
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(book.output_count()), variance = mean;
    double weight = 0.0;
    for (const Piece& cell : cells) {
      const double share = share_of(book, cell, lists, request), before = weight;
      if (share < kNegligible) continue;
      const Moments moments = moments_of(cell, request);
      weight += share;
      // Of two parts with weights a and b: (a V_1 + b V_2)/(a + b) + a b/(a + b)^2 (m_1 - m_2)^2.
      const Eigen::VectorXd apart = moments.mean - mean;
      variance = (before * variance + share * moments.variance) / weight +
                 before * share / (weight * weight) * apart.cwiseAbs2();
      mean += share / weight * apart;
    }
    if (!(weight > 0.0)) {
      const std::string at = book.has_time()
                                 ? fmt::format(" at {} = {}{}", book.coordinates().front().name,
                                               result.times[i], unit_suffix(book.coordinates().front().unit))
                                 : "";
      throw ArgumentError(fmt::format(
          "less than {:g} of the distribution of the inputs lies in pieces of the codebook{}, expected more",
          kNegligible, at));
    }
    for (std::size_t o = 0; o < result.outputs.size(); ++o) {
      result.outputs[o].mean[i] = mean[static_cast<Eigen::Index>(o)];
      result.outputs[o].deviation[i] = std::sqrt(variance[static_cast<Eigen::Index>(o)]);
    }
  }
  result.notes.push_back("the box is split into cells: mean and deviation only, no Sobol' indices");
  if (some_overlap)
    result.notes.push_back(
        "pieces overlap where a period or the nodes of a mesh cannot be cut: what they share counts more "
        "than once");
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
      for (Eigen::MatrixXd* indices :
           {&output.first_order, &output.total, &output.group_closed, &output.group_total})
        indices->row(i).setConstant(std::numeric_limits<double>::quiet_NaN());
      ++left_out;
    }
    if (left_out == 0) continue;
    s.notes.push_back(fmt::format(
        "Sobol' indices of {} are left out at {} of {} {}: its deviation there is below {:g} times the "
        "certificate's largest error, {:.3g}{}",
        output.name, left_out, output.deviation.size(), book.has_time() ? "times" : "rows", kResolved,
        certified->max_si, unit_suffix(output.unit)));
  }
}

void take_of_draws(const Codebook& book, const StatisticsRequest& request, BookStatistics& result) {
  const InputDraws draws = draw_inputs(book, request);
  const double outside = 1.0 - draws.share_inside;
  if (outside > kUnnoticed) {
    const std::string sentence = fmt::format(
        "{:.3g} % of the joint distribution of the inputs lies outside the codebook's box", 100.0 * outside);
    if (draws.share_inside < kLeastInside) throw ArgumentError(sentence + ": expected less than half");
    result.notes.push_back(sentence + ", and is left out");
  }
  add_from_draws(book, request, draws, result);
}

}  // namespace

BookStatistics take_statistics(const Codebook& book, const StatisticsRequest& request) {
  BookStatistics result;
  check(book, request, result);
  result.quantiles = request.quantiles;
  for (const pgd::OutputLabel& output : book.outputs())
    result.outputs.push_back({.name = output.name, .unit = output.unit});
  if (request.joint || book.front() != nullptr) {
    // The separated form is one of the axes, on which inputs are not independent.
    if (book.front() != nullptr && !request.groups.empty())
      throw ArgumentError(
          "a coordinate of the codebook is counted from a front: there are no indices of groups");
    result.notes.push_back(fmt::format(
        "{}: statistics are those of draws, without Sobol' indices",
        request.joint ? "inputs are correlated" : "a coordinate of the codebook is counted from a front"));
    if (book.has_time()) result.times = times_of(book);
    take_of_draws(book, request, result);
    return result;
  }
  const Codebook free = request.fixed.empty() ? with_pieces_apart(book) : slice(book, request.fixed);
  if (are_whole(free)) {
    take_of_slabs(free, request, result);
  } else {
    take_of_cells(free, request, result);
  }
  leave_out_unresolved(book, result);
  if (!request.quantiles.empty()) take_of_draws(book, request, result);
  return result;
}

}  // namespace samara::codebooks
