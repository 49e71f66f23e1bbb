#include "samara/models/checks/kinks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <utility>

#include "samara/base/number_text.h"
#include "samara/base/require.h"
#include "samara/base/text.h"
#include "samara/models/checks/check_parts.h"

namespace samara::models {

namespace {

/// Distances are scale / 2^k, from the whole scale to one that round-off cannot tell from none.
constexpr int kOctaves = 30;
/// Changes are compared with that within scale / 2^6. Of a smooth function a quarter of it is left at 2^8.
constexpr int kWide = 6;
constexpr int kNarrow = 8;
/// Least change of a rate, and of a slope times the scale, over the largest |rate|.
constexpr double kLeastOfRate = 0.01;
constexpr double kLeastOfSlope = 0.1;
/// By which a parameter is divided to see whether the distance follows it, and the octaves that this is.
constexpr double kStretch = 8.0;
constexpr int kStretchOctaves = 3;

/// Rates, and their slopes along one state times its scale.
struct Rates {
  Eigen::VectorXd value, slope;
};

/// A line along one state.
struct Line {
  const Model& model;
  double t;
  std::vector<double> x;
  ParameterValues p;
  std::size_t state;
  double scale;

  Rates operator()(double value) {
    x[state] = value;
    const auto n = static_cast<Eigen::Index>(x.size());
    Rates rates{Eigen::VectorXd(n), {}};
    Eigen::MatrixXd df_dx(n, n), df_dp(n, static_cast<Eigen::Index>(p.value.size()));
    model.rhs_with_derivatives(t, x, p, {rates.value.data(), x.size()}, df_dx, df_dp);
    rates.slope = scale * df_dx.col(static_cast<Eigen::Index>(state));
    return rates;
  }

  std::vector<Wrench> forces(double value) {
    x[state] = value;
    std::vector<Wrench> terms(model.info().force_terms.size());
    model.forces(t, x, p, terms);
    return terms;
  }
};

/// How much rates and slopes change within every distance around a value: rates x distances.
struct Changes {
  Eigen::MatrixXd of_rate, of_slope;
  Eigen::VectorXd size;  ///< largest |rate|
};

double distance_of(const Line& line, int octave) {
  return std::ldexp(line.scale, -octave);
}

/// Nothing where a rate is not finite.
std::optional<Changes> changes_around(Line& line, double centre) {
  // Not at round numbers, where branches meet.
  constexpr double kOff = 0.93;
  const auto n = static_cast<Eigen::Index>(line.x.size());
  Changes changes{Eigen::MatrixXd(n, kOctaves + 1), Eigen::MatrixXd(n, kOctaves + 1),
                  Eigen::VectorXd::Zero(n)};
  Rates least = line(centre + kOff * distance_of(line, kOctaves)), most = least;
  for (int k = kOctaves; k >= 0; --k) {
    for (const double side : {-1.0, 1.0}) {
      const Rates here = line(centre + side * kOff * distance_of(line, k));
      if (!here.value.allFinite() || !here.slope.allFinite()) return std::nullopt;
      least = {least.value.cwiseMin(here.value), least.slope.cwiseMin(here.slope)};
      most = {most.value.cwiseMax(here.value), most.slope.cwiseMax(here.slope)};
      changes.size = changes.size.cwiseMax(here.value.cwiseAbs());
    }
    changes.of_rate.col(k) = most.value - least.value;
    changes.of_slope.col(k) = most.slope - least.slope;
  }
  return changes;
}

/// The octave up to which half of the change within the wide distance stays.
int octave_of(const Eigen::MatrixXd& changes, Eigen::Index rate) {
  int octave = kWide;
  while (octave < kOctaves && changes(rate, octave + 1) >= 0.5 * changes(rate, kWide)) ++octave;
  return octave;
}

/// A rate that changes abruptly: which, and how.
struct Abrupt {
  Eigen::Index rate = 0;
  bool is_of_rate = false;
  double jump = 0.0;
  int octave = 0;
};

std::optional<Abrupt> most_abrupt(const Changes& changes) {
  std::optional<Abrupt> worst;
  const auto look = [&](const Eigen::MatrixXd& of, bool is_of_rate, double least) {
    for (Eigen::Index i = 0; i < changes.size.size(); ++i) {
      const double jump = of(i, kNarrow) / changes.size[i];
      if (!(jump >= least) || octave_of(of, i) < kNarrow) continue;
      if (!worst || jump > worst->jump) worst = Abrupt{i, is_of_rate, jump, octave_of(of, i)};
    }
  };
  look(changes.of_rate, true, kLeastOfRate);
  if (!worst) look(changes.of_slope, false, kLeastOfSlope);
  return worst;
}

using Components = Eigen::Matrix<double, 6, 1>;

Components components(const Wrench& wrench) {
  Components all;
  all << wrench.force, wrench.torque;
  return all;
}

/// Largest less smallest slope between neighbours: what is smooth has about one.
Components change_of_slopes(const std::vector<Components>& values, const std::vector<double>& at) {
  Components least = Components::Constant(HUGE_VAL), most = -least;
  for (std::size_t j = 1; j < values.size(); ++j) {
    const Components slope = (values[j] - values[j - 1]) / (at[j] - at[j - 1]);
    least = least.cwiseMin(slope);
    most = most.cwiseMax(slope);
  }
  return most - least;
}

/// Force terms are compared by the change of their slopes over the largest force, or torque, of all.
std::string term_of(Line& line, double centre, const Abrupt& abrupt) {
  const std::vector<ForceTermInfo>& infos = line.model.info().force_terms;
  if (infos.empty()) return "";
  // Close enough for what is smooth to change little.
  const double wide = distance_of(line, std::max(abrupt.octave - kStretchOctaves, kWide)),
               narrow = 0.3 * distance_of(line, abrupt.octave);
  const std::vector<double> at = {centre - wide,   centre - 0.5 * wide, centre - narrow,
                                  centre + narrow, centre + 0.5 * wide, centre + wide};
  std::vector<std::vector<Components>> terms(infos.size());
  double force = 0.0, torque = 0.0;
  for (const double value : at) {
    const std::vector<Wrench> wrenches = line.forces(value);
    for (std::size_t k = 0; k < infos.size(); ++k) {
      terms[k].push_back(components(wrenches[k]));
      force = std::max(force, wrenches[k].force.cwiseAbs().maxCoeff());
      torque = std::max(torque, wrenches[k].torque.cwiseAbs().maxCoeff());
    }
  }
  std::size_t worst = 0;
  double largest = 0.0;
  for (std::size_t k = 0; k < infos.size(); ++k) {
    const Components change = change_of_slopes(terms[k], at);
    const double of_force = force > 0.0 ? change.head<3>().maxCoeff() / force : 0.0;
    const double of_torque = torque > 0.0 ? change.tail<3>().maxCoeff() / torque : 0.0;
    if (std::max(of_force, of_torque) > largest) {
      largest = std::max(of_force, of_torque);
      worst = k;
    }
  }
  return largest > 0.0 ? infos[worst].name : "";
}

/// The parameter that the distance grows with. It is divided twice: what only hides the kink behind something smooth
/// shows it at its true distance after the first time, and there it stays.
std::string floor_of(const Line& line, double centre, const Abrupt& abrupt) {
  const std::vector<ParameterInfo>& parameters = line.model.info().parameters;
  const auto follows = [&](std::size_t j, int times) {
    Line other = line;
    other.p.value[j] *= std::pow(kStretch, -times);
    const std::optional<Changes> changes = changes_around(other, centre);
    const int expected = abrupt.octave + times * kStretchOctaves;
    if (!changes || expected >= kOctaves) return false;
    const int octave = octave_of(abrupt.is_of_rate ? changes->of_rate : changes->of_slope, abrupt.rate);
    return std::abs(octave - expected) <= 1;
  };
  for (std::size_t j = 0; j < line.p.value.size(); ++j) {
    if (parameters[j].unit != line.model.info().states[line.state].unit || line.p.value[j] == 0.0) continue;
    if (follows(j, 1) && follows(j, 2)) return parameters[j].name;
  }
  return "";
}

/// A kink, and all that is needed to say more of it.
struct Found {
  Line line;
  double centre;
  Abrupt abrupt;
};

std::optional<Found> found_around(Line line, double centre) {
  const std::optional<Changes> changes = changes_around(line, centre);
  const std::optional<Abrupt> abrupt = changes ? most_abrupt(*changes) : std::nullopt;
  if (!abrupt) return std::nullopt;
  return Found{std::move(line), centre, *abrupt};
}

Kink named(Found found) {
  Line& line = found.line;
  const Abrupt& abrupt = found.abrupt;
  const ModelInfo& info = line.model.info();
  Kink kink;
  kink.state = info.states[line.state].name;
  kink.unit = info.states[line.state].unit;
  kink.at = found.centre;
  kink.scale = line.scale;
  kink.distance = abrupt.octave < kOctaves ? distance_of(line, abrupt.octave) : 0.0;
  kink.rate = info.states[static_cast<std::size_t>(abrupt.rate)].name;
  kink.is_of_rate = abrupt.is_of_rate;
  kink.jump = abrupt.jump;
  kink.term = term_of(line, found.centre, abrupt);
  kink.floor = floor_of(line, found.centre, abrupt);
  return kink;
}

/// Where along the line, within two scales of zero, rates or slopes change most abruptly: the half of a cell in
/// which they change more, again and again.
double most_abrupt_place(Line& line) {
  constexpr int kCells = 32;
  constexpr int kHalvings = 40;
  // Neither cells nor halves end at round numbers.
  constexpr double kFirst = -2.03, kPart = 0.47;
  double begin = kFirst * line.scale, end = begin;
  Rates at_begin = line(begin), at_end = at_begin;
  Eigen::VectorXd size = at_begin.value.cwiseAbs().cwiseMax(1e-300);
  const auto change = [&](const Rates& a, const Rates& b) {
    size = size.cwiseMax(b.value.cwiseAbs());
    return std::max((a.value - b.value).cwiseQuotient(size).cwiseAbs().maxCoeff(),
                    (a.slope - b.slope).cwiseQuotient(size).cwiseAbs().maxCoeff());
  };
  double largest = -1.0;
  Rates before = at_begin;
  for (int k = 1; k <= kCells; ++k) {
    const double left = (kFirst + 0.13 * (k - 1)) * line.scale, right = (kFirst + 0.13 * k) * line.scale;
    Rates here = line(right);
    const double changed = change(before, here);
    if (changed > largest) {
      largest = changed;
      begin = left;
      end = right;
      at_begin = before;
      at_end = here;
    }
    before = std::move(here);
  }
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = begin + kPart * (end - begin);
    const Rates here = line(middle);
    if (change(at_begin, here) > change(here, at_end)) {
      end = middle;
      at_end = here;
    } else {
      begin = middle;
      at_begin = here;
    }
  }
  return 0.5 * (begin + end);
}

/// The largest jump along every state: those of rates before those of slopes.
using LargestByState = std::map<std::size_t, Found>;

void keep_larger(LargestByState& kept, std::optional<Found> found) {
  if (!found) return;
  const auto before = kept.find(found->line.state);
  const auto size = [](const Found& f) { return std::pair(f.abrupt.is_of_rate, f.abrupt.jump); };
  if (before != kept.end() && !(size(*found) > size(before->second))) return;
  if (before != kept.end()) kept.erase(before);
  const std::size_t state = found->line.state;
  kept.emplace(state, std::move(*found));
}

std::vector<Kink> named(const LargestByState& kept) {
  std::vector<Kink> kinks;
  for (const auto& [state, found] : kept) kinks.push_back(named(found));
  return kinks;
}

bool is_of_quaternion(const ModelInfo& info, std::size_t state) {
  return std::ranges::any_of(info.groups, [&](const StateGroup& group) {
    const auto first = static_cast<std::size_t>(group.first);
    return group.kind == StateGroupKind::quaternion && state >= first && state < first + 4;
  });
}

/// Lines along all states but those of attitudes, through one point.
std::vector<Line> lines_through(const Model& model, double t, std::span<const double> x,
                                const ParameterValues& p) {
  const ModelInfo& info = model.info();
  const Scales scales = model.scales(p);
  const ParameterValues all = {model.completed(p), std::vector<char>(p.given.size(), 1)};
  std::vector<Line> lines;
  for (std::size_t s = 0; s < info.states.size(); ++s) {
    if (is_of_quaternion(info, s)) continue;
    lines.push_back({model, t, {x.begin(), x.end()}, all, s, state_scale(info.states[s], scales)});
  }
  return lines;
}

}  // namespace

std::string described(const Kink& kink) {
  const auto text = [](double value) { return number_text(value, 3); };
  std::string sentence = "the rate of " + in_quotes(kink.rate) + (kink.is_of_rate ? " jumps" : " bends") +
                         " at " + kink.state + " = " + text(kink.at) + " " + kink.unit;
  if (kink.distance > 0.0)
    sentence += ", within " + text(kink.distance) + " of a scale of " + text(kink.scale);
  sentence += (kink.is_of_rate ? ", by " : "; its slope changes by ") + text(kink.jump) +
              (kink.is_of_rate ? " of its size" : " of its size over the scale");
  if (!kink.term.empty()) sentence += "; most of it is of the term " + in_quotes(kink.term);
  if (!kink.floor.empty()) sentence += "; the distance is set by " + kink.floor;
  return sentence;
}

std::vector<Kink> kinks_at_zero(const Model& model, const std::vector<ModelPoint>& points) {
  LargestByState kept;
  for (const ModelPoint& point : points) {
    for (const Line& line : lines_through(model, point.t, point.x, point.p))
      keep_larger(kept, found_around(line, 0.0));
  }
  return named(kept);
}

std::vector<Kink> find_kinks(const Model& model, const FindKinksOptions& options) {
  require(options.points >= 1, "points", options.points, "1 or more");
  const ModelInfo& info = model.info();
  std::mt19937 random(options.seed);
  LargestByState kept;
  for (int k = 0; k < options.points; ++k) {
    Point point = random_point(model, random);
    for (std::size_t s = 0; s < info.states.size(); ++s) {
      if (!is_of_quaternion(info, s) && random() % 2 == 0) point.x[s] = 0.0;
    }
    for (Line& line : lines_through(model, point.t, point.x, point.p)) {
      keep_larger(kept, found_around(line, 0.0));
      const double place = most_abrupt_place(line);
      keep_larger(kept, found_around(std::move(line), place));
    }
  }
  return named(kept);
}

}  // namespace samara::models
