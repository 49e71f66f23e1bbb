#include "samara/flow/momentum/momentum_step.h"

#include <algorithm>

#include "samara/flow/grid/line_solver.h"
#include "samara/flow/grid/rows.h"

namespace samara::flow {

namespace {

constexpr double kImplicitShare = 0.5;  // Crank and Nicolson

/// use(scheme, with eddies, normal) with what is known at run time made constants: f.operator()<scheme, eddy, normal>()
template <class Function>
auto with_constants(AdvectionScheme scheme, bool eddy, bool normal, const Function& f) {
  const auto with_scheme = [&]<AdvectionScheme kScheme>() {
    if (eddy && normal) return f.template operator()<kScheme, true, true>();
    if (eddy) return f.template operator()<kScheme, true, false>();
    // Without eddies the kind of face makes no difference.
    return f.template operator()<kScheme, false, false>();
  };
  if (scheme == AdvectionScheme::central) return with_scheme.template operator()<AdvectionScheme::central>();
  return with_scheme.template operator()<AdvectionScheme::van_leer>();
}

/// What stands beyond the end of a line of the increments of u_d: 0 at given faces and values, no flux elsewhere.
LineEnd increment_end(const Border& border, bool normal) {
  if (normal) return {.factor = 1.0};
  const bool given =
      border.kind == BorderKind::inflow || (border.kind == BorderKind::wall && !border.wall_law);
  return {.factor = given ? 2.0 : 0.0};
}

}  // namespace

FlowState::FlowState(const MacGrid& grid)
    : u(grid.faces()), u_before(grid.faces()), p(grid.field()), p_change(grid.field()) {}

MomentumStep::MomentumStep(const MacGrid& grid, const Borders& borders, const Openness& open,
                           AdvectionScheme scheme, double viscosity, const Eigen::Vector3d& body_force)
    : grid_(grid),
      borders_(borders),
      open_(open),
      scheme_(scheme),
      viscosity_(viscosity),
      body_force_(body_force),
      extrapolated_(grid.faces()),
      discharge_(grid.faces()),
      loss_(grid.faces()),
      ratio_(grid.field()),
      turn_(grid.field()) {
  set_walls();
  for (std::size_t d = 0; d < static_cast<std::size_t>(grid.dimensions); ++d) {
    for (int j = 0; j < grid.dimensions; ++j)
      record_.increment[d][static_cast<std::size_t>(j)] = grid.field();
  }
}

Range MomentumStep::unknown_faces(int d) const {
  Range range = all_cells(grid_);
  if (!borders_.periodic(d)) range.begin[static_cast<std::size_t>(d)] = 1;
  return range;
}

void MomentumStep::set_walls() {
  for (std::size_t d = 0; d < 3; ++d) {
    molecular_[d].clear();
    for (const WallPiece& piece : open_.wall_faces[d])
      molecular_[d].push_back(piece.area / grid_.spacing * viscosity_ / piece.distance);
    wall_velocity_[d].assign(molecular_[d].size(), 0.0);
  }
}

void MomentumStep::follow_body(const BodyPose& pose) {
  if (!sweeps_) sweeping_ = grid_.faces();
  sweeps_ = true;
  set_walls();
  for (int d = 0; d < grid_.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    std::fill(loss_[at].begin(), loss_[at].end(), 0.0);
    for (std::size_t i = 0; i < open_.wall_faces[at].size(); ++i) {
      const WallPiece& piece = open_.wall_faces[at][i];
      if (!piece.border) wall_velocity_[at][i] = pose.velocity_at(grid_.place(piece.at, d))(d);
    }
  }
}

/// What moving walls give, and the momentum of what the body sweeps.
void MomentumStep::set_sweeping() {
  const double per_spacing = 1.0 / grid_.spacing;
  for (int d = 0; d < grid_.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    Field& sweeping = sweeping_[at];
    std::fill(sweeping.begin(), sweeping.end(), 0.0);
    for (int k = open_.near.begin[2]; k < open_.near.end[2]; ++k) {
      for (int j = open_.near.begin[1]; j < open_.near.end[1]; ++j) {
        for (int i = open_.near.begin[0]; i < open_.near.end[0]; ++i) {
          const Index c = grid_.at(i, j, k);
          const auto f = static_cast<std::size_t>(c);
          if (open_.inverse_volume[at][f] > 0.0)
            sweeping[f] = -extrapolated_[at][f] * volume_taken(d, c) * per_spacing;
        }
      }
    }
    for (std::size_t i = 0; i < open_.wall_faces[at].size(); ++i)
      sweeping[static_cast<std::size_t>(open_.wall_faces[at][i].at)] +=
          (*conductance_)[at][i] * wall_velocity_[at][i];
  }
}

void MomentumStep::predict(FlowState& state, double step, const Field* eddy,
                           const WallConductance* conductance) {
  eddy_ = eddy;
  conductance_ = conductance != nullptr ? conductance : &molecular_;
  extrapolate(state, step);
  if (sweeps_) set_sweeping();
  for (int d = 0; d < grid_.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    for (std::size_t i = 0; i < open_.wall_faces[at].size(); ++i)
      loss_[at][static_cast<std::size_t>(open_.wall_faces[at][i].at)] = (*conductance_)[at][i];
    add_explicit(state, d, step);
    solve_implicit(d, step);
  }
  for (int d = 0; d < grid_.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    std::swap(state.u[at], state.u_before[at]);
    const Field& change = record_.increment[at][static_cast<std::size_t>(grid_.dimensions - 1)];
    std::copy(state.u_before[at].begin(), state.u_before[at].end(), state.u[at].begin());
    const Range unknown = unknown_faces(d);
    for_rows(grid_, unknown, [&](Index row, int) {
      double* const u = state.u[at].data() + row;
      const double* const add = change.data() + row;
      for (Index i = 0; i < unknown.width(); ++i) u[i] += add[i];
    });
  }
  carry_out(state, step);
}

/// To the middle of the step from the two known velocities; the first step has only one.
void MomentumStep::extrapolate(const FlowState& state, double step) {
  const double beyond = state.last_step > 0.0 ? 0.5 * step / state.last_step : 0.0;
  for (int d = 0; d < grid_.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const double* const now = state.u[at].data();
    const double* const before = state.u_before[at].data();
    const double* const open = open_.face[at].data();
    double* const middle = extrapolated_[at].data();
    double* const discharge = discharge_[at].data();
    constexpr Index kTogether = 16384;
    parallel_for((grid_.size + kTogether - 1) / kTogether, [&](Index block) {
      for (Index c = block * kTogether; c < std::min(grid_.size, (block + 1) * kTogether); ++c) {
        middle[c] = now[c] + beyond * (now[c] - before[c]);
        discharge[c] = open[c] * middle[c];
      }
    });
  }
}

FluxInput MomentumStep::flux_input(const Field& u, int d, int j) const {
  const auto own = static_cast<std::size_t>(d), across = static_cast<std::size_t>(j);
  return {u.data(),
          extrapolated_[own].data(),
          extrapolated_[across].data(),
          discharge_[across].data(),
          open_.conduction[own][across].data(),
          eddy_ != nullptr ? eddy_->data() : nullptr,
          grid_.stride[own],
          grid_.stride[across],
          viscosity_,
          1.0 / grid_.spacing};
}

/// The change by what is known at the start of the step, over the volume: the right-hand side of the factors.
void MomentumStep::add_explicit(const FlowState& state, int d, double step) {
  const auto at = static_cast<std::size_t>(d);
  const Index own = grid_.stride[at];
  const double per_spacing = 1.0 / grid_.spacing, force = body_force_(d);
  const Range unknown = unknown_faces(d);
  const Index width = unknown.width();
  double* const rate = record_.increment[at][0].data();
  const double* const inverse = open_.inverse_volume[at].data();
  const double* const open = open_.face[at].data();
  const double* const loss = loss_[at].data();
  const double* const u = state.u[at].data();
  const double* const p = state.p.data();
  const double* const sweeping = sweeps_ ? sweeping_[at].data() : nullptr;
  for_rows(grid_, unknown, [&](Index row, int) {
    for (Index c = row; c < row + width; ++c)
      rate[c] = -open[c] * (p[c] - p[c - own]) * per_spacing - loss[c] * u[c];
    if (sweeping != nullptr) {
      for (Index c = row; c < row + width; ++c) rate[c] += sweeping[c];
    }
    for (int j = 0; j < grid_.dimensions; ++j) {
      const FluxInput in = flux_input(state.u[at], d, j);
      with_constants(scheme_, eddy_ != nullptr, j == d,
                     [&]<AdvectionScheme kScheme, bool kEddy, bool kNormal>() {
                       by_eights(row, row + width, [&]<class V>(Index c) {
                         const V out = momentum_flux<V, kScheme, kEddy, kNormal>(in, c + in.across);
                         const V entering = momentum_flux<V, kScheme, kEddy, kNormal>(in, c);
                         store<V>(load<V>(rate + c) - (out - entering) * per_spacing, rate + c);
                       });
                     });
    }
    for (Index c = row; c < row + width; ++c)
      rate[c] = inverse[c] > 0.0 ? step * (inverse[c] * rate[c] + force) : 0.0;
  });
}

/// (1 - factor along x)(1 - factor along y).. increment = explicit change. Walls take their share in the first.
void MomentumStep::solve_implicit(int d, double step) {
  const auto at = static_cast<std::size_t>(d);
  const double* const inverse = open_.inverse_volume[at].data();
  const double* const loss = loss_[at].data();
  const double diffusion = kImplicitShare * step / (grid_.spacing * grid_.spacing);
  const Range unknown = unknown_faces(d);
  for (int j = 0; j < grid_.dimensions; ++j) {
    const auto along = static_cast<std::size_t>(j);
    Field& x = record_.increment[at][along];
    if (j > 0)
      std::copy(record_.increment[at][along - 1].begin(), record_.increment[at][along - 1].end(), x.begin());
    const LineEnds ends{borders_.periodic(j), increment_end(borders_.low(j), j == d),
                        increment_end(borders_.high(j), j == d)};
    const FluxInput in = flux_input(extrapolated_[at], d, j);  // its velocities are not looked at
    const auto volume = [=]<class V>(Index c) { return load<V>(inverse + c); };
    const auto solve = [&](const auto& coupling) {
      if (j == 0) {
        solve_all_lines(grid_, unknown, j, ends, x, ratio_, turn_, coupling, volume,
                        [=]<class V>(Index c) -> V { return step * load<V>(loss + c); });
      } else {
        solve_all_lines(grid_, unknown, j, ends, x, ratio_, turn_, coupling, volume,
                        []<class V>(Index) { return V{}; });
      }
    };
    if (eddy_ == nullptr) {
      solve([=]<class V>(Index c) -> V { return diffusion * in.viscosity * load<V>(in.conduction + c); });
    } else if (j == d) {
      solve([=]<class V>(Index c) -> V {
        return diffusion * (in.viscosity + eddy_viscosity<V, true>(in, c)) * load<V>(in.conduction + c);
      });
    } else {
      solve([=]<class V>(Index c) -> V {
        return diffusion * (in.viscosity + eddy_viscosity<V, false>(in, c)) * load<V>(in.conduction + c);
      });
    }
  }
}

/// Outflow faces: u_t + u u_x = -p_x towards the 0 of the border, half a cell away.
void MomentumStep::carry_out(FlowState& state, double step) const {
  for (int d = 0; d < grid_.dimensions; ++d) {
    if (borders_.high(d).kind != BorderKind::outflow) continue;
    const auto at = static_cast<std::size_t>(d);
    const Index s = grid_.stride[at];
    Range faces = all_cells(grid_);
    faces.begin[at] = grid_.cells[at];
    faces.end[at] = faces.begin[at] + 1;
    for (int k = faces.begin[2]; k < faces.end[2]; ++k) {
      for (int j = faces.begin[1]; j < faces.end[1]; ++j) {
        for (int i = faces.begin[0]; i < faces.end[0]; ++i) {
          const auto c = static_cast<std::size_t>(grid_.at(i, j, k));
          const double* const before = state.u_before[at].data() + c;
          const double speed = std::max(extrapolated_[at][c], 0.0);
          const double fall = -2.0 * state.p[c - static_cast<std::size_t>(s)];
          state.u[at][c] = before[0] - step / grid_.spacing * (speed * (before[0] - before[-s]) + fall);
        }
      }
    }
  }
}

double MomentumStep::flux_taken(const FlowState& state, int d, int j, Index c) const {
  const auto at = static_cast<std::size_t>(d);
  const FluxInput in = flux_input(state.u_before[at], d, j);
  const bool normal = j == d;
  const double flux = with_constants(scheme_, eddy_ != nullptr, normal,
                                     [&]<AdvectionScheme kScheme, bool kEddy, bool kNormal>() {
                                       return momentum_flux<double, kScheme, kEddy, kNormal>(in, c);
                                     });
  double viscosity = viscosity_;
  if (eddy_ != nullptr)
    viscosity += normal ? eddy_viscosity<double, true>(in, c) : eddy_viscosity<double, false>(in, c);
  const double* const increment = record_.increment[at][static_cast<std::size_t>(j)].data() + c;
  return flux - kImplicitShare * viscosity * in.conduction[c] * in.per_spacing *
                    (increment[0] - increment[-in.across]);
}

double MomentumStep::volume_taken(int d, Index c) const {
  const Index own = grid_.stride[static_cast<std::size_t>(d)];
  double taken = 0.0;
  for (int j = 0; j < grid_.dimensions; ++j) {
    const auto across = static_cast<std::size_t>(j);
    const double* const q = discharge_[across].data() + c;
    const Index s = grid_.stride[across];
    taken += 0.5 * (q[-own] + q[0]) - 0.5 * (q[s - own] + q[s]);
  }
  return taken;
}

double MomentumStep::wall_loss_taken(const FlowState& state, int d, std::size_t piece) const {
  const auto at = static_cast<std::size_t>(d);
  const auto face = static_cast<std::size_t>(open_.wall_faces[at][piece].at);
  return (*conductance_)[at][piece] *
         (state.u_before[at][face] + record_.increment[at][0][face] - wall_velocity_[at][piece]);
}

}  // namespace samara::flow
