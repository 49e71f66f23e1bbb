#pragma once

#include <string>

#include "samara/codebooks/build.h"

/// A small codebook with both free parameters and initial values, built once per test program.
namespace samara::test {

inline const std::string& coin_plan() {
  static const std::string text =
      "model = \"vertical_fall\"\n"
      "[fixed]\narea = \"4.7144e-4 m^2\"\nthickness = \"2.55 mm\"\ndensity = \"6.3385 g/cm^3\"\n"
      "[box]\nC_D = [0.8, 1.6]\n\"v(0)\" = [\"-10 cm/s\", \"0.4 m/s\"]\n"
      "[time]\nend = \"0.4 s\"\n[tolerance]\nrelative = 1e-3\n";
  return text;
}

inline const codebooks::BuildResult& coin_build() {
  static const codebooks::BuildResult result =
      codebooks::build(codebooks::parse_plan(coin_plan(), "coin.toml"));
  return result;
}

}  // namespace samara::test
