// A card of 35 x 20 x 0.1 mm falling in air, four sets of coefficients, released 10 degrees about y and about
// an oblique axis. An absolute tolerance of 1e-3 of 0.1 m and of a turn of one radian stands beside the relative
// one.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "built.h"
#include "cases.h"
#include "exact_ranks.h"
#include "flow_map_case.h"

namespace samara::benchmarks {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kAboutY = 0.5 * std::numbers::pi;
constexpr double kOblique = 0.6;

struct Pattern {
  double C_D90, C_T, C_R;
};
constexpr Pattern kSteady = {1.81, 0.31, 0.31};
constexpr Pattern kZigzag = {0.31, 0.91, 0.61};
constexpr Pattern kAlternating = {0.61, 1.81, 1.21};
constexpr Pattern kAutorotation = {0.61, 2.71, 0.91};

/// Names and values of a card, in the order of the file; a value is a number or an interval.
struct Card {
  std::map<std::string, std::string> fixed = {{"a", "0.035"},         {"b", "0.02"},    {"c", "1e-4"},
                                              {"density", "1200.0"},  {"C_D0", "0.05"}, {"C_w", "2.0"},
                                              {"speed_floor", "1e-3"}};
  std::vector<std::pair<std::string, std::string>> box = {};

  void hold(const std::string& name, double value) { fixed[name] = fmt::format("{}", value); }
  void free(const std::string& name, double lower, double upper) {
    fixed.erase(name);
    box.emplace_back(name, fmt::format("[{}, {}]", lower, upper));
  }
  void free_coefficients(const Pattern& pattern, double share) {
    free("C_D90", (1.0 - share) * pattern.C_D90, (1.0 + share) * pattern.C_D90);
    free("C_T", (1.0 - share) * pattern.C_T, (1.0 + share) * pattern.C_T);
    free("C_R", (1.0 - share) * pattern.C_R, (1.0 + share) * pattern.C_R);
  }
  /// Ten degrees about a horizontal axis.
  void release_about(double axis) {
    hold("qw(0)", std::cos(5.0 * kDegree));
    hold("qx(0)", std::sin(5.0 * kDegree) * std::cos(axis));
    hold("qy(0)", std::sin(5.0 * kDegree) * std::sin(axis));
  }
};

/// By slabs unless the choice is left to the builder.
struct Limits {
  double end = 0.5;
  bool by_slabs = true;
  int max_cells = 64;
  long max_calls = 150'000'000;  ///< bounds what a march that cannot succeed may take
};

codebooks::Plan plan_of(const Card& card, const Limits& limits, const std::string& name) {
  std::string text = "model = 'immersed_body'\n[fixed]\n";
  for (const auto& [of, value] : card.fixed) text += fmt::format("'{}' = {}\n", of, value);
  text += "[box]\n";
  for (const auto& [of, interval] : card.box) text += fmt::format("'{}' = {}\n", of, interval);
  text += fmt::format("[time]\nend = {}\n[tolerance]\nrelative = 1e-3\nabsolute = {{ ", limits.end);
  text += "x = 0.1, y = 0.1, z = 0.1, qw = 1.0, qx = 1.0, qy = 1.0, qz = 1.0, ux = 0.1, uy = 0.1, uz = 0.1, ";
  text += "wx = 5.0, wy = 5.0, wz = 5.0 }\n";
  if (limits.by_slabs) {
    text += fmt::format("[builder]\nkind = 'pgd'\nstrategy = 'slabs'\nmax_cells = {}\nmax_calls = {}\n",
                        limits.max_cells, limits.max_calls);
  }
  return codebooks::parse_plan(text, name);
}

/// The worst of several builds of one case.
class Worst {
 public:
  explicit Worst(std::string name) : name_(std::move(name)) {}

  void add(const Built& built) {
    certificate_ = std::isnan(built.certificate_max) ? built.certificate_max
                                                     : std::max(certificate_, built.certificate_max);
    time_ = std::max(time_, built.time);
    reached_ = std::min(reached_, built.reached);
    fraction_ = std::max(fraction_, built.evaluation_fraction);
    rank_ = std::max(rank_, built.rank);
    cells_ = std::max(cells_, built.cells);
    met_ = met_ && built.met;
    if (status_.empty() || !built.met) status_ = built.met ? built.status : built.message;
  }

  void report() const {
    print({kNonlinear, name_, "certificate_max", certificate_});
    print({kNonlinear, name_, "rank", static_cast<double>(rank_)});
    print({kNonlinear, name_, "cells", static_cast<double>(cells_)});
    print({kNonlinear, name_, "time", time_, "s"});
    print({kNonlinear, name_, "evaluation_fraction", fraction_});
    print({kNonlinear, name_, "reached", reached_});
    print({kNonlinear, name_, "met", met_ ? 1.0 : 0.0, status_});
  }

 private:
  std::string name_;
  double certificate_ = 0.0, time_ = 0.0, reached_ = 1.0, fraction_ = 0.0;
  int rank_ = 0, cells_ = 0;
  bool met_ = true;
  std::string status_;
};

/// Three coefficients of a pattern, released about y and obliquely.
struct BodySet {
  const char* name;
  Pattern pattern;
  Limits limits = {};
  double share = 0.2;            ///< half the width of the box, of each coefficient
  bool has_exact_ranks = false;  ///< whether ranks are compared with those of the exact solution
};

void run(const BodySet& set, const Options& options) {
  if (!options.wants(set.name)) return;
  Worst worst(set.name);
  double rank_ratio = 0.0;
  for (const double axis : {kAboutY, kOblique}) {
    if (options.quick && axis == kOblique) continue;
    Card card;
    card.release_about(axis);
    card.free_coefficients(set.pattern, set.share);
    const codebooks::Plan plan = plan_of(card, set.limits, set.name);
    const Built built = build_and_measure(plan, 500);
    worst.add(built);
    if (set.has_exact_ranks)
      rank_ratio =
          std::max(rank_ratio, static_cast<double>(built.rank) / exact_rank(plan, built.certificate_max));
  }
  worst.report();
  if (set.has_exact_ranks) print({kNonlinear, set.name, "rank_ratio", rank_ratio});
}

/// Density, thickness and damping beside the coefficients, of zigzag and of autorotation.
Card card_of_six(const Pattern& pattern) {
  Card card;
  card.free_coefficients(pattern, 0.2);
  card.free("density", 1000.0, 1400.0);
  card.free("c", 0.8e-4, 1.2e-4);
  card.free("C_w", 1.6, 2.4);
  return card;
}

void run_six(const Options& options) {
  if (!options.wants("body6")) return;
  Worst worst("body6");
  for (const Pattern& pattern : {kZigzag, kAutorotation}) {
    for (const double axis : {kAboutY, kOblique}) {
      Card card = card_of_six(pattern);
      card.release_about(axis);
      worst.add(build_and_measure(plan_of(card, {.end = 0.3, .by_slabs = false}, "body6"), 500));
    }
  }
  worst.report();
}

/// Two components of the tilt of the release beside these: the vector along the axis, tan(angle/2) long. In an order
/// that keeps ranks low (docs/sampling.md): what breaks the symmetry of the motion first, what hardly acts last.
void run_nine(const Options& options) {
  if (!options.wants("body9")) return;
  Worst worst("body9");
  for (const Pattern& pattern : {kZigzag, kAutorotation}) {
    Card card;
    card.hold("qw(0)", 1.0);
    card.free("qx(0)", -std::tan(2.5 * kDegree), std::tan(2.5 * kDegree));
    card.free("C_T", 0.8 * pattern.C_T, 1.2 * pattern.C_T);
    card.free("qy(0)", std::tan(2.5 * kDegree), std::tan(7.5 * kDegree));
    card.free("C_R", 0.8 * pattern.C_R, 1.2 * pattern.C_R);
    card.free("density", 1000.0, 1400.0);
    card.free("c", 0.8e-4, 1.2e-4);
    card.free("C_D90", 0.8 * pattern.C_D90, 1.2 * pattern.C_D90);
    card.free("C_D0", 0.04, 0.06);
    card.free("C_w", 1.6, 2.4);
    worst.add(build_and_measure(plan_of(card, {.end = 0.3, .by_slabs = false}, "body9"), 500));
  }
  worst.report();
}

/// The flow map over 40 ms: coefficients, tilt, velocity, angular velocity.
void run_flow_map(const Options& options) {
  if (!options.wants("flow_map11")) return;
  Card card;
  card.free_coefficients(kAlternating, 0.2);
  card.hold("qw(0)", 1.0);
  card.free("qx(0)", -0.3, 0.3);
  card.free("qy(0)", -0.3, 0.3);
  card.free("ux(0)", 0.2, 0.9);
  card.free("uy(0)", -0.2, 0.2);
  card.free("uz(0)", -0.7, -0.1);
  card.free("wx(0)", -4.0, 4.0);
  card.free("wy(0)", -15.0, 15.0);
  card.free("wz(0)", -2.0, 2.0);
  flow_map_case(plan_of(card, {.end = 0.04, .by_slabs = false}, "flow_map11"));
}

}  // namespace

void run_bodies(const Options& options) {
  for (const BodySet& set :
       {BodySet{.name = "body3d_sd", .pattern = kSteady, .has_exact_ranks = true},
        BodySet{.name = "body3d_zz", .pattern = kZigzag, .has_exact_ranks = true},
        BodySet{
            .name = "body3d_az", .pattern = kAlternating, .limits = {.end = 0.3}, .has_exact_ranks = true},
        BodySet{
            .name = "body3d_ar", .pattern = kAutorotation, .limits = {.end = 0.3}, .has_exact_ranks = true},
        BodySet{.name = "body3d_ar_narrow", .pattern = kAutorotation, .limits = {.end = 0.4}, .share = 0.05},
        BodySet{.name = "body3d_zz_35", .pattern = kZigzag, .share = 0.35},
        BodySet{.name = "body3d_az_046", .pattern = kAlternating, .limits = {.end = 0.46, .by_slabs = false}},
        BodySet{.name = "body3d_az_05", .pattern = kAlternating, .limits = {.by_slabs = false}},
        BodySet{.name = "body3d_ar_037", .pattern = kAutorotation, .limits = {.end = 0.37}},
        BodySet{.name = "body3d_ar_05", .pattern = kAutorotation}}) {
    run(set, options);
  }
  run_six(options);
  run_nine(options);
  run_flow_map(options);
}

}  // namespace samara::benchmarks
