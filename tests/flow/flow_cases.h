#pragma once

#include <cmath>

#include <Eigen/LU>

#include "samara/flow/march/flow_march.h"

/// Flows that several tests march.
namespace flow_cases {

using namespace samara::flow;

inline constexpr double kPi = 3.14159265358979323846;

inline Borders all_periodic() {
  Borders borders;
  for (Border& border : borders.side) border.kind = BorderKind::periodic;
  return borders;
}

/// A stream along x with free sides.
inline Borders stream(double speed = 1.0) {
  Borders borders;
  borders.side[0].kind = BorderKind::inflow;
  borders.side[0].velocity = {speed, 0.0, 0.0};
  borders.side[1].kind = BorderKind::outflow;
  return borders;
}

/// Taylor and Green's vortices of wave number 2 pi in a unit square, carried by a stream along the diagonal.
struct TaylorGreen {
  double viscosity = 0.01, stream = 0.0;

  double fading(double t) const { return std::exp(-8.0 * kPi * kPi * viscosity * t); }
  Eigen::Vector3d velocity(const Eigen::Vector3d& x, double t) const {
    const double a = 2.0 * kPi * (x.x() - stream * t), b = 2.0 * kPi * (x.y() - stream * t), f = fading(t);
    return {stream + f * std::sin(a) * std::cos(b), stream - f * std::cos(a) * std::sin(b), 0.0};
  }
  double pressure(const Eigen::Vector3d& x, double t) const {
    const double a = 4.0 * kPi * (x.x() - stream * t), b = 4.0 * kPi * (x.y() - stream * t), f = fading(t);
    return 0.25 * f * f * (std::cos(a) + std::cos(b));
  }
};

struct TaylorGreenErrors {
  double u = 0.0, p = 0.0, divergence = 0.0;
};

/// Largest errors at time 0.5 on n^2 cells; steps are proportional to the cells.
inline TaylorGreenErrors taylor_green_errors(int n, double stream) {
  const TaylorGreen exact{0.01, stream};
  FlowMarch march({.grid = MacGrid(2, {n, n, 1}, 1.0 / n, Eigen::Vector3d::Zero()),
                   .borders = all_periodic(),
                   .viscosity = exact.viscosity,
                   .scheme = AdvectionScheme::central,
                   .divergence = 1e-11});
  march.set_velocity([&](const Eigen::Vector3d& x) { return exact.velocity(x, 0.0); });
  const int steps = 4 * n / 2;
  const double step = 0.5 / steps;
  TaylorGreenErrors errors;
  for (int s = 0; s < steps; ++s) {
    march.advance(step);
    errors.divergence = std::max(errors.divergence, march.divergence());
  }
  const MacGrid& grid = march.grid();
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const auto c = static_cast<std::size_t>(grid.at(i, j));
      for (int d = 0; d < 2; ++d) {
        const double u = march.state().u[static_cast<std::size_t>(d)][c];
        errors.u = std::max(errors.u, std::abs(u - exact.velocity(grid.face_centre(d, i, j), 0.5)(d)));
      }
      const double p = exact.pressure(grid.centre(i, j), 0.5 - 0.5 * step);
      errors.p = std::max(errors.p, std::abs(march.state().p[c] - p));
    }
  }
  return errors;
}

/// Extrema on the middle lines of a cavity whose lid moves along x: least u, largest and least v.
struct CavityExtrema {
  double u_min, v_max, v_min;
};

inline CavityExtrema cavity_extrema(int n, double reynolds, double steady) {
  Borders borders;
  for (Border& border : borders.side) border.kind = BorderKind::wall;
  borders.side[3].velocity = {1.0, 0.0, 0.0};
  FlowMarch march({.grid = MacGrid(2, {n, n, 1}, 1.0 / n, Eigen::Vector3d::Zero()),
                   .borders = borders,
                   .viscosity = 1.0 / reynolds,
                   .scheme = AdvectionScheme::central,
                   .divergence = 1e-7});
  march.set_velocity([](const Eigen::Vector3d&) { return Eigen::Vector3d(0.0, 0.0, 0.0); });
  const MacGrid& grid = march.grid();
  const double step = 0.45 / n;
  double change = 1.0;
  while (change > steady && march.state().time < 200.0) {
    march.advance(step);
    if (march.state().steps % 20 != 0) continue;
    change = 0.0;
    for (int d = 0; d < 2; ++d) {
      const auto at = static_cast<std::size_t>(d);
      for (std::size_t c = 0; c < march.state().u[at].size(); ++c)
        change = std::max(change, std::abs(march.state().u[at][c] - march.state().u_before[at][c]) / step);
    }
  }
  // Parabolas through the three values about an extremum on the middle line.
  const auto extremum = [&](int d, double sign) {
    const auto at = static_cast<std::size_t>(d);
    const auto value = [&](int i) {
      return sign *
             march.state().u[at][static_cast<std::size_t>(d == 0 ? grid.at(n / 2, i) : grid.at(i, n / 2))];
    };
    int best = 1;
    for (int i = 1; i + 1 < n; ++i) {
      if (value(i) > value(best)) best = i;
    }
    const double below = value(best - 1), middle = value(best), above = value(best + 1);
    const double curvature = below - 2.0 * middle + above, slope = 0.5 * (above - below);
    return sign * (middle - 0.5 * slope * slope / curvature);
  };
  return {extremum(0, -1.0), extremum(1, 1.0), extremum(1, -1.0)};
}

/// k and U in the channel between y+ = 50 and its centre, in wall units, distances in half widths.
struct Channel {
  double centre_speed, centre_k, k_at_03;
};

inline Channel channel(double reynolds, int n) {
  const double kappa = 0.41, wall = 50.0 / reynolds;
  const double speed = std::log(9.8 * 50.0) / kappa;
  Borders borders = all_periodic();
  borders.side[2] = {.kind = BorderKind::wall, .k = 1.0 / 0.3, .epsilon = 1.0 / (kappa * wall)};
  borders.side[3] = {.kind = BorderKind::slip};
  const double h = (1.0 - wall) / n;
  FlowMarch march({.grid = MacGrid(2, {4, n, 1}, h, {0.0, wall, 0.0}),
                   .borders = borders,
                   .viscosity = 1.0 / reynolds,
                   .body_force = {1.0, 0.0, 0.0},
                   .turbulence = TurbulenceModel::k_epsilon,
                   .largest_eddy_viscosity = 10.0});
  march.set_velocity(
      [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(std::log(x.y() / wall) / kappa, 0.0, 0.0); });
  march.set_turbulence(2.0, 5.0);
  // The fastest, at the centre, crosses 0.3 of a cell.
  const double step = 0.3 * h * kappa / std::log(1.0 / wall);
  while (march.state().time < 20.0) march.advance(step);
  const auto row = [&](double y) { return static_cast<int>((y - wall) / h); };
  const auto at = [&](int j) { return static_cast<std::size_t>(march.grid().at(1, j)); };
  const Field& k = march.turbulence()->k;
  const int j = row(0.3);
  const double along = (0.3 - march.grid().centre(0, j).y()) / h;
  const int other = along > 0 ? j + 1 : j - 1;
  return {speed + march.state().u[0][at(n - 1)], k[at(n - 1)],
          k[at(j)] + std::abs(along) * (k[at(other)] - k[at(j)])};
}

/// The channel with a cylinder of the DFG benchmark (M. Schaefer, S. Turek 1996) in diameters and mean speeds, with n
/// cells to a diameter: 22 long, 4.1 high, the cylinder's centre 2 from the inflow and 2 above the floor.
inline FlowSetup dfg_channel(int n, double reynolds) {
  const auto speed = [](const Eigen::Vector3d& x) { return 6.0 * x.y() * (4.1 - x.y()) / (4.1 * 4.1); };
  Borders borders = stream();
  borders.side[0].profile = speed;
  borders.side[2].kind = borders.side[3].kind = BorderKind::wall;
  return {.grid = MacGrid(2, {22 * n, static_cast<int>(std::lround(4.1 * n)), 1}, 1.0 / n,
                          Eigen::Vector3d::Zero()),
          .borders = borders,
          .body = PlacedShape(ellipse_section(0.5, 0.5), {2.0, 2.0, 0.0}, 0.0),
          .viscosity = 1.0 / reynolds,
          .scheme = AdvectionScheme::central};
}

inline void start_channel(FlowMarch& march) {
  march.set_velocity([&](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(march.setup().borders.side[0].profile(x), 0.0, 0.0);
  });
}

/// From a place on, at a constant velocity.
inline BodyPath steady_path(const Eigen::Vector3d& from, const Eigen::Vector3d& velocity) {
  return [=](double t) {
    BodyPose pose;
    pose.place = from + t * velocity;
    pose.velocity = velocity;
    return pose;
  };
}

/// Mean drag of a circle at Re 40 from time 1 to 2 after it was set off, in a stream or through fluid at rest.
inline double early_drag(int n, bool moved) {
  FlowSetup setup{.grid = MacGrid(2, {10 * n, 8 * n, 1}, 1.0 / n, {-5.0, -4.0, 0.0}),
                  .borders = stream(moved ? 0.0 : 1.0),
                  .body = PlacedShape(ellipse_section(0.5, 0.5), {0.0, 0.03, 0.0}, 0.0),
                  .viscosity = 1.0 / 40,
                  .scheme = AdvectionScheme::central};
  if (moved) setup.path = steady_path({1.0, 0.03, 0.0}, {-1.0, 0.0, 0.0});
  FlowMarch march(setup);
  march.set_velocity([&](const Eigen::Vector3d&) { return Eigen::Vector3d(moved ? 0.0 : 1.0, 0.0, 0.0); });
  double impulse = 0.0, time = 0.0;
  while (march.state().time < 2.0) {
    const double step = march.advance().step;
    if (march.state().time < 1.0) continue;
    impulse += step * 2.0 * march.loads().force.x();
    time += step;
  }
  return impulse / time;
}

/// F = -1/2 C_D |v| v - pi/4 C_A dv/dt of a circle of diameter 1 (J. Morison et al., J. Petroleum Tech. 2 (1950) 149).
struct MorisonFit {
  double drag = 0.0, added_mass = 0.0;
};

/// By least squares over the last of some periods of a circle that moves as x = -KC/(2 pi) sin(2 pi t/KC), KC = 5, in
/// fluid at rest at Re 100, with n cells to its diameter and borders `side` diameters from the middle.
inline MorisonFit oscillating_circle(int n, double side, int periods) {
  const double period = 5.0, turn = 2.0 * kPi / period;
  const auto path = [turn](double t) {
    BodyPose pose;
    pose.place.x() = -std::sin(turn * t) / turn;
    pose.velocity.x() = -std::cos(turn * t);
    pose.acceleration.x() = turn * std::sin(turn * t);
    return pose;
  };
  const int cells = 2 * static_cast<int>(std::lround(side * n));
  FlowMarch march({.grid = MacGrid(2, {cells, cells, 1}, 1.0 / n, {-side, -side, 0.0}),
                   .borders = stream(0.0),
                   .body = PlacedShape(ellipse_section(0.5, 0.5), Eigen::Vector3d::Zero(), 0.0),
                   .path = path,
                   .viscosity = 0.01,
                   .scheme = AdvectionScheme::central});
  march.set_velocity([](const Eigen::Vector3d&) { return Eigen::Vector3d(0.0, 0.0, 0.0); });
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  while (march.state().time < periods * period) {
    const double step = march.advance().step;
    if (march.state().time < (periods - 1) * period) continue;
    // The force of a step is that of its middle.
    const BodyPose pose = path(march.state().time - 0.5 * step);
    const double v = pose.velocity.x();
    const Eigen::Vector2d parts(-0.5 * std::abs(v) * v, -0.25 * kPi * pose.acceleration.x());
    normal += step * parts * parts.transpose();
    right += step * march.loads().force.x() * parts;
  }
  const Eigen::Vector2d found = normal.inverse() * right;
  return {found.x(), found.y()};
}

}  // namespace flow_cases
