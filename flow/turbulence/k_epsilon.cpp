#include "samara/flow/turbulence/k_epsilon.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "samara/base/exponentials.h"

namespace samara::flow {

namespace {

using Constants = KEpsilonConstants;

/// Beside a piece of wall smaller than this the flow is taken for free.
constexpr double kLeastWall = 0.1;

/// |S|^2 and |W|^2 of cells: normal rates in their middle, shear as the mean over their edges.
template <class V>
struct Rates {
  V strain = {}, rotation = {};
};

template <class V>
[[gnu::always_inline]] inline Rates<V> rates_of(const MacGrid& grid, const FaceField& velocity, Index c) {
  Rates<V> rates;
  for (int d = 0; d < grid.dimensions; ++d) {
    const Index sd = grid.stride[static_cast<std::size_t>(d)];
    const double* const u = velocity[static_cast<std::size_t>(d)].data() + c;
    const V normal = load<V>(u + sd) - load<V>(u);
    rates.strain += 2.0 * normal * normal;
    for (int j = d + 1; j < grid.dimensions; ++j) {
      const Index sj = grid.stride[static_cast<std::size_t>(j)];
      const double* const v = velocity[static_cast<std::size_t>(j)].data() + c;
      for (const Index edge : {Index{0}, sd, sj, sd + sj}) {
        const V across = load<V>(u + edge) - load<V>(u + edge - sj);
        const V along = load<V>(v + edge) - load<V>(v + edge - sd);
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
      straining_(grid.field()),
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
    double guarded[kEight] = {};
    by_eights(row, row + grid_.cells[0], [&]<class V>(Index c) {
      const V none = {}, most = none + largest_eddy_viscosity_;
      const V energy = load<V>(k.data() + c);
      const V eddy = Constants::C_mu * energy * energy / load<V>(epsilon.data() + c);
      store<V>(eddy > most ? most : eddy, eddy_.data() + c);
      const V open = load<V>(open_.inverse_cell.data() + c) > 0.0 ? none + 1.0 : none;
      store<V>(load<V>(guarded) + (eddy > most ? open : none), guarded);
    });
    return sum_of(guarded);
  }));
  for (const Index c : open_.closed_cells) eddy_[static_cast<std::size_t>(c)] = 0.0;
  fill_margins(grid_, borders_, eddy_, wall_eddy_, true);
  find_production(velocity);
  apply_wall_law(velocity);
}

void KEpsilon::find_production(const FaceField& velocity) {
  for_rows(grid_, all_cells(grid_), [&](Index row, int) {
    const Index end = row + grid_.cells[0];
    by_eights(row, end, [&]<class V>(Index c) {
      const Rates<V> rates = rates_of<V>(grid_, velocity, c);
      const V squared =
          model_ == TurbulenceModel::kato_launder ? rates.strain * rates.rotation : rates.strain;
      store<V>(squared, production_.data() + c);
    });
    if (model_ == TurbulenceModel::kato_launder) {
      for (Index c = row; c < end; ++c)
        production_[static_cast<std::size_t>(c)] = std::sqrt(production_[static_cast<std::size_t>(c)]);
    }
    by_eights(row, end, [&]<class V>(Index c) {
      const V squared = load<V>(production_.data() + c);
      store<V>(Constants::C_mu * squared, straining_.data() + c);
      store<V>(load<V>(eddy_.data() + c) * squared, production_.data() + c);
    });
  });
  for (const Index c : open_.closed_cells)
    production_[static_cast<std::size_t>(c)] = straining_[static_cast<std::size_t>(c)] = 0.0;
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

/// Cells from `first` to `end`, at most kTogether: half of the decay, production, half of the decay, each exact. With
/// z = 1 + (C_2 - 1) eps/k dt/2 a half of the decay takes k by z^(-1/(C_2 - 1)) and eps/k by 1/z. Production of one
/// strain, G/k = C_mu |S|^2 k/eps, takes k by w^(1/(C_1 - 1)) and eps/k by w = 1 + (C_1 - 1) G/k dt: eps grows faster
/// than k, so that little energy in large eddies does not grow without bounds in a step.
void KEpsilon::act_in_fluid(Index first, Index end, double step, Sums& sums) {
  constexpr double kFall = -1.0 / (Constants::C_2 - 1.0), kRise = Constants::C_1 - 1.0;
  const double half = 0.5 * step * (Constants::C_2 - 1.0);
  const auto count = static_cast<std::size_t>(end - first);
  double rate[kTogether], grown[kTogether], risen[kTogether], before[kTogether], after[kTogether];
  double* const of_k = k.data() + first;
  double* const of_epsilon = epsilon.data() + first;
  by_eights(0, end - first, [&]<class V>(Index i) {
    const V ratio = load<V>(of_epsilon + i) / load<V>(of_k + i);
    const V z = 1.0 + half * ratio;
    const V rise = 1.0 + kRise * step * load<V>(straining_.data() + first + i) * z / ratio;
    store<V>(ratio, rate + i);
    store<V>(z, before + i);
    store<V>(rise, grown + i);
    store<V>(rise, risen + i);
  });
  take_logarithms({grown, count});
  by_eights(0, end - first, [&]<class V>(Index i) { store<V>(1.0 / kRise * load<V>(grown + i), grown + i); });
  take_exponentials({grown, count});
  by_eights(0, end - first, [&]<class V>(Index i) {
    const V ratio = load<V>(rate + i) / load<V>(before + i) * load<V>(risen + i), z = 1.0 + half * ratio;
    store<V>(ratio / z, rate + i);
    store<V>(z, after + i);
  });
  // Of what is no number the logarithm gives one; `rate` carries it on.
  for (double* const z : {before, after}) {
    take_logarithms({z, count});
    by_eights(0, end - first, [&]<class V>(Index i) { store<V>(kFall * load<V>(z + i), z + i); });
    take_exponentials({z, count});
  }
  by_eights(0, end - first, [&]<class V>(Index i) {
    const V none = {}, one = none + 1.0;
    const V old = load<V>(of_k + i), old_epsilon = load<V>(of_epsilon + i);
    const V decayed = old * load<V>(before + i), added = decayed * (load<V>(grown + i) - 1.0);
    const V energy = (decayed + added) * load<V>(after + i), dissipation = energy * load<V>(rate + i);
    const V inverse = load<V>(open_.inverse_cell.data() + first + i);
    const V in_fluid = load<V>(wall_distance_.data() + first + i) > 0.0 ? none : (inverse > 0.0 ? one : none);
    // Where the wall gives eps the growth may be beyond all numbers, and 0 of it is none.
    const V produced = in_fluid > 0.0 ? added / inverse : none;
    const V dissipated = in_fluid > 0.0 ? (old + added - energy) / inverse : none;
    store<V>(load<V>(sums.produced) + produced, sums.produced);
    store<V>(load<V>(sums.dissipated) + dissipated, sums.dissipated);
    // Looked at as they came, too, before production could hide it.
    const auto positive = (old > 0.0) & (old_epsilon > 0.0) & (energy > 0.0) & (dissipation > 0.0);
    store<V>(load<V>(sums.not_positive) + (positive ? none : in_fluid), sums.not_positive);
    store<V>(in_fluid > 0.0 ? energy : old, of_k + i);
    store<V>(in_fluid > 0.0 ? dissipation : old_epsilon, of_epsilon + i);
  });
}

/// A cell where the law of the wall gives eps.
void KEpsilon::act_beside_wall(Index c, double step, Sums& sums) {
  const auto at = static_cast<std::size_t>(c);
  const double inverse = open_.inverse_cell[at];
  if (inverse == 0.0) return;
  const double before = k[at], added = step * production_[at];
  // Looked at before production and walls could hide it.
  bool positive = before > 0.0 && epsilon[at] > 0.0;
  k[at] = wall_decay(before + added, wall_distance_[at], step);
  epsilon[at] = wall_dissipation(k[at], wall_distance_[at]);
  positive = positive && k[at] > 0.0 && epsilon[at] > 0.0;
  sums.produced[0] += added / inverse;
  sums.dissipated[0] += (before + added - k[at]) / inverse;
  if (!positive) sums.not_positive[0] += 1.0;
}

void KEpsilon::apply_sources(double step) {
  for_rows(grid_, all_cells(grid_), [&](Index row, int r) {
    Sums sums;
    const Index end = row + grid_.cells[0];
    for (Index first = row; first < end; first += kTogether)
      act_in_fluid(first, std::min(first + kTogether, end), step, sums);
    for (Index c = row; c < end; ++c) {
      if (wall_distance_[static_cast<std::size_t>(c)] > 0.0) act_beside_wall(c, step, sums);
    }
    row_sums_[static_cast<std::size_t>(r)] = {sum_of(sums.produced), sum_of(sums.dissipated),
                                              sum_of(sums.not_positive)};
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
    double sum[kEight] = {};
    by_eights(row, row + grid_.cells[0], [&]<class V>(Index c) {
      const V inverse = load<V>(open_.inverse_cell.data() + c), none = {};
      const V share = inverse > 0.0 ? load<V>(of.data() + c) / inverse : none;
      store<V>(load<V>(sum) + share, sum);
    });
    return sum_of(sum);
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
