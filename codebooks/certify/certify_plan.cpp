#include "samara/codebooks/certify/certify_plan.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/base/units.h"
#include "samara/codebooks/certify/measure.h"
#include "samara/codebooks/source/call_memory.h"

// Whether a plan's command may stand for the one that a codebook was sampled from, and the comparison.

namespace samara::codebooks {

namespace {

/// Units and powers of ten are read with rounding.
bool same(double a, double b) {
  constexpr double kRounding = 1e-12;
  return std::abs(a - b) <= kRounding * std::max(std::abs(a), std::abs(b));
}

void check_same(const std::string& what, const std::string& of_plan, const std::string& of_book) {
  if (of_plan == of_book) return;
  throw ArgumentError(
      fmt::format("{} \"{}\" in the plan and \"{}\" in the codebook", what, of_plan, of_book));
}

void check_unit(const std::string& name, const std::string& of_plan, const std::string& of_book) {
  if (same_dimension(of_plan, of_book)) return;
  throw ArgumentError(
      fmt::format("{} is in \"{}\" in the plan and in \"{}\" in the codebook", name, of_plan, of_book));
}

void check_count(const char* what, std::size_t of_plan, std::size_t of_book) {
  if (of_plan == of_book) return;
  throw ArgumentError(fmt::format("the plan has {} {}, the codebook {}", of_plan, what, of_book));
}

void check_interval(const std::string& name, double lower, double upper, const Coordinate& of_book) {
  if (same(lower, of_book.lower) && same(upper, of_book.upper)) return;
  throw ArgumentError(
      fmt::format("{} goes from {:.9g} to {:.9g} in the plan, from {:.9g} to {:.9g} in the codebook", name,
                  lower, upper, of_book.lower, of_book.upper));
}

void check_box(const Codebook& book, const Plan& plan) {
  check_count("free inputs", plan.box.size(), book.parameters().size());
  for (std::size_t k = 0; k < plan.box.size(); ++k) {
    const BoxEntry& entry = plan.box[k];
    const Coordinate& known = book.parameters()[k];
    check_same(fmt::format("free input {} is", k + 1), entry.name, known.name);
    const auto input = std::ranges::find(plan.command->inputs, entry.name, &CommandQuantity::name);
    check_unit(entry.name, input->unit, known.unit);
    check_interval(entry.name, entry.lower, entry.upper, known);
  }
}

void check_fixed(const Codebook& book, const Plan& plan) {
  const auto& known = book.model().fixed;
  check_count("fixed inputs", plan.fixed.size(), known.size());
  for (const auto& [name, value] : plan.fixed) {
    const auto it = known.find(name);
    if (it == known.end())
      throw ArgumentError(fmt::format("the plan fixes {}, which the codebook does not know", name));
    if (!same(value, it->second)) {
      throw ArgumentError(
          fmt::format("{} is {:.9g} in the plan and {:.9g} in the codebook", name, value, it->second));
    }
  }
}

void check_outputs(const Codebook& book, const Plan& plan) {
  const auto& outputs = plan.command->outputs;
  check_count("outputs", outputs.size(), book.outputs().size());
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    check_same(fmt::format("output {} is", o + 1), outputs[o].name, book.outputs()[o].name);
    check_unit(outputs[o].name, outputs[o].unit, book.outputs()[o].unit);
  }
}

void check_time(const Codebook& book, const Plan& plan) {
  if (book.has_time() != (plan.end > 0.0)) {
    throw ArgumentError(fmt::format("the plan has {}time, the codebook has {}", plan.end > 0.0 ? "" : "no ",
                                    book.has_time() ? "" : "none"));
  }
  if (book.has_time()) check_interval("t", 0.0, plan.end, book.coordinates().front());
}

void check_points(const Plan& plan, int points) {
  require(points >= 1, "points", points, "at least 1", "certify");
  const long allowed = plan.builder.max_calls > 0 ? plan.builder.max_calls : kMostSampledCalls;
  if (points <= allowed) return;
  throw ArgumentError(
      fmt::format("certificate points are {}, more than the {} calls that the plan allows", points, allowed));
}

}  // namespace

Certificate certify(const Codebook& book, const Plan& plan, const CertifyOptions& options) {
  if (!book.is_of_command()) {
    throw ArgumentError(fmt::format(
        "the codebook is a solution of the model {}, a plan's command has no say in it", book.model().name));
  }
  if (!plan.command)
    throw ArgumentError("the plan is one of a model, the codebook was sampled from a command");
  check_points(plan, options.points);
  check_outputs(book, plan);
  check_box(book, plan);
  check_fixed(book, plan);
  check_time(book, plan);
  CallMemory calls(command_source(plan), {}, {});
  Certificate certificate = measure(book, calls, options, Extent::all_points).certificate;
  calls.finish();
  certificate.integrator = fmt::format("the command of the plan: {}", fmt::join(plan.command->run, " "));
  return certificate;
}

}  // namespace samara::codebooks
