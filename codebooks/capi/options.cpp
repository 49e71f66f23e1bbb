#include "samara/codebooks/capi/options.h"

#include <string>

#include "samara/base/errors.h"

namespace samara::codebooks {

namespace {

/// Names that a caller in C gives.
std::string name_of(const char* const* names, int k, const char* what) {
  if (names == nullptr || names[k] == nullptr)
    throw ArgumentError(std::string(what) + " number " + std::to_string(k) + " has no name");
  return names[k];
}

}  // namespace

QueryOptions options_of(const samara_options* options) {
  QueryOptions result;
  if (options == nullptr) return result;
  if (options->output_count < 0 || options->held_count < 0)
    throw ArgumentError("options have a negative number of names, expected 0 or more");
  for (int k = 0; k < options->output_count; ++k)
    result.outputs.push_back(name_of(options->outputs, k, "the output"));
  for (int k = 0; k < options->held_count; ++k) {
    const std::string name = name_of(options->held, k, "the coordinate held");
    if (options->held_at == nullptr || !result.fixed.emplace(name, options->held_at[k]).second)
      throw ArgumentError("coordinate \"" + name + "\" is held without a value, or twice");
  }
  switch (options->precision) {
    case SAMARA_DOUBLE:
      break;
    case SAMARA_SINGLE:
      result.precision = Precision::single_precision;
      break;
    case SAMARA_AUTOMATIC:
      result.precision = Precision::automatic;
      break;
    default:
      throw ArgumentError("precision " + std::to_string(static_cast<int>(options->precision)) +
                          " is not known, expected 0 to 2");
  }
  result.as_stored = options->as_stored != 0;
  return result;
}

}  // namespace samara::codebooks
