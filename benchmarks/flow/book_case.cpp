// A codebook of loads and energy over the angle of attack and the Reynolds number.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "cases.h"
#include "samara/flow/books/energy_book.h"
#include "samara/flow/books/planned_flow.h"

namespace samara::benchmarks {

namespace {

/// A plate of an eighth of its width in a stream. Quick: an ellipse at low Reynolds numbers on a coarse grid, which
/// shows that the case runs and is no figure.
std::string plan_text(bool quick) {
  if (quick)
    return R"([flow]
shape = { kind = "ellipse", length = 1, thickness = 0.5 }
reynolds = 30
turbulence = "none"
cells_per_length = 4
extent = { before = 1.5, behind = 2, side = 1.5 }
end = "steady"
max_time = 300
[box]
log10_reynolds = [1.45, 1.65]
[book]
certificate_points = 3
)";
  return R"([flow]
shape = { kind = "rectangle", length = 1, thickness = 0.125 }
reynolds = 2e4
turbulence = "k-epsilon"
cells_per_length = 16
end = "mean"
max_time = 1000
[box]
angle_of_attack = ["30 deg", "90 deg"]
log10_reynolds = [4, 5]
[book]
max_calls = 40
certificate_points = 8
)";
}

}  // namespace

void run_energy_book(const Options& options) {
  if (options.only_case != "energy_book") return;
  const flow::FlowPlan plan = flow::parse_flow_plan(plan_text(options.quick), "energy_book");
  codebooks::BuildOptions build;
  build.checkpoint = options.quick ? "flow_energy_book_quick.checkpoint" : "flow_energy_book.checkpoint";
  build.keep_checkpoint = true;
  build.resume = true;
  const codebooks::BuildResult result = flow::build_energy_book(plan, build);
  const std::vector<codebooks::OutputError>& outputs = result.book.certificate()->outputs;
  const auto worst_of = [&](const auto& error_of) {
    double worst = 0.0;
    for (const char* name : {"C_D", "k_near", "strouhal"}) {
      const auto output = std::ranges::find(outputs, name, &codebooks::OutputError::name);
      worst = std::max(worst, error_of(output - outputs.begin()));
    }
    return worst;
  };
  print({kFlow, "energy_book", "calls", result.book.build().evaluations, "flows"});
  print({kFlow, "energy_book", "certificate_max",
         worst_of([&](std::ptrdiff_t o) { return outputs[static_cast<std::size_t>(o)].max; }), "1",
         "flows the builder did not see"});
  for (const codebooks::OutputError& output : outputs)
    print({kFlow, "energy_book", "certificate_max_" + output.name, output.max, "1",
           "flows the builder did not see"});
  // The flows on twice the cells are the longest, and come when all else is said.
  const Eigen::VectorXd change = flow::discretisation(plan, result.book, build);
  print({kFlow, "energy_book", "discretisation", worst_of([&](std::ptrdiff_t o) { return change[o]; }), "1",
         "twice the cells"});
  for (const std::filesystem::path& kept : {build.checkpoint, flow::finer_checkpoint(build.checkpoint)})
    std::filesystem::remove(kept);
}

}  // namespace samara::benchmarks
