#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "report.h"
#include "samara/motion/patterns/agreement.h"
#include "samara/motion/patterns/pattern_rules.h"
#include "samara/motion/planning/motion_plan.h"

namespace samara::benchmarks::motion_cases {

inline constexpr const char* kMotion = "motion";

/// Seeds of the figures, drawn after the rule and its thresholds were frozen: those used while they were made are 7,
/// 11 and 12.
std::vector<std::uint64_t> fresh_seeds(const Options& options);

/// Labels of one seed: by the truth, the rule, and clusters of the source's (d, e).
struct Labelled {
  std::vector<int> truth, rule, source;
  void add(const Labelled& more);
};

void add(Labelled& to, motion::Pattern truth, motion::Pattern rule);

/// Prints share, balanced share and adjusted Rand index over all seeds pooled, with 95 % intervals from the scatter
/// between seeds in the note on stderr.
void report_agreement(const std::string& test_case, const std::vector<Labelled>& seeds, bool with_source);

/// Clusters of (d, e), standardised.
std::vector<int> source_clusters(const std::vector<motion::Features>& all, int clusters);

/// A plate of I* 1.3 that is to fall along an S, 60 semi-chords down.
motion::MotionPlan s_plan();

void run_planar(const Options& options);
void run_positions(const Options& options);
void run_measured(const Options& options);
void run_sweeps(const Options& options);
void run_sketches(const Options& options);
void run_books(const Options& options);
void run_databases(const Options& options);
void run_walks(const Options& options);
void run_films(const Options& options);

}  // namespace samara::benchmarks::motion_cases
