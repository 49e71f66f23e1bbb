#include "samara/codebooks/query/query_choice.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "samara/base/errors.h"
#include "samara/base/parallel.h"
#include "samara/codebooks/book/argument_checks.h"
#include "samara/codebooks/book/certificate_points.h"

namespace samara::codebooks {

namespace {

/// @throws ArgumentError for an output that is unknown or chosen twice
std::vector<int> chosen_outputs(const Codebook& book, const std::vector<std::string>& names) {
  std::vector<int> chosen;
  for (int o = 0; names.empty() && o < book.output_count(); ++o) chosen.push_back(o);
  for (const std::string& name : names) {
    const int place = book.output_index(name);
    if (std::ranges::count(chosen, place) > 0) {
      throw ArgumentError(fmt::format("output \"{}\" is chosen twice", name));
    }
    chosen.push_back(place);
  }
  return chosen;
}

std::vector<std::optional<double>> held_coordinates(const Codebook& book,
                                                    const std::map<std::string, double>& fixed) {
  std::vector<std::optional<double>> held(static_cast<std::size_t>(book.coordinate_count()));
  for (const auto& [name, value] : fixed) {
    const auto k = static_cast<std::size_t>(book.coordinate_index(name));
    require_inside(std::span(book.coordinates()).subspan(k, 1), std::span(&value, 1));
    held[k] = value;
  }
  return held;
}

/// Trial points over the coordinates that are left: coordinates x points.
Eigen::MatrixXd trial_points(const Codebook& book, const PreparedFields& fields) {
  constexpr int kPoints = 128;
  Eigen::MatrixXd parameters;  // none where time is alone
  if (!book.parameters().empty()) parameters = certificate_points(book, kPoints, 1);
  Eigen::MatrixXd points(fields.coordinate_count(), kPoints);
  for (int k = 0; k < fields.coordinate_count(); ++k) {
    const Coordinate& c = fields.coordinates()[static_cast<std::size_t>(k)];
    const int place = book.coordinate_index(c.name) - (book.has_time() ? 1 : 0);
    if (place < 0) {
      // Sobol' points of the others lie evenly against these.
      points.row(k) = Eigen::RowVectorXd::LinSpaced(kPoints, c.lower, c.upper);
    } else {
      points.row(k) = parameters.row(place);
    }
  }
  return points;
}

/// Whether single floats change no output by more than a share of its certified error.
bool single_suffices(const Codebook& book, const PreparedFields::Choice& choice, const PreparedFields& exact,
                     const PreparedFields& single) {
  constexpr double kShare = 0.05;
  std::vector<double> limit;
  for (const int o : choice.outputs) {
    const OutputError& error = book.certificate()->outputs[static_cast<std::size_t>(o)];
    limit.push_back(kShare * error.max_si);
  }
  const auto per_output = static_cast<std::size_t>(exact.rows()) / limit.size();
  PreparedFields::Workspace a = exact.make_workspace(), b = single.make_workspace();
  Eigen::VectorXd left = Eigen::VectorXd::Zero(exact.rows()), right = left;
  const Eigen::MatrixXd points = trial_points(book, exact);
  double* left_column = left.data();
  double* right_column = right.data();
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const double* const x = points.col(j).data();
    for (int piece = 0; piece < exact.piece_count(); ++piece) {
      if (!exact.finder().contains(piece, x)) continue;
      exact.point(piece, x, 0, a, &left_column);
      single.point(piece, x, 0, b, &right_column);
    }
    for (int row = 0; row < exact.rows(); ++row) {
      const double change = std::abs(left[row] - right[row]);
      if (!(change <= limit[static_cast<std::size_t>(row) / per_output])) return false;
    }
  }
  return true;
}

}  // namespace

Prepared prepare(const Codebook& book, const QueryOptions& options,
                 std::optional<std::vector<double>> times) {
  PreparedFields::Choice choice;
  choice.outputs = chosen_outputs(book, options.outputs);
  choice.fixed = held_coordinates(book, options.fixed);
  choice.times = std::move(times);
  if (choice.times && choice.fixed.front())
    throw ArgumentError("a query at given times cannot hold time at another one");
  choice.single = options.precision == Precision::single_precision;
  Prepared result{std::make_shared<const PreparedFields>(book, choice)};
  if (!options.as_stored) result.attitude = AttitudeLength::of(book, choice.outputs);
  if (choice.single) result.precision = Precision::single_precision;
  // Trials would read all pieces of a large file.
  const bool is_read = std::ranges::all_of(book.pieces(), [](const Piece& piece) { return piece.is_read(); });
  const bool is_open = options.precision == Precision::automatic && is_read && book.certificate() &&
                       book.certificate()->outputs.size() == book.outputs().size();
  if (!is_open || result.fields->rows() == 0) return result;
  choice.single = true;
  auto single = std::make_shared<const PreparedFields>(book, choice);
  if (single_suffices(book, choice, *result.fields, *single)) {
    result.fields = std::move(single);
    result.precision = Precision::single_precision;
  }
  return result;
}

void in_ranges(Eigen::Index count, int threads, const std::function<void(Eigen::Index, Eigen::Index)>& run) {
  if (threads < 0) throw ArgumentError(fmt::format("a batch on {} threads, expected 0 or more", threads));
  const int machine = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int used = threads == 0 ? machine : std::min(threads, machine);
  if (used == 1 || count <= kBatchChunk) return run(0, count);
  tbb::task_arena arena(used);
  arena.execute([&] {
    // A few ranges per thread: a thread that is done takes the next one.
    const Eigen::Index chunks = (count + kBatchChunk - 1) / kBatchChunk;
    const Eigen::Index range = kBatchChunk * std::max<Eigen::Index>(1, chunks / (4 * used));
    const Eigen::Index ranges = (count + range - 1) / range;
    // What the first refused point says is thrown, whichever thread comes to its own first.
    std::atomic<Eigen::Index> first_refused = ranges;
    std::exception_ptr refusal;
    std::mutex one_at_a_time;
    parallel_for(ranges, [&](Eigen::Index i) {
      if (i > first_refused) return;
      try {
        run(i * range, std::min(count, (i + 1) * range));
      } catch (...) {
        const std::lock_guard lock(one_at_a_time);
        if (i > first_refused) return;
        first_refused = i;
        refusal = std::current_exception();
      }
    });
    if (refusal) std::rethrow_exception(refusal);
  });
}

}  // namespace samara::codebooks
