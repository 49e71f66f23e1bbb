#include "samara/flow/march/flow_march.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/flow/grid/rows.h"

namespace samara::flow {

namespace {

FlowSetup checked(FlowSetup setup) {
  setup.borders.check(setup.grid.dimensions);
  for (int d = 0; d < setup.grid.dimensions; ++d) {
    if (setup.borders.periodic(d))
      require(setup.grid.cells[static_cast<std::size_t>(d)] >= 2, "cells",
              setup.grid.cells[static_cast<std::size_t>(d)], "at least 2 along a periodic direction",
              "FlowMarch");
  }
  require_positive(setup.viscosity, "viscosity", "FlowMarch");
  require_positive(setup.courant, "courant", "FlowMarch");
  require(setup.courant <= 0.5, "courant", setup.courant, "at most 0.5", "FlowMarch");
  require_positive(setup.divergence, "divergence", "FlowMarch");
  require_positive(setup.largest_eddy_viscosity, "largest_eddy_viscosity", "FlowMarch");
  if (!setup.body_force.allFinite()) throw ArgumentError("FlowMarch: body_force is not finite");
  if (!setup.body) {
    if (setup.path) throw ArgumentError("FlowMarch: there is a path, and no body that follows it");
    return setup;
  }
  PlacedShape& body = *setup.body;
  if (body.shape().dimensions != setup.grid.dimensions)
    throw ArgumentError(fmt::format("the body is one of {} dimensions, in a flow of {}",
                                    body.shape().dimensions, setup.grid.dimensions));
  const double thickness = body.shape().thickness;
  if (!body.shape().baffle && thickness < 2.0 * setup.grid.spacing * (1.0 - kThicknessError))
    throw ArgumentError(fmt::format(
        "the body is {:.4g} thin, less than two cells of {:.4g}: expected cells of at most {:.4g}", thickness,
        setup.grid.spacing, 0.5 * thickness));
  if (setup.path) {
    if (body.shape().baffle)
      throw ArgumentError("a baffle cannot move, for it fills no cells: expected a body with a thickness");
    const BodyPose start = setup.path(0.0);
    if (!start.is_finite()) throw ArgumentError("the path of the body is not finite at t = 0");
    body.move_to(start.place, start.angle);
  }
  require_within(setup.grid, body, "");
  return setup;
}

}  // namespace

void require_within(const MacGrid& grid, const PlacedShape& body, const std::string& when) {
  const Eigen::Vector3d half = body.half_extent();
  for (int d = 0; d < grid.dimensions; ++d) {
    const double low = body.place()(d) - half(d) - grid.origin(d);
    const double high = grid.origin(d) + grid.length(d) - body.place()(d) - half(d);
    // The control volumes beside the body reach that far.
    const double least = 4.0 * grid.spacing;
    if (!(std::min(low, high) >= least))
      throw ArgumentError(
          fmt::format("the body comes within {:.4g} of a border{}, expected at least {:.4g}, four cells",
                      std::min(low, high), when, least));
  }
}

FlowMarch::FlowMarch(FlowSetup setup)
    : setup_(checked(std::move(setup))),
      open_(measure_openness(setup_.grid, setup_.borders, setup_.body)),
      momentum_(setup_.grid, setup_.borders, open_, setup_.scheme, setup_.viscosity, setup_.body_force),
      projection_(setup_.grid, setup_.borders, open_, setup_.pressure),
      state_(setup_.grid),
      sums_(setup_.grid) {
  if (setup_.turbulence != TurbulenceModel::none)
    turbulence_ = std::make_unique<KEpsilon>(setup_.grid, setup_.borders, open_, setup_.viscosity,
                                             setup_.turbulence, setup_.largest_eddy_viscosity);
  if (setup_.body) pose_.place = setup_.body->place();
  if (moves()) {
    volumes_before_.emplace(setup_.grid);
    find_body();
  }
}

void FlowMarch::find_body() {
  if (!moves()) return;
  pose_ = setup_.path(state_.time);
  move_body(state_.time);
}

/// The openness of the body at a time, and all that is measured by it.
void FlowMarch::move_body(double time) {
  const BodyPose before = pose_;
  pose_ = setup_.path(time);
  const auto when = [&] { return fmt::format(" at t = {:.6g}", time); };
  if (!pose_.is_finite()) throw ArgumentError(fmt::format("the path of the body is not finite{}", when()));
  const double reach = setup_.body->half_extent().norm();
  const double way = (pose_.place - before.place).norm() + reach * std::abs(pose_.angle - before.angle);
  if (way > setup_.grid.spacing)
    throw ArgumentError(fmt::format(
        "the body leaps by {:.4g}{}, more than a cell, {:.4g}, in a step that its rate made short "
        "enough: expected a path without leaps",
        way, when(), setup_.grid.spacing));
  setup_.body->move_to(pose_.place, pose_.angle);
  require_within(setup_.grid, *setup_.body, when());
  were_closed_.swap(open_.closed_cells);
  volumes_before_->keep(setup_.grid, open_);
  measure_openness(setup_.grid, setup_.borders, *setup_.body, open_);
  projection_.follow_body(pose_);
  momentum_.follow_body(pose_);
  if (turbulence_) turbulence_->follow_body(pose_);
}

/// Cells that the body has left take the mean of their neighbours.
void FlowMarch::fill_fresh_cells(Field& field) const {
  const MacGrid& grid = setup_.grid;
  const auto was_closed = [&](Index c) {
    return std::binary_search(were_closed_.begin(), were_closed_.end(), c);
  };
  for (const Index c : were_closed_) {
    if (open_.inverse_cell[static_cast<std::size_t>(c)] == 0.0) continue;
    double sum = 0.0, weight = 0.0;
    for (int d = 0; d < grid.dimensions; ++d) {
      const Index s = grid.stride[static_cast<std::size_t>(d)];
      for (const Index neighbour : {c - s, c + s}) {
        if (was_closed(neighbour)) continue;
        const double share = open_.cell[static_cast<std::size_t>(neighbour)];
        sum += share * field[static_cast<std::size_t>(neighbour)];
        weight += share;
      }
    }
    if (weight > 0.0) field[static_cast<std::size_t>(c)] = sum / weight;
  }
}

/// Faces within the body have its velocity.
void FlowMarch::set_closed_faces() {
  for (int d = 0; d < setup_.grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    for (const Index c : open_.closed_faces[at])
      state_.u[at][static_cast<std::size_t>(c)] = pose_.velocity_at(setup_.grid.place(c, d))(d);
  }
}

void FlowMarch::set_velocity(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& velocity) {
  const MacGrid& grid = setup_.grid;
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    std::array<int, 3> end = grid.cells;
    end[at] += 1;
    for (int k = 0; k < end[2]; ++k) {
      for (int j = 0; j < end[1]; ++j) {
        for (int i = 0; i < end[0]; ++i) {
          const Eigen::Vector3d x = grid.face_centre(d, i, j, k);
          const double value = velocity(x)(d);
          if (!std::isfinite(value))
            throw ArgumentError(
                fmt::format("set_velocity: the velocity is {} at ({}, {}, {}), expected a number", value,
                            x.x(), x.y(), x.z()));
          state_.u[at][static_cast<std::size_t>(grid.at(i, j, k))] = value;
        }
      }
    }
  }
  set_closed_faces();
  set_border_faces(grid, setup_.borders, state_.u);
  fill_margins(grid, setup_.borders, state_.u);
  // The potential that makes it free of divergence is no pressure.
  projection_.project(state_, 1.0, setup_.divergence);
  std::fill(state_.p.begin(), state_.p.end(), 0.0);
  std::fill(state_.p_change.begin(), state_.p_change.end(), 0.0);
  state_.u_before = state_.u;
  state_.last_step = 0.0;
}

void FlowMarch::set_turbulence(double k, double epsilon) {
  require_positive(k, "k", "set_turbulence");
  require_positive(epsilon, "epsilon", "set_turbulence");
  if (turbulence_) turbulence_->set(k, epsilon);
}

double FlowMarch::allowed_step() {
  const MacGrid& grid = setup_.grid;
  const double rate = grid.spacing * fastest_exchange(grid, open_, state_.u, sums_);
  const double way = setup_.courant * grid.spacing;
  if (!moves()) return way / std::max(rate, 1e-12);
  // Where nothing moves yet, as long as what has the speed of the case would allow.
  const double reach = setup_.body->half_extent().norm();
  const auto speed_at = [&](double t) {
    const BodyPose pose = setup_.path(t);
    return pose.velocity.norm() + reach * std::abs(pose.angular_rate);
  };
  double fastest = std::max({rate, 1.0, speed_at(state_.time)});
  for (const double part : {0.5, 1.0})
    fastest = std::max(fastest, speed_at(state_.time + part * way / fastest));
  return way / fastest;
}

StepReport FlowMarch::advance(double step) {
  StepReport report;
  report.step = step;
  if (moves()) {
    move_body(state_.time + step);
    fill_fresh_cells(state_.p);
    fill_fresh_cells(state_.p_change);
    if (turbulence_) {
      fill_fresh_cells(turbulence_->k);
      fill_fresh_cells(turbulence_->epsilon);
    }
  }
  if (turbulence_) turbulence_->prepare(state_.u);
  momentum_.predict(state_, step, turbulence_ ? &turbulence_->eddy_viscosity() : nullptr,
                    turbulence_ ? &turbulence_->conductance() : nullptr);
  if (moves()) set_closed_faces();
  report.pressure = projection_.project(state_, step, setup_.divergence);
  if (moves())
    reshaping_ = reshaping_forces(setup_.grid, open_, *volumes_before_, momentum_, state_, pose_, step);
  if (turbulence_) turbulence_->advance(state_.u, step);
  state_.time += step;
  state_.last_step = step;
  ++state_.steps;
  report.finite =
      std::isfinite(report.pressure.residual) && (!turbulence_ || turbulence_->not_positive() == 0);
  return report;
}

BodyLoads FlowMarch::loads() const {
  BodyLoads loads = surface_loads(setup_.grid, open_, momentum_, state_, pose_, moves(), reshaping_);
  if (moves()) loads.moment += turning_moment(pose_, setup_.viscosity, setup_.body->shape().volume);
  return loads;
}

Eigen::Vector3d FlowMarch::force_by_box(int margin_cells) const {
  if (!setup_.body) return Eigen::Vector3d::Zero();
  return box_force(setup_.grid, open_, momentum_, state_, pose_, moves(), reshaping_,
                   control_box(setup_.grid, *setup_.body, margin_cells), state_.last_step);
}

}  // namespace samara::flow
