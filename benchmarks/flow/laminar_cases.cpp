// Laminar flows: exact vortices, the cavity of Botella and Peyret, the channel with a cylinder of the DFG.
#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "cases.h"
#include "tests/flow/flow_cases.h"

namespace samara::benchmarks {

namespace {

using namespace flow_cases;

void run_taylor_green() {
  const TaylorGreenErrors coarse = taylor_green_errors(64, 0.0), fine = taylor_green_errors(128, 0.0);
  print({kFlow, "taylor_green", "order", std::log2(coarse.u / fine.u), "1", "exact"});
  print({kFlow, "taylor_green", "order_p", std::log2(coarse.p / fine.p), "1", "exact"});
}

/// O. Botella, R. Peyret, Computers and Fluids 27 (1998) 421.
void run_cavity() {
  const CavityExtrema found = cavity_extrema(256, 1000.0, 1e-5);
  const double error =
      std::max({std::abs(found.u_min / -0.3885698 - 1.0), std::abs(found.v_max / 0.3769447 - 1.0),
                std::abs(found.v_min / -0.5270771 - 1.0)});
  print({kFlow, "cavity_1000", "error_max", error, "1", "botella_peyret"});
}

void run_steady_cylinder() {
  FlowMarch march(dfg_channel(40, 20.0));
  start_channel(march);
  while (march.state().time < 16.0) march.advance();
  const Eigen::Vector3d force = march.loads().force;
  print({kFlow, "dfg_2d1", "C_D_error", std::abs(2.0 * force.x() / 5.57953523384 - 1.0), "1", "featflow"});
  print({kFlow, "dfg_2d1", "C_L_error", std::abs(2.0 * force.y() - 0.010618948146), "1", "featflow"});
}

/// Largest drag and frequency of the lift over the last 15 D/U of 45.
void run_shedding_cylinder() {
  FlowMarch march(dfg_channel(40, 100.0));
  start_channel(march);
  double drag = 0.0, before = 0.0;
  std::vector<double> crossings;
  while (march.state().time < 45.0) {
    const StepReport report = march.advance();
    const Eigen::Vector3d force = 2.0 * march.loads().force;
    if (march.state().time > 30.0) {
      drag = std::max(drag, force.x());
      if (before < 0.0 && force.y() >= 0.0)
        crossings.push_back(march.state().time - report.step * force.y() / (force.y() - before));
    }
    before = force.y();
  }
  print({kFlow, "dfg_2d2", "C_D_max_error", std::abs(drag / 3.23 - 1.0), "1", "featflow"});
  const double periods = static_cast<double>(crossings.size()) - 1.0;
  const double strouhal = periods > 0.0 ? periods / (crossings.back() - crossings.front()) : 0.0;
  print({kFlow, "dfg_2d2", "St_error", std::abs(strouhal / 0.3 - 1.0), "1", "featflow"});
}

/// A circle to and fro in fluid at rest at Keulegan and Carpenter's number 5, Re 100: drag and added mass of Morison's
/// equation over the fifth period, of which C_D 2.09 and C_A 1.45 are published (H. Duetsch, F. Durst, S. Becker, H.
/// Lienhart, J. Fluid Mech. 360 (1998) 249).
void run_oscillating_circle(const Options& options) {
  for (const int cells : options.quick ? std::vector<int>{10} : std::vector<int>{10, 20}) {
    const MorisonFit found = oscillating_circle(cells, 10.0, 5);
    print({kFlow, "oscillating_circle", fmt::format("C_D_{}", cells), found.drag, "1", "duetsch_1998"});
    print({kFlow, "oscillating_circle", fmt::format("C_A_{}", cells), found.added_mass, "1", "duetsch_1998"});
  }
}

/// A circle that is moved through fluid at rest and one that is held in a stream: by Galilei their drag is the same.
void run_moved_circle(const Options& options) {
  std::vector<double> apart;
  for (const int cells : options.quick ? std::vector<int>{8, 16} : std::vector<int>{8, 16, 32}) {
    apart.push_back(std::abs(early_drag(cells, true) / early_drag(cells, false) - 1.0));
    print({kFlow, "moved_circle", fmt::format("apart_{}", cells), apart.back(), "1", "held in a stream"});
  }
  print({kFlow, "moved_circle", "order", std::log2(apart[apart.size() - 2] / apart.back()), "1",
         "held in a stream"});
}

}  // namespace

void run_laminar(const Options& options) {
  if (options.wants("taylor_green")) run_taylor_green();
  if (options.wants("dfg_2d1")) run_steady_cylinder();
  if (options.only_case == "oscillating_circle") run_oscillating_circle(options);
  if (options.wants("moved_circle")) run_moved_circle(options);
  if (options.only_case == "cavity_1000") run_cavity();
  if (options.only_case == "dfg_2d2") run_shedding_cylinder();
}

}  // namespace samara::benchmarks
