#pragma once

#include <string>
#include <utility>

#include "samara/codebooks/build/build.h"

// Plans of builds by steps.

inline const std::string kSteps = "kind = \"sampling\"\nstrategy = \"steps\"\n";

/// The reference plate over three coefficients, to its first swing.
inline std::string stepped_plate(const std::string& builder, const std::string& end = "2") {
  return "model = \"falling_plate_nd\"\n[box]\nC_T = [0.9, 1.3]\nC_R = [2.5, 3.3]\nA = [1.2, "
         "1.6]\n[time]\nend = " +
         end + "\n[tolerance]\nrelative = 1e-3\n[builder]\n" + builder;
}

inline samara::codebooks::BuildResult built_by_steps(const std::string& text,
                                                     samara::codebooks::BuildOptions options = {
                                                         .certificate_points = 200}) {
  return samara::codebooks::build(samara::codebooks::parse_plan(text, "plan.toml"), options);
}
