#include "samara/codebooks/book/certificate.h"

#include <cmath>

#include <boost/math/special_functions/beta.hpp>
#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::codebooks {

double share_above(int wrong, int points, int refuted_before) {
  constexpr double kChanceOfError = 0.05;
  if (points < 1 || wrong < 0 || wrong > points || refuted_before < 0) {
    throw ArgumentError(
        fmt::format("{} of {} points are wrong after {} refutations, expected 0 to all of some", wrong,
                    points, refuted_before));
  }
  if (wrong == points) return 1.0;
  return boost::math::ibeta_inv(wrong + 1.0, static_cast<double>(points - wrong),
                                1.0 - std::ldexp(kChanceOfError, -refuted_before));
}

}  // namespace samara::codebooks
