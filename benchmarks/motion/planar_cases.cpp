// Planar plates: the rule on short noisy records from release, beside what long clean runs with exponents say.
#include <iostream>

#include <fmt/format.h>

#include "motion/cases.h"
#include "motion/planar_motions.h"
#include "samara/models/batch/batch.h"
#include "samara/models/laws/registry.h"

namespace samara::benchmarks::motion_cases {

namespace {

using motion::Pattern;

constexpr Eigen::Index kPlates = 1200;

Labelled label_plates(const std::vector<Pattern>& truth, const std::vector<motion::MotionRecord>& records) {
  Labelled labels;
  std::vector<motion::Features> all;
  for (std::size_t n = 0; n < records.size(); ++n) {
    all.push_back(motion::features(records[n]));
    add(labels, truth[n], label(all.back()).pattern);
  }
  labels.source = source_clusters(all, 4);
  return labels;
}

/// Model sheet, section 3: rows of the regimes of the thin plate.
void run_regimes(const Options& options) {
  constexpr const char* kName = "regimes_table";
  if (!options.wants(kName)) return;
  struct Row {
    double inertia_ratio;
    Pattern pattern;
  };
  constexpr std::array kRows = {
      Row{0.5, Pattern::zigzag},        Row{0.8, Pattern::zigzag},        Row{1.0, Pattern::zigzag},
      Row{1.1, Pattern::zigzag},        Row{1.2, Pattern::zigzag},        Row{1.25, Pattern::autorotation},
      Row{1.3, Pattern::autorotation},  Row{1.35, Pattern::autorotation}, Row{1.4, Pattern::autorotation},
      Row{1.45, Pattern::autorotation}, Row{1.5, Pattern::mixed},         Row{1.6, Pattern::mixed},
      Row{1.7, Pattern::chaotic},       Row{2.1, Pattern::chaotic},       Row{2.5, Pattern::chaotic},
      Row{3.0, Pattern::zigzag},        Row{4.0, Pattern::zigzag}};
  Eigen::MatrixXd plates(static_cast<Eigen::Index>(kRows.size()), 6);
  for (std::size_t k = 0; k < kRows.size(); ++k)
    plates.row(static_cast<Eigen::Index>(k)) << kRows[k].inertia_ratio, 3.141592653589793, 1.2, 1.4, 0.2, 0.4;
  const std::vector<Pattern> found = final_patterns(plates);
  int right = 0;
  for (std::size_t k = 0; k < kRows.size(); ++k) {
    right += found[k] == kRows[k].pattern;
    if (found[k] != kRows[k].pattern)
      std::cerr << fmt::format("{}: I* {} is labelled {}\n", kName, kRows[k].inertia_ratio,
                               to_string(found[k]));
  }
  print({kMotion, kName, "right", static_cast<double>(right), "1"});
}

}  // namespace

void run_planar(const Options& options) {
  run_regimes(options);
  const bool usual = options.wants("patterns_planar"), longer = options.wants("patterns_planar_long");
  if (!usual && !longer) return;
  std::vector<Labelled> seeds, long_seeds;
  for (const std::uint64_t seed : fresh_seeds(options)) {
    const Eigen::MatrixXd plates = random_plates(seed, options.quick ? 400 : kPlates);
    const std::vector<Pattern> truth = final_patterns(plates);
    if (usual) seeds.push_back(label_plates(truth, noisy_records(plates, 120.0, 0.02, seed)));
    if (longer) long_seeds.push_back(label_plates(truth, noisy_records(plates, 240.0, 0.05, seed)));
  }
  if (usual) report_agreement("patterns_planar", seeds, true);
  if (longer) report_agreement("patterns_planar_long", long_seeds, true);
}

}  // namespace samara::benchmarks::motion_cases
