/// Round sheets of paper in air, from positions alone: how well 0.1 s beyond a window is predicted on drops
/// that had no part in the fit, beside predictions that know no body.
#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "cases.h"
#include "falling_paper.h"
#include "samara/identification/fit.h"

namespace samara::benchmarks::identification {

namespace {

using samara::identification::Baseline;
using samara::identification::Coefficient;
using samara::identification::FitOptions;
using samara::identification::FitResult;

constexpr const char* kCase = "falling_paper";
constexpr std::size_t kDrops = 20;
constexpr int kSplits = 3;
constexpr int kFrames = 20;

/// What is worst of the splits.
using Worst = std::map<std::string, double>;

void note(Worst& worst, const std::string& metric, double value) {
  const auto [place, is_new] = worst.try_emplace(metric, value);
  if (!is_new) place->second = std::max(place->second, value);
}

void one_split(const std::vector<samara::identification::Capture>& drops, std::uint64_t seed, Worst& worst) {
  const PaperSplit windows = split(drops, kDrops, kFrames, seed);
  const auto point = point_family();
  const FitResult of_point =
      samara::identification::fit(*point, captures_of(windows.fitted), point_options());
  note(worst, "next_median_point_drag",
       median_of(predict_unseen(*point, point_options(), of_point, windows.unseen).errors));
  const auto body = paper_family();
  const FitOptions options = paper_options();
  const FitResult fitted = samara::identification::fit(*body, captures_of(windows.fitted), options);
  const Prediction unseen = predict_unseen(*body, options, fitted, windows.unseen);
  note(worst, "fit_median", median_of(window_misfits(fitted)));
  note(worst, "next_median", median_of(unseen.errors));
  note(worst, "next_rms", rms_of(unseen.errors));

  note(worst, "next_median_quadratic", median_of(baseline_errors(Baseline::quadratic, windows.unseen)));
  note(worst, "next_median_cubic", median_of(baseline_errors(Baseline::cubic, windows.unseen)));
  const std::vector<double> line = baseline_errors(Baseline::straight_line, windows.unseen);
  note(worst, "next_median_line", median_of(line));
  note(worst, "next_rms_line", rms_of(line));

  fmt::print(stderr, "{} split {}: {} windows fitted in {:.1f} s ({}), {} unseen in {:.1f} s; fit {:.2f} mm, next {:.1f} "
                     "({:.1f}) mm, straight line {:.1f} ({:.1f})\n",
             kCase, seed, windows.fitted.size(), fitted.seconds, fitted.iterations, windows.unseen.size(), unseen.fit.seconds,
             1e3 * median_of(window_misfits(fitted)), 1e3 * median_of(unseen.errors),
             1e3 * rms_of(unseen.errors), 1e3 * median_of(line), 1e3 * rms_of(line));
  for (const Coefficient& c : fitted.coefficients) {
    fmt::print(stderr, "  {} {:.3g} +- {:.2g}\n", c.name, c.value, c.standard_error.value_or(-1.0));
  }
}

}  // namespace

void falling_paper_case(const Options& options) {
  if (!options.wants(kCase)) return;
  const std::filesystem::path folder = measured_set("falling-paper-cambridge");
  if (folder.empty()) return;
  const auto drops = paper_drops(folder);
  Worst worst;
  for (int seed = 1; seed <= (options.quick ? 1 : kSplits); ++seed) {
    one_split(drops, static_cast<std::uint64_t>(seed), worst);
  }
  for (const auto& [metric, value] : worst) print({kBench, kCase, metric, value, "m"});
}

}  // namespace samara::benchmarks::identification
