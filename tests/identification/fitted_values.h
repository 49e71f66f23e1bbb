#pragma once

#include <algorithm>
#include <string>

#include <catch2/catch.hpp>

#include "samara/identification/problem/fit_result.h"

/// Values of a fit by their names.
inline const samara::identification::Nuisance& own_of(const samara::identification::FitResult& result,
                                                      std::size_t capture, const std::string& name) {
  const auto& nuisances = result.captures.at(capture).nuisances;
  const auto found = std::ranges::find(nuisances, name, &samara::identification::Nuisance::name);
  REQUIRE(found != nuisances.end());
  return *found;
}

inline const samara::identification::Coefficient& shared_of(const samara::identification::FitResult& result,
                                                            const std::string& name) {
  const auto found = std::ranges::find(result.coefficients, name, &samara::identification::Coefficient::name);
  REQUIRE(found != result.coefficients.end());
  return *found;
}
