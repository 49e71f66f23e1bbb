#include "motion/motion_databases.h"

#include <fmt/format.h>

namespace samara::benchmarks::motion_cases {

namespace {

motion::MotionDatabase motions_of(const std::string& plan) {
  return motion::build_database(motion::run_sweep(motion::parse_sweep_plan(plan, "benchmark")).sweep);
}

}  // namespace

motion::MotionDatabase planar_motions(int runs) {
  return motions_of(fmt::format(
      "model = \"falling_plate_nd\"\n[fixed]\nbeta = 0\ninertia_ratio = 1.3\n[axes]\n"
      "C_T = {{ from = 0.8, to = 1.4 }}\nC_R = {{ from = 2, to = 4 }}\nA = {{ from = 1, to = 1.8 }}\n"
      "[sample]\ncount = {}\n[releases]\ntilt = [0.6]\n[run]\nuntil = 60\nstep = 0.05\nsettle = 10\n",
      runs));
}

motion::MotionDatabase card_motions(int count, double until, bool aslant_only) {
  std::string plan =
      "model = \"immersed_body\"\n[fixed]\na = \"3.5 cm\"\nb = \"2 cm\"\nc = \"0.01 cm\"\ndensity = 1200\n"
      "C_D0 = 0.05\nC_w = 2\n[axes]\n";
  for (const char* name : {"C_D90", "C_T", "C_R"})
    plan += fmt::format("{} = {{ from = 0.31, to = 2.71, count = {} }}\n", name, count);
  plan += fmt::format("[releases]\ntilt = [\"10 deg\"]\naxis = [{}\"35 deg\"]\n",
                      aslant_only ? "" : "\"0 deg\", ");
  plan += fmt::format("[run]\nuntil = {}\nstep = 0.001\nsettle = {}\n", until, 0.25 * until);
  return motions_of(plan);
}

}  // namespace samara::benchmarks::motion_cases
