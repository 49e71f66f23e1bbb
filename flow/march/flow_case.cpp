#include "samara/flow/march/flow_case.h"

#include <array>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/flow/march/flow_march.h"

namespace samara::flow {

namespace {

constexpr double kMostBlockage = 0.25;

void check_motion(const FlowCase& flow) {
  const BodyMotion& motion = *flow.motion;
  require(std::isfinite(motion.period) && motion.period >= 0.0, "period", motion.period, "not negative",
          "flow");
  if (flow.shape.baffle)
    throw ArgumentError(
        "flow: a baffle cannot move, for it fills no cells; expected a plate with a thickness");
  const BodyPose start = motion.path(0.0);
  if (!start.is_finite()) throw ArgumentError("flow: the path of the body is not finite at t = 0");
  if (flow.shape.dimensions == 2 && start.place.z() != 0.0)
    throw ArgumentError("flow: the body moves along z in a flow of the plane");
}

std::array<int, 3> cells_of(const FlowCase& flow) {
  const auto cells = [&](double length) {
    return static_cast<int>(std::lround(length * flow.cells_per_length));
  };
  const int across = 2 * cells(flow.extent.side);
  return {cells(flow.extent.before) + cells(flow.extent.behind), across,
          flow.shape.dimensions == 3 ? across : 1};
}

}  // namespace

double blockage(const FlowCase& flow) {
  const PlacedShape body(flow.shape, Eigen::Vector3d::Zero(), flow.angle_of_attack);
  return body.frontal_size() / std::pow(2.0 * flow.extent.side, flow.shape.dimensions - 1);
}

double memory_of(const FlowCase& flow) {
  const std::array<int, 3> cells = cells_of(flow);
  // Fields of doubles: two velocities with their factors, discharges and openness, averages, the levels of the
  // pressure, and a checkpoint in the making.
  const double fields = flow.shape.dimensions == 3 ? 124.0 : 85.0;
  double bytes = 8.0 * fields;
  for (int d = 0; d < flow.shape.dimensions; ++d)
    bytes *= cells[static_cast<std::size_t>(d)] + 2.0 * MacGrid::kMargin;
  return bytes;
}

void check_case(const FlowCase& flow, double max_memory) {
  require_positive(flow.reynolds, "reynolds", "flow");
  require(flow.intensity > 0.0 && flow.intensity <= 1.0, "intensity", flow.intensity,
          "more than 0, at most 1", "flow");
  require(std::isfinite(flow.angle_of_attack), "angle_of_attack", flow.angle_of_attack, "a number", "flow");
  // With the largest extent the cells of a direction still fit into an integer.
  require(flow.cells_per_length >= 4 && flow.cells_per_length <= 100'000, "cells_per_length",
          flow.cells_per_length, "from 4 to 100,000", "flow");
  for (const double length : {flow.extent.before, flow.extent.behind, flow.extent.side})
    require(length > kLeastExtent && length <= kMostExtent, "extent", length,
            "more than 0.5 and at most 1000 body lengths", "flow");
  require_positive(max_memory, "max_memory", "flow");
  require(flow.stream >= 0.0 && flow.stream <= kMostStream, "stream", flow.stream,
          "its speed in U, from 0 to 1000", "flow");
  if (!flow.motion && flow.stream != 1.0)
    throw ArgumentError(
        fmt::format("flow: the stream of a held body is {} U, expected 1: it is what U means", flow.stream));
  if (flow.motion) check_motion(flow);
  const double share = blockage(flow);
  if (share > kMostBlockage)
    throw ArgumentError(
        fmt::format("flow: the body takes {:.0f} % of the stream's width, expected at most {:.0f} %: a side "
                    "of at least {:.3g} body lengths",
                    100.0 * share, 100.0 * kMostBlockage,
                    flow.extent.side * std::pow(share / kMostBlockage, 1.0 / (flow.shape.dimensions - 1))));
  if (const double bytes = memory_of(flow); bytes > max_memory)
    throw ArgumentError(fmt::format("flow: the case takes {:.2g} GB, expected at most max_memory, {:.2g} GB",
                                    1e-9 * bytes, 1e-9 * max_memory));
  const double thickness = flow.shape.thickness, spacing = 1.0 / flow.cells_per_length;
  if (!flow.shape.baffle && thickness < 2.0 * spacing * (1.0 - kThicknessError))
    throw ArgumentError(fmt::format(
        "flow: the body is {:.4g} thin at {} cells per length, expected two cells across it, or a baffle: "
        "cells_per_length at least {:.0f}",
        thickness, flow.cells_per_length, std::ceil((1.0 - kThicknessError) * 2.0 / thickness)));
  if (!flow.motion)
    require_within(grid_of(flow), PlacedShape(flow.shape, Eigen::Vector3d::Zero(), flow.angle_of_attack), "");
}

MacGrid grid_of(const FlowCase& flow) {
  const double n = flow.cells_per_length;
  const double before = std::round(flow.extent.before * n) / n, side = std::round(flow.extent.side * n) / n;
  return MacGrid(flow.shape.dimensions, cells_of(flow), 1.0 / n, {-before, -side, -side});
}

}  // namespace samara::flow
