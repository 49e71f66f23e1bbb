#include "samara/flow/turbulence/k_epsilon.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace samara::flow {

namespace {

using Constants = KEpsilonConstants;

/// Beside a piece of wall smaller than this the flow is taken for free.
constexpr double kLeastWall = 0.1;

/// |S|^2 and |W|^2 of a cell: normal rates in its middle, shear as the mean over its edges.
struct Rates {
  double strain = 0.0, rotation = 0.0;
};

Rates rates_of(const MacGrid& grid, const FaceField& velocity, Index c) {
  Rates rates;
  for (int d = 0; d < grid.dimensions; ++d) {
    const Index sd = grid.stride[static_cast<std::size_t>(d)];
    const double* const u = velocity[static_cast<std::size_t>(d)].data() + c;
    rates.strain += 2.0 * (u[sd] - u[0]) * (u[sd] - u[0]);
    for (int j = d + 1; j < grid.dimensions; ++j) {
      const Index sj = grid.stride[static_cast<std::size_t>(j)];
      const double* const v = velocity[static_cast<std::size_t>(j)].data() + c;
      for (const Index edge : {Index{0}, sd, sj, sd + sj}) {
        const double across = u[edge] - u[edge - sj], along = v[edge] - v[edge - sd];
        rates.strain += 0.25 * (across + along) * (across + along);
        rates.rotation += 0.25 * (across - along) * (across - along);
      }
    }
  }
  const double per_area = 1.0 / (grid.spacing * grid.spacing);
  return {per_area * rates.strain, per_area * rates.rotation};
}

/// eps = C_mu^{3/4} k^{3/2}/(kappa y) of the logarithmic layer.
double wall_dissipation(double k, double distance) {
  const double scale = std::pow(Constants::C_mu, 0.75) / WallLaw::kKarman;
  return scale * k * std::sqrt(k) / distance;
}

/// k after dk/dt = -eps where eps is that of the logarithmic layer.
double wall_decay(double k, double distance, double time) {
  const double rate = wall_dissipation(k, distance) / k;
  const double fall = 1.0 + 0.5 * rate * time;
  return k / (fall * fall);
}

}  // namespace

void decay(double& k, double& epsilon, double time) {
  const double growth = std::log1p((Constants::C_2 - 1.0) * epsilon / k * time) / (Constants::C_2 - 1.0);
  const double fall = std::exp(-growth);
  k *= fall;
  epsilon *= std::exp(-Constants::C_2 * growth);
}

void produce(double& k, double& epsilon, double growth) {
  k *= std::exp(growth);
  epsilon *= std::exp(Constants::C_1 * growth);
}

std::array<double, 2> stream_turbulence(double intensity, double speed, double length) {
  const double k = 1.5 * intensity * speed * intensity * speed;
  return {k, std::pow(Constants::C_mu, 0.75) * std::pow(k, 1.5) / (0.07 * length)};
}

double EnergyBudget::defect() const {
  const double largest =
      std::max({std::abs(before), std::abs(after), std::abs(entered), produced, dissipated});
  return largest > 0.0 ? std::abs(after - before - (entered + produced - dissipated)) / largest : 0.0;
}

KEpsilon::KEpsilon(const MacGrid& grid, const Borders& borders, const Openness& open, double viscosity,
                   TurbulenceModel model, double largest_eddy_viscosity)
    : k(grid.field(1.0)),
      epsilon(grid.field(1.0)),
      grid_(grid),
      borders_(borders),
      open_(open),
      viscosity_(viscosity),
      model_(model),
      largest_eddy_viscosity_(largest_eddy_viscosity),
      transport_(grid, borders, open),
      eddy_(grid.field()),
      production_(grid.field()),
      growth_(grid.field()),
      wall_distance_(grid.field()),
      row_sums_(static_cast<std::size_t>(grid.cells[1] * grid.cells[2])),
      sums_(grid) {
  set_walls();
  given_k_.fill(-1.0);
  given_epsilon_.fill(-1.0);
  wall_eddy_.fill(-1.0);
  for (std::size_t side = 0; side < 6; ++side) {
    const Border& border = borders.side[side];
    if (border.k <= 0.0) continue;
    given_k_[side] = border.k;
    given_epsilon_[side] = border.epsilon;
    if (border.kind == BorderKind::wall)
      wall_eddy_[side] = Constants::C_mu * border.k * border.k / border.epsilon;
    if (border.kind == BorderKind::inflow) {
      returning_k_ = border.k;
      returning_epsilon_ = border.epsilon;
    }
  }
}

void KEpsilon::set_walls() {
  for (std::size_t d = 0; d < 3; ++d) conductance_[d].resize(open_.wall_faces[d].size());
  for (const WallPiece& cell : open_.wall_cells) {
    if (cell.area > kLeastWall) wall_distance_[static_cast<std::size_t>(cell.at)] = cell.distance;
  }
}

void KEpsilon::follow_body(const BodyPose& pose) {
  pose_ = pose;
  transport_.follow_body();
  std::fill(wall_distance_.begin(), wall_distance_.end(), 0.0);
  set_walls();
}

void KEpsilon::set(double k_value, double epsilon_value) {
  std::fill(k.begin(), k.end(), k_value);
  std::fill(epsilon.begin(), epsilon.end(), epsilon_value);
}

void KEpsilon::prepare(const FaceField& velocity) {
  guarded_ = static_cast<long>(sums_.sum(grid_, [&](Index row) {
    double guarded = 0.0;
    for (Index c = row; c < row + grid_.cells[0]; ++c) {
      const auto at = static_cast<std::size_t>(c);
      const double eddy = Constants::C_mu * k[at] * k[at] / epsilon[at];
      eddy_[at] = std::min(eddy, largest_eddy_viscosity_);
      if (eddy > largest_eddy_viscosity_ && open_.inverse_cell[at] > 0.0) guarded += 1.0;
    }
    return guarded;
  }));
  for (const Index c : open_.closed_cells) eddy_[static_cast<std::size_t>(c)] = 0.0;
  fill_margins(grid_, borders_, eddy_, wall_eddy_, true);
  find_production(velocity);
  apply_wall_law(velocity);
}

void KEpsilon::find_production(const FaceField& velocity) {
  for_rows(grid_, all_cells(grid_), [&](Index row, int) {
    for (Index c = row; c < row + grid_.cells[0]; ++c) {
      const auto at = static_cast<std::size_t>(c);
      const Rates rates = rates_of(grid_, velocity, c);
      const double squared =
          model_ == TurbulenceModel::kato_launder ? std::sqrt(rates.strain * rates.rotation) : rates.strain;
      production_[at] = eddy_[at] * squared;
      growth_[at] = production_[at] / k[at];
    }
  });
  for (const Index c : open_.closed_cells)
    production_[static_cast<std::size_t>(c)] = growth_[static_cast<std::size_t>(c)] = 0.0;
}

/// Beside walls: G = tau_w u_tau/(kappa y), and what the faces lose.
void KEpsilon::apply_wall_law(const FaceField& velocity) {
  for (const WallPiece& cell : open_.wall_cells) {
    const auto at = static_cast<std::size_t>(cell.at);
    if (wall_distance_[at] == 0.0) continue;
    const WallLaw law(k[at], cell.distance, viscosity_);
    double squared = 0.0;
    const Eigen::Vector3d wall =
        cell.border ? Eigen::Vector3d::Zero() : pose_.velocity_at(grid_.place(cell.at, -1));
    for (int d = 0; d < grid_.dimensions; ++d) {
      const double* const u = velocity[static_cast<std::size_t>(d)].data() + cell.at;
      const double middle = 0.5 * (u[0] + u[grid_.stride[static_cast<std::size_t>(d)]]) - wall(d);
      squared += middle * middle;
    }
    production_[at] =
        law.conductance * std::sqrt(squared) * law.friction_velocity / (WallLaw::kKarman * cell.distance);
  }
  for (int d = 0; d < grid_.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const Index s = grid_.stride[at];
    for (std::size_t i = 0; i < open_.wall_faces[at].size(); ++i) {
      const WallPiece& face = open_.wall_faces[at][i];
      const auto above = static_cast<std::size_t>(face.at), below = static_cast<std::size_t>(face.at - s);
      const double weight_above = open_.cell[above], weight_below = open_.cell[below];
      const double energy =
          (weight_above * k[above] + weight_below * k[below]) / (weight_above + weight_below);
      conductance_[at][i] =
          face.area / grid_.spacing * WallLaw(energy, face.distance, viscosity_).conductance;
    }
  }
}

void KEpsilon::advance(const FaceField& velocity, double step) {
  budget_ = {};
  budget_.before = total(k);
  const double rate = transport_.set_velocity(velocity);
  // The new velocity may be a little faster than that which set the step.
  const int parts = std::max(1, static_cast<int>(std::ceil(rate * step / 0.5)));
  for (int part = 0; part < parts; ++part) {
    budget_.entered += transport_.advect(k, step / parts, given_k_, returning_k_);
    transport_.advect(epsilon, step / parts, given_epsilon_, returning_epsilon_);
  }
  budget_.entered += transport_.diffuse(k, step, viscosity_, &eddy_, Constants::sigma_k, given_k_);
  transport_.diffuse(epsilon, step, viscosity_, &eddy_, Constants::sigma_epsilon, given_epsilon_);
  apply_sources(step);
  budget_.after = total(k);
  fill_margins(grid_, borders_, k, given_k_);
  fill_margins(grid_, borders_, epsilon, given_epsilon_);
}

void KEpsilon::apply_sources(double step) {
  for_rows(grid_, all_cells(grid_), [&](Index row, int r) {
    std::array<double, 3> sum = {};
    for (Index c = row; c < row + grid_.cells[0]; ++c) {
      const auto at = static_cast<std::size_t>(c);
      const double inverse = open_.inverse_cell[at];
      if (inverse == 0.0) continue;
      // Looked at before production and walls could hide it.
      bool positive = k[at] > 0.0 && epsilon[at] > 0.0;
      const double before = k[at];
      double added;
      if (wall_distance_[at] > 0.0) {
        added = step * production_[at];
        k[at] = wall_decay(before + added, wall_distance_[at], step);
        epsilon[at] = wall_dissipation(k[at], wall_distance_[at]);
      } else {
        decay(k[at], epsilon[at], 0.5 * step);
        const double decayed = k[at];
        produce(k[at], epsilon[at], step * growth_[at]);
        added = k[at] - decayed;
        decay(k[at], epsilon[at], 0.5 * step);
      }
      sum[0] += added / inverse;
      sum[1] += (before + added - k[at]) / inverse;
      positive = positive && k[at] > 0.0 && epsilon[at] > 0.0;
      if (!positive) sum[2] += 1.0;
    }
    row_sums_[static_cast<std::size_t>(r)] = sum;
  });
  double not_positive = 0.0;
  for (const std::array<double, 3>& sum : row_sums_) {
    budget_.produced += sum[0];
    budget_.dissipated += sum[1];
    not_positive += sum[2];
  }
  not_positive_ = static_cast<long>(not_positive);
}

double KEpsilon::total(const Field& of) {
  return sums_.sum(grid_, [&](Index row) {
    double sum = 0.0;
    for (Index c = row; c < row + grid_.cells[0]; ++c) {
      const double inverse = open_.inverse_cell[static_cast<std::size_t>(c)];
      if (inverse > 0.0) sum += of[static_cast<std::size_t>(c)] / inverse;
    }
    return sum;
  });
}

double KEpsilon::total_production() {
  return total(production_) * std::pow(grid_.spacing, grid_.dimensions);
}

std::array<double, 3> KEpsilon::wall_range() const {
  double least = std::numeric_limits<double>::infinity(), largest = 0.0, viscous = 0.0, count = 0.0;
  for (const WallPiece& cell : open_.wall_cells) {
    const auto at = static_cast<std::size_t>(cell.at);
    if (wall_distance_[at] == 0.0) continue;
    const double y_plus = WallLaw(k[at], cell.distance, viscosity_).y_plus;
    least = std::min(least, y_plus);
    largest = std::max(largest, y_plus);
    viscous += y_plus <= WallLaw::kViscousReach ? 1.0 : 0.0;
    count += 1.0;
  }
  return count > 0.0 ? std::array<double, 3>{least, largest, viscous / count} : std::array<double, 3>{};
}

}  // namespace samara::flow
