#include "samara/codebooks/capi/samara.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <iterator>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "samara/base/errors.h"
#include "samara/base/version.h"
#include "samara/codebooks/capi/handles.h"
#include "samara/codebooks/capi/options.h"
#include "samara/codebooks/file/file_format.h"
#include "samara/codebooks/file/load.h"

namespace {

using namespace samara::capi;
using samara::codebooks::Coordinate;

samara_codebook* opened(samara::codebooks::Codebook book) {
  auto result = std::make_unique<samara_codebook>(samara_codebook{std::move(book)});
  for (const Coordinate& c : result->book.coordinates()) result->roles.push_back(to_string(c.role));
  return result.release();
}

/// More numbers than an address can tell apart: a count that went wrong, such as -1.
bool is_too_many(size_t count, size_t numbers_each) noexcept {
  return count > static_cast<size_t>(std::numeric_limits<std::ptrdiff_t>::max()) / sizeof(double) /
                     std::max<size_t>(1, numbers_each);
}

samara_status batch_of(const char* call, samara_query* query, size_t count, const double* points,
                       double* values, double* gradients, int threads) noexcept {
  const auto outputs = query->answers.outputs().size(), d = query->answers.coordinates().size();
  return guarded([&] {
    if (is_too_many(count, (outputs + 1) * (d + 1)))
      throw samara::ArgumentError(std::string(call) + " was given more points than any memory holds");
    query->answers.batch(static_cast<Eigen::Index>(count), points, values, gradients, threads);
  });
}

}  // namespace

const char* samara_error(void) {
  return last_error();
}

const char* samara_version(void) {
  return samara::version();
}

const char* samara_format_version(void) {
  namespace format = samara::codebooks::format;
  static const std::string text = std::to_string(format::kMajor) + "." + std::to_string(format::kMinor);
  return text.c_str();
}

samara_codebook* samara_open(const char* path) {
  if (path == nullptr) {
    missing("samara_open was given no path");
    return nullptr;
  }
  samara_codebook* book = nullptr;
  guarded([&] { book = opened(samara::codebooks::load(path)); });
  return book;
}

samara_codebook* samara_open_memory(const void* bytes, size_t size) {
  if (bytes == nullptr) {
    missing("samara_open_memory was given no bytes");
    return nullptr;
  }
  samara_codebook* book = nullptr;
  guarded([&] { book = opened(samara::codebooks::load_bytes({static_cast<const char*>(bytes), size})); });
  return book;
}

void samara_close(samara_codebook* book) {
  delete book;
}

int samara_coordinate_count(const samara_codebook* book) {
  return book == nullptr ? 0 : book->book.coordinate_count();
}
int samara_output_count(const samara_codebook* book) {
  return book == nullptr ? 0 : book->book.output_count();
}
const char* samara_coordinate_name(const samara_codebook* book, int coordinate) {
  const Coordinate* const c = coordinate_of(book, coordinate);
  return c == nullptr ? nullptr : c->name.c_str();
}
const char* samara_coordinate_unit(const samara_codebook* book, int coordinate) {
  const Coordinate* const c = coordinate_of(book, coordinate);
  return c == nullptr ? nullptr : c->unit.c_str();
}
const char* samara_output_name(const samara_codebook* book, int output) {
  const auto* const o = output_of(book, output);
  return o == nullptr ? nullptr : o->name.c_str();
}
const char* samara_output_unit(const samara_codebook* book, int output) {
  const auto* const o = output_of(book, output);
  return o == nullptr ? nullptr : o->unit.c_str();
}

samara_status samara_bounds(const samara_codebook* book, int coordinate, double* lower, double* upper) {
  const Coordinate* const c = coordinate_of(book, coordinate);
  if (c == nullptr || lower == nullptr || upper == nullptr)
    return missing(
        "samara_bounds was given no book, a coordinate that it does not have, or no place for the answer");
  *lower = c->lower;
  *upper = c->upper;
  return SAMARA_DONE;
}

int samara_is_certified(const samara_codebook* book) {
  return book != nullptr && book->book.certificate() && book->book.certificate()->met ? 1 : 0;
}

const char* samara_coordinate_role(const samara_codebook* book, int coordinate) {
  return coordinate_of(book, coordinate) == nullptr
             ? nullptr
             : book->roles[static_cast<std::size_t>(coordinate)].c_str();
}
const char* samara_model(const samara_codebook* book) {
  if (book == nullptr) missing("samara_model was given no book");
  return book == nullptr ? nullptr : book->book.model().name.c_str();
}

int samara_derived_count(const samara_codebook* book) {
  return book == nullptr ? 0 : static_cast<int>(book->derived.size());
}
const char* samara_derived_name(const samara_codebook* book, int derived) {
  const auto* const o = derived_of(book, derived);
  return o == nullptr ? nullptr : o->name.c_str();
}
const char* samara_derived_unit(const samara_codebook* book, int derived) {
  const auto* const o = derived_of(book, derived);
  return o == nullptr ? nullptr : o->unit.c_str();
}

int samara_fixed_count(const samara_codebook* book) {
  return book == nullptr ? 0 : static_cast<int>(book->book.model().fixed.size());
}
const char* samara_fixed_name(const samara_codebook* book, int fixed) {
  const auto* const entry = fixed_of(book, fixed);
  return entry == nullptr ? nullptr : entry->first.c_str();
}
const char* samara_fixed_unit(const samara_codebook* book, int fixed) {
  const auto* const entry = fixed_of(book, fixed);
  if (entry == nullptr) return nullptr;
  const auto unit = book->book.model().fixed_units.find(entry->first);
  return unit == book->book.model().fixed_units.end() ? "1" : unit->second.c_str();
}
samara_status samara_fixed_value(const samara_codebook* book, int fixed, double* value) {
  const auto* const entry = fixed_of(book, fixed);
  if (entry == nullptr || value == nullptr)
    return missing(
        "samara_fixed_value was given no book, a value held that it does not have, or no place for the "
        "answer");
  *value = entry->second;
  return SAMARA_DONE;
}

samara_status samara_certificate_of(const samara_codebook* book, samara_certificate* certificate) {
  if (book == nullptr || certificate == nullptr)
    return missing("samara_certificate_of was given no book, or no place for the answer");
  if (!book->book.certificate()) return missing("the codebook has no certificate");
  const samara::codebooks::Certificate& c = *book->book.certificate();
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  return guarded([&] {
    *certificate = {c.met ? 1 : 0,
                    c.points,
                    c.times,
                    c.failed_points,
                    c.wrong_points.value_or(-1),
                    c.tolerance,
                    c.max_error,
                    c.wrong_points && c.points > 0
                        ? samara::codebooks::share_above(*c.wrong_points, c.points, c.refuted_before)
                        : unknown,
                    c.norm_defect ? c.norm_defect->max : unknown};
  });
}

samara_status samara_output_error_of(const samara_codebook* book, int output, samara_output_error* error) {
  if (output_of(book, output) == nullptr || error == nullptr)
    return missing(
        "samara_output_error_of was given no book, an output that it does not have, or no place for the "
        "answer");
  if (!book->book.certificate() || output >= std::ssize(book->book.certificate()->outputs))
    return missing("the codebook has no certificate");
  const samara::codebooks::OutputError& o =
      book->book.certificate()->outputs[static_cast<std::size_t>(output)];
  *error = {o.range, o.max, o.p95, o.mean, o.rms, o.max_si};
  return SAMARA_DONE;
}

samara_query* samara_query_open(const samara_codebook* book) {
  return samara_query_open_with(book, nullptr);
}

samara_query* samara_query_open_with(const samara_codebook* book, const samara_options* options) {
  if (book == nullptr) {
    missing("samara_query_open was given no book");
    return nullptr;
  }
  samara_query* query = nullptr;
  guarded([&] { query = new samara_query{{book->book, samara::codebooks::options_of(options)}}; });
  return query;
}

void samara_query_close(samara_query* query) {
  delete query;
}

int samara_query_coordinate_count(const samara_query* query) {
  return query == nullptr ? 0 : static_cast<int>(query->answers.coordinates().size());
}
int samara_query_output_count(const samara_query* query) {
  return query == nullptr ? 0 : static_cast<int>(query->answers.outputs().size());
}
const char* samara_query_coordinate_name(const samara_query* query, int coordinate) {
  if (coordinate < 0 || coordinate >= samara_query_coordinate_count(query)) {
    missing("no query was given, or a coordinate that it does not have");
    return nullptr;
  }
  return query->answers.coordinates()[static_cast<std::size_t>(coordinate)].name.c_str();
}
const char* samara_query_output_name(const samara_query* query, int output) {
  const auto* const o = asked_output(query, output);
  return o == nullptr ? nullptr : o->name.c_str();
}
const char* samara_query_output_unit(const samara_query* query, int output) {
  const auto* const o = asked_output(query, output);
  return o == nullptr ? nullptr : o->unit.c_str();
}
samara_precision samara_query_precision(const samara_query* query) {
  using samara::codebooks::Precision;
  return query != nullptr && query->answers.precision() == Precision::single_precision ? SAMARA_SINGLE
                                                                                       : SAMARA_DOUBLE;
}

samara_status samara_values(samara_query* query, const double* x, double* values) {
  if (query == nullptr || x == nullptr || values == nullptr)
    return missing("samara_values was given no query, no point, or no place for the answer");
  return guarded([&] { query->answers.values(x, values); });
}

samara_status samara_gradient(samara_query* query, const double* x, double* values, double* gradient) {
  if (query == nullptr || x == nullptr || values == nullptr || gradient == nullptr)
    return missing("samara_gradient was given no query, no point, or no place for the answer");
  return guarded([&] { query->answers.values(x, values, gradient); });
}

samara_status samara_batch(samara_query* query, size_t count, const double* points, double* values,
                           int threads) {
  if (query == nullptr || (count > 0 && (points == nullptr || values == nullptr)))
    return missing("samara_batch was given no query, no points, or no place for the answers");
  return batch_of("samara_batch", query, count, points, values, nullptr, threads);
}

samara_status samara_batch_gradient(samara_query* query, size_t count, const double* points, double* values,
                                    double* gradients, int threads) {
  if (query == nullptr || (count > 0 && (points == nullptr || values == nullptr || gradients == nullptr)))
    return missing("samara_batch_gradient was given no query, no points, or no place for the answers");
  if (count == 0) return SAMARA_DONE;
  return batch_of("samara_batch_gradient", query, count, points, values, gradients, threads);
}

samara_trajectory* samara_trajectory_open(const samara_codebook* book, size_t time_count, const double* times,
                                          const samara_options* options) {
  if (book == nullptr || (time_count > 0 && times == nullptr)) {
    missing("samara_trajectory_open was given no book, or no times");
    return nullptr;
  }
  samara_trajectory* trajectory = nullptr;
  guarded([&] {
    if (is_too_many(time_count, 1))
      throw samara::ArgumentError("samara_trajectory_open was given more times than any memory holds");
    trajectory = new samara_trajectory{
        {book->book, std::vector<double>(times, times + time_count), samara::codebooks::options_of(options)}};
  });
  return trajectory;
}

void samara_trajectory_close(samara_trajectory* trajectory) {
  delete trajectory;
}

int samara_trajectory_parameter_count(const samara_trajectory* trajectory) {
  return trajectory == nullptr ? 0 : static_cast<int>(trajectory->answers.parameters());
}
int samara_trajectory_output_count(const samara_trajectory* trajectory) {
  return trajectory == nullptr ? 0 : static_cast<int>(trajectory->answers.outputs());
}
size_t samara_trajectory_time_count(const samara_trajectory* trajectory) {
  return trajectory == nullptr ? 0 : static_cast<size_t>(trajectory->answers.times());
}

samara_status samara_trajectory_values(samara_trajectory* trajectory, const double* q, double* values,
                                       double* derivatives) {
  if (trajectory == nullptr || q == nullptr || values == nullptr)
    return missing("samara_trajectory_values was given no trajectory, no point, or no place for the answer");
  return guarded([&] { trajectory->answers.values(q, values, derivatives); });
}

samara_status samara_trajectory_batch(samara_trajectory* trajectory, size_t count, const double* points,
                                      double* values, double* derivatives, int threads) {
  if (trajectory == nullptr || (count > 0 && (points == nullptr || values == nullptr)))
    return missing("samara_trajectory_batch was given no trajectory, no points, or no place for the answers");
  return guarded([&] {
    samara::codebooks::FrameAnswers& answers = trajectory->answers;
    const auto each =
        static_cast<size_t>(answers.outputs() * (1 + answers.parameters()) + answers.parameters());
    if (is_too_many(count, each * static_cast<size_t>(std::max<Eigen::Index>(1, answers.times()))))
      throw samara::ArgumentError("samara_trajectory_batch was given more points than any memory holds");
    answers.batch(static_cast<Eigen::Index>(count), points, values, derivatives, threads);
  });
}
