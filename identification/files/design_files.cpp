#include "samara/identification/files/design_files.h"

#include "samara/identification/design/experiment.h"
#include "samara/identification/files/fit_source.h"
#include "samara/identification/report/read_fit.h"

namespace samara::identification {

Design design_files(const DesignRequest& request) {
  const FitResult fitted = read_fit(request.fit);
  const FitSource source = open_fit_source({.source = request.source, .config = request.config});
  const models::FamilyInfo& info = source.family->info();
  of_file(request.fit, [&] { check_fitted(info, fitted); });
  Warnings doubts = source.warnings;
  doubt_held_values(fitted, info, request.fit.string(), doubts);
  for (const Warning& doubt : doubts) {
    if (request.warning) request.warning(doubt.sentence);
  }
  return design_experiment(*source.family, fitted, request.options ? request.options(info) : DesignOptions{});
}

}  // namespace samara::identification
