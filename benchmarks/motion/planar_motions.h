#pragma once

#include <cstdint>
#include <vector>

#include "samara/motion/patterns/pattern_rules.h"

namespace samara::benchmarks::motion_cases {

/// Random thin plates: I* 0.5 to 4, C_R 1.2 to 4, C_T 0.6 to 1.6, A 1.1 to 1.8, mu 0.12 to 2 (evenly in its logarithm),
/// theta(0) 0.05 to 1.4.
/// Point n is drawn from stream n of the seed. Plates x coordinates.
Eigen::MatrixXd random_plates(std::uint64_t seed, Eigen::Index count);

/// Of these, weakly damped ones with much rotational lift: mu below 0.3, C_R above 2.5. Most turn over.
Eigen::MatrixXd lively_plates(std::uint64_t seed, Eigen::Index count);

/// What plates do in the end: 300 a/U left out, 700 watched, exponents by tangents.
std::vector<motion::Pattern> final_patterns(const Eigen::MatrixXd& plates);

/// Records from the release on, of `until` a/U, frames 0.25 a/U apart, with noise of that deviation in places (a),
/// and 2.5 times that in theta (rad), drawn from stream n of the seed.
std::vector<motion::MotionRecord> noisy_records(const Eigen::MatrixXd& plates, double until, double noise,
                                                std::uint64_t seed);

}  // namespace samara::benchmarks::motion_cases
