#include "discs.h"

namespace samara::benchmarks::identification {

using samara::identification::FitOptions;

namespace {

/// s: longer than every window, so that each is one piece.
constexpr double kUncut = 20.0;

}  // namespace

Box disc_start_box(double place, double speed, double rate) {
  Box box;
  for (const char* name : {"x(0)", "y(0)", "z(0)"}) box[name] = {-place, place};
  for (const char* name : {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}) box[name] = {-1.1, 1.1};
  for (const char* name : {"ux(0)", "uy(0)", "uz(0)"}) box[name] = {-speed, speed};
  for (const char* name : {"wx(0)", "wy(0)"}) box[name] = {-rate, rate};
  return box;
}

FitOptions disc_options(const Coefficients& first, double misfit, const std::string& motion) {
  FitOptions options;
  options.starts.initial = first;
  for (const auto& [name, value] : first) {
    options.unknowns.log_scale.push_back(name);
    options.priors.coordinates[name] = {.mean = value, .deviation = 1.0, .logarithmic = true};
  }
  options.loss.length_scale = misfit;
  options.starts.round_body = true;
  options.segments.length = kUncut;
  options.uncertainty.cluster_by = {motion};
  options.starts.count = 1;
  options.starts.rounds = 2;
  options.solver.max_iterations = 25;
  return options;
}

}  // namespace samara::benchmarks::identification
