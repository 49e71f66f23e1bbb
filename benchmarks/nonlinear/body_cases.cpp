// A card of 35 x 20 x 0.1 mm falling in air, four sets of coefficients +-20 %, released 10 degrees about y
// and about an oblique axis. An absolute tolerance of 1e-3 of 0.1 m and of a turn of one radian stands beside
// the relative one.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "built.h"
#include "cases.h"

namespace samara::benchmarks {

namespace {

struct BodySet {
  const char* name;
  double C_D90, C_T, C_R;
  double end;
  double share = 0.2;            ///< half the width of the box, of each coefficient
  long max_calls = 150'000'000;  ///< bounds what a build that cannot succeed may take
};

codebooks::Plan body_plan(const BodySet& set, double axis) {
  const double half = 0.5 * 10.0 * std::numbers::pi / 180.0;
  std::string text = "model = 'immersed_body'\n[fixed]\na = 0.035\nb = 0.02\nc = 1e-4\ndensity = 1200.0\n";
  text += "C_D0 = 0.05\nC_w = 2.0\nspeed_floor = 1e-3\n";
  text += fmt::format("'qw(0)' = {}\n'qx(0)' = {}\n'qy(0)' = {}\n[box]\n", std::cos(half),
                      std::sin(half) * std::cos(axis), std::sin(half) * std::sin(axis));
  const auto interval = [&](const char* name, double value) {
    return fmt::format("{} = [{}, {}]\n", name, (1.0 - set.share) * value, (1.0 + set.share) * value);
  };
  text += interval("C_D90", set.C_D90) + interval("C_T", set.C_T) + interval("C_R", set.C_R);
  text += fmt::format("[time]\nend = {}\n[tolerance]\nrelative = 1e-3\nabsolute = {{ ", set.end);
  text += "x = 0.1, y = 0.1, z = 0.1, qw = 1.0, qx = 1.0, qy = 1.0, qz = 1.0, ux = 0.1, uy = 0.1, uz = 0.1, ";
  text += "wx = 5.0, wy = 5.0, wz = 5.0 }\n";
  text += fmt::format("[builder]\nkind = 'pgd'\nstrategy = 'slabs'\nmax_cells = 64\nmax_calls = {}\n",
                      set.max_calls);
  return codebooks::parse_plan(text, set.name);
}

/// The worst of the two releases.
void run(const BodySet& set, const Options& options) {
  double certificate = 0.0, time = 0.0, reached = 1.0;
  int rank = 0, cells = 0;
  bool met = true;
  std::string status;
  for (const double axis : {0.5 * std::numbers::pi, 0.6}) {
    if (options.quick && axis == 0.6) continue;
    const Built built = build_and_measure(body_plan(set, axis), 500);
    certificate = std::isnan(built.certificate_max) ? built.certificate_max
                                                    : std::max(certificate, built.certificate_max);
    time = std::max(time, built.time);
    reached = std::min(reached, built.reached);
    rank = std::max(rank, built.rank);
    cells = std::max(cells, built.cells);
    met = met && built.met;
    if (status.empty() || !built.met) status = built.status;
  }
  print({kNonlinear, set.name, "certificate_max", certificate});
  print({kNonlinear, set.name, "rank", static_cast<double>(rank)});
  print({kNonlinear, set.name, "cells", static_cast<double>(cells)});
  print({kNonlinear, set.name, "time", time, "s"});
  print({kNonlinear, set.name, "reached", reached});
  print({kNonlinear, set.name, "met", met ? 1.0 : 0.0, status});
}

}  // namespace

void run_bodies(const Options& options) {
  for (const BodySet& set :
       {BodySet{"body3d_sd", 1.81, 0.31, 0.31, 0.5}, BodySet{"body3d_zz", 0.31, 0.91, 0.61, 0.5},
        BodySet{"body3d_az", 0.61, 1.81, 1.21, 0.3}, BodySet{"body3d_ar", 0.61, 2.71, 0.91, 0.3},
        BodySet{"body3d_ar_cells", 0.61, 2.71, 0.91, 0.4, 0.05, 300'000'000}}) {
    if (options.wants(set.name)) run(set, options);
  }
}

}  // namespace samara::benchmarks
