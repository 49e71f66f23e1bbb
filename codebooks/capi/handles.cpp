#include "samara/codebooks/capi/handles.h"

#include <cstddef>
#include <iterator>

namespace samara::capi {

namespace {

thread_local std::string last_sentence;

}  // namespace

const char* last_error() noexcept {
  return last_sentence.c_str();
}

samara_status failed(samara_status status, const char* sentence) noexcept {
  // Keeping the sentence may itself run out of memory.
  try {
    last_sentence = sentence;
  } catch (...) {
    last_sentence.clear();
  }
  return status;
}

samara_status missing(const char* what) noexcept {
  return failed(SAMARA_WRONG_CALL, what);
}

const codebooks::Coordinate* coordinate_of(const samara_codebook* book, int k) noexcept {
  if (book == nullptr || k < 0 || k >= book->book.coordinate_count()) {
    missing("no book was given, or a coordinate that it does not have");
    return nullptr;
  }
  return &book->book.coordinates()[static_cast<std::size_t>(k)];
}

const pgd::OutputLabel* output_of(const samara_codebook* book, int o) noexcept {
  if (book == nullptr || o < 0 || o >= book->book.output_count()) {
    missing("no book was given, or an output that it does not have");
    return nullptr;
  }
  return &book->book.outputs()[static_cast<std::size_t>(o)];
}

const pgd::OutputLabel* derived_of(const samara_codebook* book, int o) noexcept {
  if (book == nullptr || o < 0 || o >= std::ssize(book->derived)) {
    missing("no book was given, or a derived output that it does not have");
    return nullptr;
  }
  return &book->derived[static_cast<std::size_t>(o)];
}

const pgd::OutputLabel* asked_output(const samara_query* query, int o) noexcept {
  if (query == nullptr || o < 0 || o >= std::ssize(query->answers.outputs())) {
    missing("no query was given, or an output that it does not have");
    return nullptr;
  }
  return &query->answers.outputs()[static_cast<std::size_t>(o)];
}

const std::pair<const std::string, double>* fixed_of(const samara_codebook* book, int f) noexcept {
  if (book == nullptr || f < 0 || f >= std::ssize(book->book.model().fixed)) {
    missing("no book was given, or a value held that it does not have");
    return nullptr;
  }
  return &*std::next(book->book.model().fixed.begin(), f);
}

}  // namespace samara::capi
