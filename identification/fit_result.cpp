#include "samara/identification/fit_result.h"

#include "samara/base/errors.h"

namespace samara::identification {

std::string to_string(FitStatus status) {
  switch (status) {
    case FitStatus::converged:
      return "converged";
    case FitStatus::not_determined:
      return "not determined";
    case FitStatus::iteration_limit:
      return "iteration limit";
    case FitStatus::failed:
      return "failed";
  }
  throw ArgumentError("a status of no known kind");
}

}  // namespace samara::identification
