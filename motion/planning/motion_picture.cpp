#include "samara/motion/planning/motion_picture.h"

#include <vector>

#include <fmt/format.h>

#include "samara/io/svg_chart.h"
#include "samara/motion/planning/motion_view.h"
#include "samara/motion/records/motion_record.h"

namespace samara::motion {

namespace {

io::SvgPanel side_view(const MotionPlan& plan, const MotionView& view, Eigen::Index axis, const char* name) {
  io::SvgPanel panel{
      .title = "path", .x_label = name, .y_label = "height", .series = {}, .has_equal_scales = true};
  if (plan.sketch) {
    panel.series.push_back({.name = "sketch",
                            .x = plan.sketch->points().col(axis),
                            .y = plan.sketch->points().col(2),
                            .kind = io::SvgSeries::Kind::dashes,
                            .colour = 1});
  }
  if (plan.landing) {
    panel.series.push_back({.name = "landing place",
                            .x = Eigen::VectorXd::Constant(1, (*plan.landing)[axis]),
                            .y = Eigen::VectorXd::Constant(1, plan.ground),
                            .kind = io::SvgSeries::Kind::points,
                            .colour = 2});
  }
  panel.series.push_back({.name = "fall", .x = view.places.col(axis), .y = view.places.col(2)});
  return panel;
}

io::SvgPanel coefficients_panel(const MotionPlan& plan, const MotionView& view) {
  io::SvgPanel panel{
      .title = "coefficients within their ranges", .x_label = "t", .y_label = "0 to 1", .series = {}};
  for (std::size_t j = 0; j < plan.box.size(); ++j) {
    const SteeredCoefficient& range = plan.box[j];
    panel.series.push_back({.name = fmt::format("{}, {:.3g} to {:.3g}", range.name, range.lower, range.upper),
                            .x = view.times,
                            .y = (view.coefficients.col(static_cast<Eigen::Index>(j)).array() - range.lower) /
                                 (range.upper - range.lower),
                            .colour = static_cast<int>(j)});
  }
  return panel;
}

}  // namespace

std::string motion_picture(const MotionPlan& plan, const MotionResult& motion, const GhostForce& ghost) {
  const MotionView view = view_of(plan, motion, ghost);
  std::vector<io::SvgPanel> panels = {side_view(plan, view, 0, "x")};
  if (!MotionStates(plan.model->info()).is_planar()) panels.push_back(side_view(plan, view, 1, "y"));
  panels.push_back(coefficients_panel(plan, view));
  panels.push_back(
      {.title = "invisible force, net weights",
       .x_label = "t",
       .y_label = "",
       .series = {{.name = "force", .x = view.ghost_times, .y = view.ghost_force},
                  {.name = "torque", .x = view.ghost_times, .y = view.ghost_torque, .colour = 1}},
       .has_log_y = true});
  return io::svg_charts(fmt::format("{}: {}", plan.model->info().name, motion.message), panels,
                        static_cast<int>(panels.size()));
}

}  // namespace samara::motion
