// The reference plate in slabs, with three, five and seven free coordinates.
#include <string>

#include "built.h"
#include "cases.h"
#include "problems.h"

namespace samara::benchmarks {

namespace {

struct PlateCase {
  const char* name;
  int coordinates;
  double end;
  double tolerance;
  int max_cells = 1;
};

}  // namespace

void run_plates(const Options& options) {
  for (const PlateCase& plate :
       {PlateCase{"plate3_t5", 3, 5.0, 1e-4}, PlateCase{"plate3_t8", 3, 8.0, 5e-4},
        PlateCase{"plate5_t5", 5, 5.0, 1e-3}, PlateCase{"plate7_t4", 7, 4.0, 1e-3}}) {
    if (!options.wants(plate.name)) continue;
    codebooks::Plan plan = plate_plan(plate.coordinates, plate.end, plate.tolerance);
    plan.builder.max_cells = plate.max_cells;
    const Built built = build_and_measure(plan, options.quick ? 500 : 2000);
    print({kNonlinear, plate.name, "certificate_max", built.certificate_max});
    print({kNonlinear, plate.name, "rank", static_cast<double>(built.rank)});
    print({kNonlinear, plate.name, "time", built.time, "s"});
    // Asked for with 14 nodes a coordinate; the builder's own grids are smaller.
    print({kNonlinear, plate.name, "evaluation_fraction", built.evaluation_fraction_14});
    print({kNonlinear, plate.name, "evaluation_fraction_own_grid", built.evaluation_fraction});
    print({kNonlinear, plate.name, "met", built.met ? 1.0 : 0.0});
  }
}

}  // namespace samara::benchmarks
