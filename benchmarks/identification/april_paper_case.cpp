/// A paper card whose rough pose three cameras saw: what a fit may and may not claim.
#include <algorithm>

#include <fmt/format.h>

#include "april_paper.h"
#include "cases.h"
#include "real_data.h"
#include "samara/identification/fit/fit.h"

namespace samara::benchmarks::identification {

namespace {

using samara::identification::FitResult;

constexpr const char* kCase = "april_paper";

}  // namespace

void april_paper_case(const Options& options) {
  const auto folder = measured_set(options, kCase, "paper-6dof-apriltag");
  if (!folder) return;
  const auto windows = april_windows(*folder);
  const FitResult fitted = samara::identification::fit(*april_family(kAprilSize), windows, april_options());
  const auto variants = april_variants(windows, !options.quick);
  fmt::print(stderr, "{}: {} windows, {}\n", kCase, windows.size(), fitted.message);
  for (const std::string& sentence : fitted.warnings.sentences())
    fmt::print(stderr, "  warning: {}\n", sentence);

  int identified = 0;
  for (const AprilVerdict& v : april_verdicts(fitted, variants)) {
    identified += v.identified ? 1 : 0;
    fmt::print(stderr, "  {}: {} (value {:.3g}, error {:.2g}, change {:.2g})\n", v.name, v.words, v.value,
               v.error, v.change);
    // A coefficient that is not identified is no number.
    if (v.identified) print({kBench, kCase, v.name, v.value});
  }
  print({kBench, kCase, "converged", fitted.status == Termination::converged ? 1.0 : 0.0});
  print({kBench, kCase, "identified", static_cast<double>(identified)});
  print({kBench, kCase, "windows", static_cast<double>(windows.size())});
  for (const auto& output : fitted.residuals) {
    print({kBench, kCase, fmt::format("rms_{}", output.output), output.rms, output.unit});
  }
  print({kBench, kCase, "time", fitted.seconds, "s"});
}

}  // namespace samara::benchmarks::identification
