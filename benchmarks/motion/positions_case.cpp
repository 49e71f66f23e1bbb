// Six patterns from places alone: plates at random azimuth, and drawn spirals and helices.
#include <array>
#include <cmath>
#include <iostream>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "motion/cases.h"
#include "motion/planar_motions.h"
#include "samara/base/streams.h"
#include "samara/models/bodies/kinematic_paths.h"

namespace samara::benchmarks::motion_cases {

namespace {

using motion::MotionRecord;
using motion::Pattern;

constexpr double kNoise = 0.02;  // a

void turn(MotionRecord& record, double azimuth) {
  const Eigen::MatrixX2d ground = record.positions.leftCols<2>();
  Eigen::Matrix2d rotation;
  rotation << std::cos(azimuth), -std::sin(azimuth), std::sin(azimuth), std::cos(azimuth);
  record.positions.leftCols<2>() = ground * rotation.transpose();
}

/// Circles (or, with lobes, helices) that drift and are a little elliptic, 1.5 to 5 revolutions in the settled half.
MotionRecord drawn(bool helix, Stream& stream) {
  const auto between = [&](double lower, double upper) { return lower + (upper - lower) * stream.uniform(); };
  models::RosePath path;
  path.descent_speed = between(0.4, 1.2);
  path.amplitude_x = between(0.6, 3.0);
  path.amplitude_y = path.amplitude_x * between(0.9, 1.1);
  path.angular_frequency = 2.0 * std::numbers::pi * between(1.5, 5.0) / 30.0;
  path.lobes = 4.0;
  path.modulation = helix ? between(0.3, 0.8) : 0.0;
  const Eigen::RowVector2d drift(between(-0.1, 0.1), between(-0.1, 0.1));
  const double sense = stream.uniform() < 0.5 ? -1.0 : 1.0;
  MotionRecord record;
  record.times = 0.25 * Eigen::VectorXd::LinSpaced(241, 0.0, 240.0);
  record.positions.resize(241, 3);
  for (Eigen::Index k = 0; k < 241; ++k) {
    const Eigen::Vector3d p = at(path, record.times[k]).position;
    record.positions.row(k) << p.x() + drift.x() * record.times[k],
        sense * p.y() + drift.y() * record.times[k], p.z();
    for (int c = 0; c < 3; ++c) record.positions(k, c) += kNoise * stream.normal();
  }
  record.length = 2.0;
  turn(record, 2.0 * std::numbers::pi * stream.uniform());
  return record;
}

/// The first plates of each of four patterns, seen from places alone.
void add_plates(const Eigen::MatrixXd& plates, std::uint64_t seed, int wanted, std::array<int, 4>& counts,
                std::vector<motion::Features>& all, Labelled& labels) {
  const std::vector<Pattern> truth = final_patterns(plates);
  const std::vector<MotionRecord> records = noisy_records(plates, 60.0, kNoise, seed);
  for (std::size_t n = 0; n < records.size(); ++n) {
    const auto kind = static_cast<std::size_t>(truth[n]);
    if (kind >= counts.size() || counts[kind] == wanted) continue;
    ++counts[kind];
    MotionRecord record = records[n];
    record.angles.resize(0);
    Stream stream(seed + 1, n);
    for (double& y : record.positions.col(1)) y = kNoise * stream.normal();
    turn(record, 2.0 * std::numbers::pi * stream.uniform());
    all.push_back(motion::features(record));
    add(labels, truth[n], label(all.back()).pattern);
  }
}

}  // namespace

void run_positions(const Options& options) {
  constexpr const char* kName = "patterns_positions";
  if (!options.wants(kName)) return;
  const int wanted = options.quick ? 30 : 120;
  std::vector<Labelled> seeds;
  int spirals = 0, drawn_paths = 0;
  for (const std::uint64_t drawn_seed : fresh_seeds(options)) {
    // The rule for positions was changed once after a look at the ten themselves.
    const std::uint64_t seed = drawn_seed + 1000000;
    Labelled labels;
    std::vector<motion::Features> all;
    std::array<int, 4> counts = {};
    add_plates(random_plates(seed, 4 * wanted), seed, wanted, counts, all, labels);
    add_plates(lively_plates(seed, 14 * wanted), seed, wanted, counts, all, labels);
    for (const bool helix : {false, true}) {
      for (int n = 0; n < wanted; ++n) {
        Stream stream(seed + 2, static_cast<std::uint64_t>(2 * n + helix));
        all.push_back(motion::features(drawn(helix, stream)));
        const Pattern truth = helix ? Pattern::helix : Pattern::spiral;
        const Pattern found = label(all.back()).pattern;
        add(labels, truth, found);
        spirals += found == truth;
        ++drawn_paths;
      }
    }
    labels.source = source_clusters(all, 6);
    seeds.push_back(std::move(labels));
  }
  report_agreement(kName, seeds, true);
  print({kMotion, kName, "spirals_right", 240.0 * spirals / drawn_paths, "of 240"});
}

}  // namespace samara::benchmarks::motion_cases
