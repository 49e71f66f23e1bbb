#include "motion/planar_motions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string_view>

#include "samara/base/streams.h"
#include "samara/models/batch/batch.h"
#include "samara/models/laws/registry.h"

namespace samara::benchmarks::motion_cases {

namespace {

struct Range {
  const char* name;
  double lower, upper;
};
constexpr std::array kBox = {Range{"inertia_ratio", 0.5, 4.0}, Range{"C_R", 1.2, 4.0},
                             Range{"C_T", 0.6, 1.6},           Range{"A", 1.1, 1.8},
                             Range{"mu1", 0.12, 2.0},          Range{"theta(0)", 0.05, 1.4}};

constexpr double kFrame = 0.25;  // a/U

models::ParametricModel thin_plate() {
  std::vector<std::string> free;
  for (const Range& range : kBox) free.emplace_back(range.name);
  return {models::find_model("falling_plate_nd"), {{"beta", 0.0}}, free};
}

std::vector<double> frames(double from, double until) {
  std::vector<double> times;
  for (int k = 0; from + k * kFrame <= until + 1e-9; ++k) times.push_back(from + k * kFrame);
  return times;
}

/// Chunks, so that long runs of many plates fit into memory.
void in_chunks(const Eigen::MatrixXd& plates, const std::vector<double>& times,
               const models::BatchOptions& options,
               const std::function<void(const models::BatchTrajectories&, Eigen::Index, Eigen::Index)>& see) {
  constexpr Eigen::Index kChunk = 120;
  const models::ParametricModel plate = thin_plate();
  for (Eigen::Index first = 0; first < plates.rows(); first += kChunk) {
    const Eigen::Index count = std::min(kChunk, plates.rows() - first);
    const models::BatchTrajectories batch =
        integrate_batch(plate, plates.middleRows(first, count), times, options);
    for (Eigen::Index n = 0; n < count; ++n) see(batch, n, first + n);
  }
}

motion::MotionRecord record_of(const models::BatchTrajectories& batch, Eigen::Index n) {
  const Eigen::Index count = batch.times.size();
  const auto states = batch.states.middleCols(batch.column(n, 0), count);
  motion::MotionRecord record;
  record.times = batch.times;
  record.positions.setZero(count, 3);
  record.positions.col(0) = states.row(4);
  record.positions.col(2) = states.row(5);
  record.angles = states.row(3);
  record.length = 2.0;
  return record;
}

}  // namespace

Eigen::MatrixXd random_plates(std::uint64_t seed, Eigen::Index count) {
  Eigen::MatrixXd points(count, static_cast<Eigen::Index>(kBox.size()));
  for (Eigen::Index n = 0; n < count; ++n) {
    Stream stream(seed, static_cast<std::uint64_t>(n));
    for (std::size_t k = 0; k < kBox.size(); ++k) {
      const auto& [name, lower, upper] = kBox[k];
      const double u = stream.uniform();
      // Damping evenly in its logarithm: else three quarters of all plates descend steadily.
      points(n, static_cast<Eigen::Index>(k)) =
          std::string_view(name) == "mu1" ? lower * std::pow(upper / lower, u) : lower + (upper - lower) * u;
    }
  }
  return points;
}

Eigen::MatrixXd lively_plates(std::uint64_t seed, Eigen::Index count) {
  Eigen::MatrixXd points(count, static_cast<Eigen::Index>(kBox.size()));
  Eigen::Index found = 0;
  // Plates of the box, one stream after another, as long as it takes.
  for (Eigen::Index n = 0; found < count; ++n) {
    const Eigen::RowVectorXd plate = random_plates(seed + 7919 + static_cast<std::uint64_t>(n), 1);
    if (plate[1] > 2.5 && plate[4] < 0.3) points.row(found++) = plate;
  }
  return points;
}

std::vector<motion::Pattern> final_patterns(const Eigen::MatrixXd& plates) {
  std::vector<motion::Pattern> patterns(static_cast<std::size_t>(plates.rows()));
  in_chunks(plates, frames(300.0, 1000.0), {.step = 0.03, .tangents = {"theta(0)"}},
            [&](const models::BatchTrajectories& batch, Eigen::Index n, Eigen::Index plate) {
              const Eigen::Index last = batch.times.size() - 1;
              const auto size = [&](Eigen::Index k) {
                return batch.tangents[0].col(batch.column(n, k)).head<4>().norm();
              };
              motion::MotionRecord record = record_of(batch, n);
              record.position_noise = record.angle_noise = 0.0;
              const double exponent = std::log(size(last) / size(0)) / (batch.times[last] - batch.times[0]);
              motion::FeatureOptions watched = {.settle_share = 0.0};
              if (std::isfinite(exponent)) watched.exponent = exponent;  // the tangent may have died out
              patterns[static_cast<std::size_t>(plate)] = label(motion::features(record, watched)).pattern;
            });
  return patterns;
}

std::vector<motion::MotionRecord> noisy_records(const Eigen::MatrixXd& plates, double until, double noise,
                                                std::uint64_t seed) {
  std::vector<motion::MotionRecord> records;
  in_chunks(plates, frames(0.0, until), {.step = 0.03},
            [&](const models::BatchTrajectories& batch, Eigen::Index n, Eigen::Index plate) {
              motion::MotionRecord record = record_of(batch, n);
              Stream stream(seed ^ 0x5bd1e995, static_cast<std::uint64_t>(plate));
              for (Eigen::Index k = 0; k < record.frame_count(); ++k) {
                record.positions(k, 0) += noise * stream.normal();
                record.positions(k, 2) += noise * stream.normal();
                record.angles[k] += 2.5 * noise * stream.normal();
              }
              records.push_back(std::move(record));
            });
  return records;
}

}  // namespace samara::benchmarks::motion_cases
