/// One planar fit with segment maps from three places: an a priori codebook, a sampled one, and direct
/// integration with sensitivities. Answers and times beside each other.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cases.h"
#include "plate.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/composition/mixed_trajectories.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/identification/fit/fit.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/reference_trajectories.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::benchmarks::identification {

namespace {

namespace id = samara::identification;

constexpr const char* kCase = "codebook_vs_direct";
constexpr double kInertia = 1.1;  ///< flutter: the plate does not turn over
constexpr double kSegment = 0.5;

/// An eighth to each side of what is usual; of C_T, which the motion hardly determines, three.
std::map<std::string, samara::models::Interval> coefficient_box() {
  std::map<std::string, samara::models::Interval> box;
  for (const Truth& c : plate_coefficients()) {
    const double share = c.name == "C_T" ? 0.3 : 0.12;
    box[c.name] = {(1.0 - share) * c.value, (1.0 + share) * c.value};
  }
  return box;
}

/// Codebooks cover the coefficients of the fit, and nearly every start of a segment of the flutter; elsewhere the fit
/// integrates.
codebooks::Codebook book(const std::string& kind) {
  std::string plan = fmt::format(
      "model = \"falling_plate_nd\"\n"
      "[fixed]\ninertia_ratio = {}\nbeta = {}\nB = 1.0\n\"x(0)\" = 0.0\n\"y(0)\" = 0.0\n"
      "[box]\n\"theta(0)\" = [-1.7, 1.7]\n\"vx(0)\" = [-2.2, 2.2]\n\"vy(0)\" = [-1.1, 0.7]\n\"w(0)\" = "
      "[-1.3, 1.3]\n",
      kInertia, 1.0 / 14.0);
  for (const auto& [name, interval] : coefficient_box())
    plan += fmt::format("{} = [{}, {}]\n", name, interval.lower, interval.upper);
  plan += fmt::format(
      "[time]\nend = 0.52\n[tolerance]\nrelative = 1e-3\n[builder]\nkind = \"{}\"\nmax_calls = {}\n", kind,
      kind == "pgd" ? 1000000000 : 1000000);
  return codebooks::build(codebooks::parse_plan(plan, "plan.toml")).book;
}

struct Answer {
  id::FitResult fit;
  double seconds = 0.0;
};

Answer answer(const samara::models::TrajectoryFamily& family, const id::Capture& capture,
              const id::FitOptions& options) {
  Answer result;
  result.seconds = time_of([&] { result.fit = id::fit(family, std::vector{capture}, options); }, 3, 0.0);
  return result;
}

double largest_difference(const id::FitResult& a, const id::FitResult& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.coefficients.size(); ++k) {
    const double error = b.coefficients[k].naive_standard_error.value_or(std::nan(""));
    largest = std::max(largest, std::abs(a.coefficients[k].value - b.coefficients[k].value) / error);
  }
  return largest;
}

}  // namespace

void segment_map_case(const Options& options) {
  if (!options.wants(kCase) && !options.wants("segments_book")) return;
  pgd::Random random(1);
  const id::Capture capture = plate_capture(kInertia, random);
  id::FitOptions fit_options = plate_options();
  fit_options.segments.length = kSegment;
  fit_options.unknowns.box = coefficient_box();
  const auto model = models::find_model("falling_plate_nd");
  const auto fixed = plate_fixed(kInertia);
  const auto box = plate_box();
  const auto steps = [&] { return samara::models::step_trajectories(model, fixed, box, 0.01); };
  const Answer exact =
      answer(*samara::models::reference_trajectories(model, fixed, box), capture, fit_options);
  const auto report = [&](const std::string& name, const Answer& one) {
    print({kBench, kCase, "difference_in_stderr_" + name, largest_difference(one.fit, exact.fit)});
    print({kBench, kCase, "time_" + name, one.seconds, "s", "cvodes", exact.seconds / one.seconds});
  };
  const auto by_steps = steps();
  if (options.wants(kCase)) report("steps", answer(*by_steps, capture, fit_options));
  for (const std::string kind : {"pgd", "sampling"}) {
    if (kind != "pgd" && !options.wants(kCase)) continue;
    const codebooks::Codebook made = book(kind);
    const auto by_book = samara::codebooks::mixed_trajectories(made, steps());
    if (options.wants(kCase)) {
      const double error = made.certificate() ? made.certificate()->max_error : std::nan("");
      print({kBench, kCase, "certificate_" + kind, error});
      report(kind, answer(*by_book, capture, fit_options));
    }
    if (kind != "pgd" || !options.wants("segments_book")) continue;
    id::FitResult found;
    const Pair times =
        time_both([&] { found = id::fit(*by_book, std::vector{capture}, fit_options); },
                  [&] { id::fit(*by_steps, std::vector{capture}, fit_options); }, options.quick ? 5 : 25);
    print({kBench, "segments_book", "time", times.ours, "s", "steps", times.ratio()});
    print({kBench, "segments_book", "difference_in_stderr", largest_difference(found, exact.fit)});
  }
}

}  // namespace samara::benchmarks::identification
