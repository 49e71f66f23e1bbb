// The card of the dissertation over its three coefficients: persistence of labels, figure 5.6, the cost of a sweep,
// and what a refined grid may inherit.
#include <algorithm>
#include <array>
#include <chrono>
#include <iostream>

#include <fmt/format.h>

#include "motion/cases.h"
#include "samara/motion/patterns/clusters.h"
#include "samara/motion/sweeps/pattern_map.h"
#include "samara/motion/sweeps/refining.h"

namespace samara::benchmarks::motion_cases {

namespace {

using motion::Pattern;
using motion::Sweep;

motion::SweepPlan card_plan(const std::string& axes, const std::string& releases, const std::string& run) {
  return motion::parse_sweep_plan(R"(model = "immersed_body"
[fixed]
a = "3.5 cm"
b = "2 cm"
c = "0.01 cm"
density = 1200
C_D0 = 0.05
C_w = 2
[axes]
)" + axes + "[releases]\ntilt = [\"10 deg\"]\n" +
                                      releases + "[run]\nstep = \"1 ms\"\n" + run,
                                  "benchmark");
}

std::string grid(int count) {
  std::string text;
  for (const char* name : {"C_D90", "C_T", "C_R"})
    text += fmt::format("{} = {{ from = 0.31, to = 2.71, count = {} }}\n", name, count);
  return text;
}

Labelled labels_of(const Sweep& truth, const Sweep& answer, Eigen::Index release) {
  Labelled labels;
  std::vector<motion::Features> all;
  for (Eigen::Index n = 0; n < truth.fall_count(); ++n) {
    if (truth.release_of(n) != release) continue;
    const auto k = static_cast<std::size_t>(n);
    add(labels, truth.labels[k].pattern, answer.labels[k].pattern);
    all.push_back(answer.features[k]);
  }
  labels.source = source_clusters(all, 4);
  return labels;
}

void run_persistence(const Options& options) {
  constexpr const char* kName = "patterns_body3d";
  if (!options.wants(kName)) return;
  const std::string releases = "axis = [\"0 deg\", \"35 deg\"]\n";
  const std::string axes = grid(options.quick ? 5 : 9);
  const Sweep truth =
      run_sweep(card_plan(axes, releases, "until = \"7 s\"\nsettle = \"2 s\"\nspread = true\n")).sweep;
  const Sweep answer = run_sweep(card_plan(axes, releases, "until = \"3 s\"\n")).sweep;
  for (const Eigen::Index release : {0, 1}) {
    const Labelled labels = labels_of(truth, answer, release);
    const motion::Agreement both =
        motion::agreement(labels.truth, labels.rule, static_cast<int>(motion::kPatterns));
    std::cerr
        << fmt::format(
               "{}, release {}: balanced {:.3f}, ari {:.3f}, ari of (d, e) {:.3f}; rows 7 s, columns 3 s "
               "({})\n",
               kName, release, both.balanced, both.adjusted_rand,
               motion::adjusted_rand(labels.truth, labels.source), fmt::join(motion::pattern_names(), " "))
        << both.confusion << '\n';
    print({kMotion, kName, release == 0 ? "agreement_planar" : "agreement_oblique", both.share, "1"});
  }
}

void run_figure(const Options& options) {
  constexpr const char* kName = "figure_5_6";
  if (!options.wants(kName)) return;
  struct Set {
    const char* name;
    double C_D90, C_T, C_R;
    Pattern pattern;
  };
  int right = 0;
  for (const Set& set :
       {Set{"SD", 1.81, 0.31, 0.31, Pattern::zigzag}, Set{"ZZ", 0.31, 0.91, 0.61, Pattern::zigzag},
        Set{"AZ", 0.61, 1.81, 1.21, Pattern::chaotic}, Set{"AR", 0.61, 2.71, 0.91, Pattern::autorotation}}) {
    const Sweep sweep = run_sweep(card_plan(fmt::format("C_D90 = [{}]\nC_T = [{}]\nC_R = [{}]\n", set.C_D90,
                                                        set.C_T, set.C_R),
                                            "", "until = \"7 s\"\nsettle = \"2 s\"\n"))
                            .sweep;
    right += sweep.labels.front().pattern == set.pattern;
    std::cerr << fmt::format("{}: {} is {}, {}\n", kName, set.name, to_string(sweep.labels.front().pattern),
                             sweep.labels.front().why);
  }
  print({kMotion, kName, "right", static_cast<double>(right), "of 4"});
}

void run_cost(const Options& options) {
  constexpr const char* kName = "sweep4913";
  if (!options.wants(kName)) return;
  constexpr double kSource = 4.0 * 3600.0;  // s, of as many falls
  const motion::SweepPlan plan = card_plan(grid(17), "", "until = \"3 s\"\n");
  double best = 1e300;
  for (int k = 0; k < (options.quick ? 1 : 5); ++k)
    best = std::min(best, run_sweep(plan, {.threads = 2}).seconds);
  print({kMotion, kName, "time", best, "s", "the source's sweep", kSource / best});
}

void run_resample(const Options& options) {
  constexpr const char* kName = "resample";
  if (!options.wants(kName)) return;
  const motion::SweepPlan plan = card_plan(grid(9), "", "until = \"3 s\"\n");
  const Sweep whole = run_sweep(card_plan(grid(17), "", "until = \"3 s\"\n")).sweep;
  Sweep refined = run_sweep(plan).sweep;
  const double old = static_cast<double>(refined.fall_count());
  refine(plan, {}, refined);
  double inherited = 0.0, wrong = 0.0;
  for (std::size_t n = 0; n < refined.labels.size(); ++n) {
    if (refined.status[n] != motion::FallStatus::inherited) continue;
    inherited += 1.0;
    wrong += refined.labels[n].pattern != whole.labels[n].pattern;
  }
  const double fresh = static_cast<double>(refined.fall_count()) - old;
  print({kMotion, kName, "inherited_wrong", wrong / inherited, "1"});
  print({kMotion, kName, "simulated_fraction", 1.0 - inherited / fresh, "1"});
}

}  // namespace

void run_sweeps(const Options& options) {
  run_persistence(options);
  run_figure(options);
  run_cost(options);
  run_resample(options);
}

}  // namespace samara::benchmarks::motion_cases
