// Turbulent flows: the developed channel, whose profiles follow from equations in one dimension, and bluff bodies.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "cases.h"
#include "samara/flow/march/solve_flow.h"
#include "tests/flow/flow_cases.h"

namespace samara::benchmarks {

namespace {

using namespace flow_cases;

void run_channel(const std::string& name, double reynolds, double centre_speed, double centre_k) {
  const Channel found = channel(reynolds, 64);
  print({kFlow, name, "U_c_error", std::abs(found.centre_speed / centre_speed - 1.0), "1", "ode_1d"});
  print({kFlow, name, "k_c_error", std::abs(found.centre_k / centre_k - 1.0), "1", "ode_1d"});
}

FlowResult run_body(const std::string& name, FlowCase flow, int cells) {
  flow.cells_per_length = cells;
  FlowOptions options;
  options.checkpoint = fmt::format("flow_{}_{}.checkpoint", name, cells);
  options.resume = true;
  options.max_time = 300.0;
  const FlowResult result = solve_flow(flow, options);
  print({kFlow, name, fmt::format("C_D_{}", cells), result.drag.value, "1"});
  return result;
}

/// Three grids, the finest in full.
void run_grids(const std::string& name, const FlowCase& flow) {
  const FlowResult coarse = run_body(name, flow, 8), middle = run_body(name, flow, 16),
                   fine = run_body(name, flow, 32);
  // First order, as corners have it.
  print({kFlow, name, "C_D_extrapolated", 2.0 * fine.drag.value - middle.drag.value, "1"});
  print({kFlow, name, "C_D", fine.drag.value, "1", "rodi_1997"});
  print({kFlow, name, "St", fine.strouhal, "1", "rodi_1997"});
  print({kFlow, name, "bubble_end", fine.bubble_end, "l"});
  const auto guarded = [](const FlowResult& result) {
    return static_cast<double>(result.checks.guarded_cells);
  };
  print({kFlow, name, "clipped_cells", guarded(coarse) + guarded(middle) + guarded(fine), "cells"});
}

}  // namespace

void run_channels(const Options& options) {
  if (options.wants("channel_590")) run_channel("channel_590", 590.0, 21.0747, 0.9057);
  if (options.wants("channel_2000")) run_channel("channel_2000", 2000.0, 24.310, 0.9177);
}

void run_bluff_bodies(const Options& options) {
  FlowCase flow;
  if (options.only_case == "square_22000") {
    flow.shape = rectangle_section(1.0, 1.0);
    flow.reynolds = 22000;
    run_grids("square_22000", flow);
  }
  if (options.only_case == "plate_90") {
    // Two cells across the plate take an eighth of its width at 16 cells, a quarter at 8.
    flow.shape = rectangle_section(1.0, 0.25);
    flow.angle_of_attack = 0.5 * kPi;
    flow.reynolds = 2e4;
    run_grids("plate_90", flow);
  }
}

}  // namespace samara::benchmarks
