#pragma once

#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "samara/base/errors.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/capi/answers.h"
#include "samara/codebooks/capi/samara.h"

/// Internal: what the pointers of samara.h lead to, and how its calls refuse them.
struct samara_codebook {
  samara::codebooks::Codebook book;
  std::vector<samara::pgd::OutputLabel> derived = derived_outputs(book);
  std::vector<std::string> roles = {};  ///< of the coordinates
};

struct samara_query {
  samara::codebooks::PointAnswers answers;
};

struct samara_trajectory {
  samara::codebooks::FrameAnswers answers;
};

namespace samara::capi {

/// The sentence of the last call that failed, of this thread; empty: none has.
const char* last_error() noexcept;

/// Remembers what went wrong. @returns the status
samara_status failed(samara_status status, const char* sentence) noexcept;

/// WRONG_CALL.
samara_status missing(const char* what) noexcept;

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

/// Null, with the sentence remembered, for a null pointer or an index that does not exist.
const codebooks::Coordinate* coordinate_of(const samara_codebook* book, int k) noexcept;
const pgd::OutputLabel* output_of(const samara_codebook* book, int o) noexcept;
const pgd::OutputLabel* derived_of(const samara_codebook* book, int o) noexcept;
const pgd::OutputLabel* asked_output(const samara_query* query, int o) noexcept;
/// An entry of the values held, in the order of their names.
const std::pair<const std::string, double>* fixed_of(const samara_codebook* book, int f) noexcept;

}  // namespace samara::capi
