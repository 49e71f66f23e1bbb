#include "samara/codebooks/capi/samara.h"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <limits>
#include <new>
#include <string>

#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/query/query.h"

struct samara_codebook {
  samara::codebooks::Codebook book;
};

struct samara_query {
  samara::codebooks::Query query;
  Eigen::MatrixXd gradient;  ///< column by column, before it is handed out row by row
};

namespace {

using samara::codebooks::Coordinate;

thread_local std::string last_error;

/// Remembers what went wrong. Keeping the sentence may itself run out of memory.
samara_status failed(samara_status status, const char* sentence) noexcept {
  try {
    last_error = sentence;
  } catch (...) {
    last_error.clear();
  }
  return status;
}

/// Runs something that may throw.
template <class Run>
samara_status guarded(const Run& run) noexcept {
  try {
    run();
    return SAMARA_DONE;
  } catch (const samara::OutsideBoxError& error) {
    return failed(SAMARA_OUTSIDE, error.what());
  } catch (const samara::ArgumentError& error) {
    return failed(SAMARA_WRONG_CALL, error.what());
  } catch (const samara::InputError& error) {
    return failed(SAMARA_BAD_FILE, error.what());
  } catch (const std::exception& error) {
    return failed(SAMARA_INTERNAL, error.what());
  } catch (...) {
    return failed(SAMARA_INTERNAL, "an unknown failure");
  }
}

samara_status missing(const char* what) noexcept {
  return failed(SAMARA_WRONG_CALL, what);
}

const Coordinate* coordinate_of(const samara_codebook* book, int k) noexcept {
  if (book == nullptr || k < 0 || k >= book->book.coordinate_count()) {
    missing("no book was given, or a coordinate that it does not have");
    return nullptr;
  }
  return &book->book.coordinates()[static_cast<std::size_t>(k)];
}

const samara::pgd::OutputLabel* output_of(const samara_codebook* book, int o) noexcept {
  if (book == nullptr || o < 0 || o >= book->book.output_count()) {
    missing("no book was given, or an output that it does not have");
    return nullptr;
  }
  return &book->book.outputs()[static_cast<std::size_t>(o)];
}

std::span<const double> point_of(const samara_query& query, const double* x) noexcept {
  return {x, query.query.coordinates().size()};
}

}  // namespace

const char* samara_error(void) {
  return last_error.c_str();
}

samara_codebook* samara_open(const char* path) {
  if (path == nullptr) {
    missing("samara_open was given no path");
    return nullptr;
  }
  samara_codebook* book = nullptr;
  guarded([&] { book = new samara_codebook{samara::codebooks::load(path)}; });
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

samara_query* samara_query_open(const samara_codebook* book) {
  if (book == nullptr) {
    missing("samara_query_open was given no book");
    return nullptr;
  }
  samara_query* query = nullptr;
  guarded([&] {
    query = new samara_query{samara::codebooks::Query(book->book),
                             Eigen::MatrixXd(book->book.output_count(), book->book.coordinate_count())};
  });
  return query;
}

void samara_query_close(samara_query* query) {
  delete query;
}

samara_status samara_values(samara_query* query, const double* x, double* values) {
  if (query == nullptr || x == nullptr || values == nullptr)
    return missing("samara_values was given no query, no point, or no place for the answer");
  return guarded([&] {
    query->query.values(point_of(*query, x),
                        Eigen::Map<Eigen::VectorXd>(values, query->query.output_count()));
  });
}

samara_status samara_gradient(samara_query* query, const double* x, double* values, double* gradient) {
  if (query == nullptr || x == nullptr || values == nullptr || gradient == nullptr)
    return missing("samara_gradient was given no query, no point, or no place for the answer");
  return guarded([&] {
    query->query.values(point_of(*query, x), Eigen::Map<Eigen::VectorXd>(values, query->query.output_count()),
                        query->gradient);
    Eigen::Map<Eigen::MatrixXd>(gradient, query->gradient.cols(), query->gradient.rows()) =
        query->gradient.transpose();
  });
}

samara_status samara_batch(samara_query* query, size_t count, const double* points, double* values,
                           int threads) {
  if (query == nullptr || (count > 0 && (points == nullptr || values == nullptr)))
    return missing("samara_batch was given no query, no points, or no place for the answers");
  // More numbers than an address can tell apart: a count that went wrong, such as -1.
  const auto numbers =
      static_cast<size_t>(std::max(1, query->query.output_count())) + query->query.coordinates().size();
  if (count > static_cast<size_t>(std::numeric_limits<std::ptrdiff_t>::max()) / sizeof(double) / numbers)
    return missing("samara_batch was given more points than any memory holds");
  return guarded([&] {
    const auto columns = static_cast<Eigen::Index>(count);
    query->query.batch(Eigen::Map<const Eigen::MatrixXd>(
                           points, static_cast<Eigen::Index>(query->query.coordinates().size()), columns),
                       Eigen::Map<Eigen::MatrixXd>(values, query->query.output_count(), columns), threads);
  });
}
