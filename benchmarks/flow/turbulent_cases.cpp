// Turbulent flows: the developed channel, whose profiles follow from equations in one dimension, and bluff bodies.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cases.h"
#include "samara/base/errors.h"
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

std::filesystem::path checkpoint_of(const std::string& name, int cells) {
  return fmt::format("flow_{}_{}.checkpoint", name, cells);
}

/// The flow on a grid, from the checkpoint that an interrupted measurement has left; one of another solver is
/// refused. The checkpoint stays until all grids are done, so that finished ones take less than a minute again.
FlowResult run_body(const std::string& name, FlowCase flow, int cells, const char* baseline) {
  flow.cells_per_length = cells;
  FlowOptions options;
  options.checkpoint = checkpoint_of(name, cells);
  options.resume = true;
  options.max_time = 600.0;  // finer grids begin to shed later
  const FlowResult result = solve_flow(flow, options);
  if (result.status != FlowStatus::steady && result.status != FlowStatus::averaged)
    throw NoResultError(fmt::format("{} at {} cells: {}", name, cells, result.message));
  print({kFlow, name, fmt::format("C_D_{}", cells), result.drag.value, "1", baseline});
  print({kFlow, name, fmt::format("St_{}", cells), result.strouhal, "1", baseline});
  print({kFlow, name, fmt::format("C_L_rms_{}", cells), result.lift_rms, "1", baseline});
  print({kFlow, name, fmt::format("bubble_end_{}", cells), result.bubble_end, "l", baseline});
  return result;
}

std::vector<FlowResult> run_grids(const std::string& name, const FlowCase& flow,
                                  const std::vector<int>& grids, const char* baseline) {
  std::vector<FlowResult> results;
  for (const int cells : grids) results.push_back(run_body(name, flow, cells, baseline));
  for (const int cells : grids) std::filesystem::remove(checkpoint_of(name, cells));
  return results;
}

double clipped(const std::vector<FlowResult>& results) {
  double cells = 0.0;
  for (const FlowResult& result : results) cells += static_cast<double>(result.checks.clipped_cells);
  return cells;
}

void run_square() {
  const std::string name = "square_22000";
  FlowCase flow;
  flow.shape = rectangle_section(1.0, 1.0);
  flow.reynolds = 22000;
  const std::vector<FlowResult> grids = run_grids(name, flow, {8, 16, 32}, "rodi_1997");
  const FlowResult& fine = grids.back();
  print({kFlow, name, "C_D", fine.drag.value, "1", "rodi_1997"});
  print({kFlow, name, "St", fine.strouhal, "1", "rodi_1997"});
  print({kFlow, name, "bubble_end", fine.bubble_end, "l", "rodi_1997"});
  print({kFlow, name, "clipped_cells", clipped(grids), "cells", "self"});
}

/// A plate of an eighth of its width, broadside on. Two cells across it take 16 to its width: at 8 it would be
/// another body.
void run_plate() {
  const std::string name = "plate_90";
  FlowCase flow;
  flow.shape = rectangle_section(1.0, 0.125);
  flow.angle_of_attack = 0.5 * kPi;
  flow.reynolds = 2e4;
  const std::vector<FlowResult> grids = run_grids(name, flow, {16, 24, 32}, "self");
  // First order, as measured for bodies with corners, through the two that are a factor of two apart.
  const double coarse = grids.front().drag.value, fine = grids.back().drag.value;
  print({kFlow, name, "C_D_extrapolated", fine + (fine - coarse), "1", "self"});
  print({kFlow, name, "clipped_cells", clipped(grids), "cells", "self"});
}

}  // namespace

void run_channels(const Options& options) {
  if (options.wants("channel_590")) run_channel("channel_590", 590.0, 21.0747, 0.9057);
  if (options.wants("channel_2000")) run_channel("channel_2000", 2000.0, 24.310, 0.9177);
}

void run_bluff_bodies(const Options& options) {
  if (options.only_case == "square_22000") run_square();
  if (options.only_case == "plate_90") run_plate();
}

}  // namespace samara::benchmarks
