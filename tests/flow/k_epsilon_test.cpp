#include <cmath>

#include <catch2/catch.hpp>

#include "flow_cases.h"

using namespace samara::flow;
using namespace flow_cases;

TEST_CASE("turbulence decays exactly, in any number of steps", "[flow]") {
  for (const int steps : {1, 7, 100}) {
    double k = 1.5, epsilon = 1.0;
    for (int s = 0; s < steps; ++s) decay(k, epsilon, 10.0 / steps);
    CHECK(k == Approx(0.17725536585951804).epsilon(1e-12));
    CHECK(epsilon == Approx(0.01656592204294562).epsilon(1e-12));
  }
}
