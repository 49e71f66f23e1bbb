#include "samara/motion/planning/motion_picture.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "samara/io/svg_chart.h"
#include "samara/motion/records/motion_record.h"

namespace samara::motion {

namespace {

/// So many rows as a picture shows, the last one among them.
std::vector<Eigen::Index> shown_rows(Eigen::Index count) {
  constexpr Eigen::Index kMost = 600;
  const Eigen::Index every = std::max<Eigen::Index>(1, count / kMost);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k + 1 < count; k += every) rows.push_back(k);
  rows.push_back(count - 1);
  return rows;
}

Eigen::MatrixX3d places_along(const MotionPlan& plan, const MotionResult& motion) {
  const MotionStates states(plan.model->info());
  Eigen::MatrixX3d places(motion.times.size(), 3);
  for (Eigen::Index k = 0; k < places.rows(); ++k) {
    const Eigen::VectorXd state = motion.states.row(k);
    places.row(k) = states.position({state.data(), static_cast<std::size_t>(state.size())});
  }
  return places;
}

io::SvgPanel side_view(const MotionPlan& plan, const Eigen::MatrixX3d& places, Eigen::Index axis,
                       const char* name) {
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
  const std::vector<Eigen::Index> rows = shown_rows(places.rows());
  panel.series.push_back({.name = "fall", .x = places(rows, axis), .y = places(rows, 2)});
  return panel;
}

io::SvgPanel coefficients_panel(const MotionPlan& plan, const MotionResult& motion) {
  io::SvgPanel panel{
      .title = "coefficients within their ranges", .x_label = "t", .y_label = "0 to 1", .series = {}};
  const Eigen::VectorXd times = motion.times(shown_rows(motion.times.size()));
  Eigen::MatrixXd values(times.size(), static_cast<Eigen::Index>(plan.box.size()));
  std::vector<double> row(plan.box.size());
  for (Eigen::Index k = 0; k < values.rows(); ++k) {
    motion.course->values(times[k], {}, row);
    values.row(k) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), values.cols());
  }
  for (std::size_t j = 0; j < plan.box.size(); ++j) {
    const SteeredCoefficient& range = plan.box[j];
    panel.series.push_back(
        {.name = fmt::format("{}, {:.3g} to {:.3g}", range.name, range.lower, range.upper),
         .x = times,
         .y = (values.col(static_cast<Eigen::Index>(j)).array() - range.lower) / (range.upper - range.lower),
         .colour = static_cast<int>(j)});
  }
  return panel;
}

}  // namespace

std::string motion_picture(const MotionPlan& plan, const MotionResult& motion, const GhostForce& ghost) {
  const Eigen::MatrixX3d places = places_along(plan, motion);
  const std::vector<Eigen::Index> rows = shown_rows(ghost.times.size());
  std::vector<io::SvgPanel> panels = {side_view(plan, places, 0, "x")};
  if (!MotionStates(plan.model->info()).is_planar()) panels.push_back(side_view(plan, places, 1, "y"));
  panels.push_back(coefficients_panel(plan, motion));
  panels.push_back(
      {.title = "invisible force, net weights",
       .x_label = "t",
       .y_label = "",
       .series = {{.name = "force", .x = ghost.times(rows), .y = ghost.declared.force(rows)},
                  {.name = "torque", .x = ghost.times(rows), .y = ghost.declared.torque(rows), .colour = 1}},
       .has_log_y = true});
  return io::svg_charts(fmt::format("{}: {}", plan.model->info().name, motion.message), panels,
                        static_cast<int>(panels.size()));
}

}  // namespace samara::motion
