#pragma once

#include "samara/base/check.h"
#include "samara/pgd/evolution/adaptive_problem.h"

/// The test for an evolution system of your own.
///
///   for (const std::string& finding : samara::pgd::check_system(problem).findings) std::cerr << finding << "\n";
///
/// At random times, parameters of the problem's box, and states within a scale of the initial values it
///  - asks for rates and Jacobians of one point and of many: the numbers must be the same, finite, and of the
///    promised shape, whatever the results held before;
///  - compares the Jacobian with central differences of the rates;
///  - asks from several threads at once;
///  - where the system says that it is affine in the parameters, takes two parameter points and their mean;
///  - where it says that it is a polynomial, compares its rates with the polynomial's.
namespace samara::pgd {

struct CheckSystemOptions {
  unsigned seed = 1;
  int points = 50;
  /// Largest |entry - central difference| over |entry| + |f| / (size of the state). Differences over a step of
  /// 6e-6 of the state are good to about 1e-9 in this measure where f is smooth.
  double tolerance = 1e-6;
};

/// @throws ArgumentError if the problem or an option is outside its meaning; what the system throws passes
/// through.
Check check_system(const AdaptiveProblem& problem, const CheckSystemOptions& options = {});

}  // namespace samara::pgd
