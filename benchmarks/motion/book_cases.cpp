// Refining a planned fall with tangents of a codebook, beside those of steps: of a law that is
// compiled, and of the same equations as text.
#include <cmath>

#include <fmt/format.h>

#include "motion/cases.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/motion/planning/window_search.h"
#include "samara/motion/planning/windows.h"

namespace samara::benchmarks::motion_cases {

namespace {

using motion::MotionPlan;
using motion::PlannedFall;
using motion::RefiningState;

/// The box of the plan, and the states that its falls pass: velocities above zero, the others are images of these.
constexpr const char* kWindows = R"toml(
[fixed]
inertia_ratio = 1.3
[box]
C_T = [0.8, 1.4]
C_R = [2.0, 4.0]
A = [1.0, 1.8]
"vx(0)" = [0.0, 4.0]
"vy(0)" = [0.0, 1.2]
"w(0)" = [-1.5, 1.5]
"theta(0)" = [-3.14159265358979324, 3.14159265358979324]
[time]
end = 0.3
[tolerance]
relative = 1e-3
)toml";

/// falling_plate_nd with its defaults.
constexpr const char* kEquations = R"toml([equations]
name = "plate_as_text"
[equations.states]
vx = { initial = 1e-3 }
vy = { initial = 1e-3 }
w = {}
theta = { initial = 0.4 }
x = {}
y = {}
[equations.parameters]
inertia_ratio = { above = 0 }
C_T = { default = 1.2 }
C_R = { default = 3.14159265358979324 }
A = { default = 1.4 }
[equations.let]
beta2 = "1/196"
I = "inertia_ratio"
v = "sqrt(vx^2 + vy^2 + 1e-12)"
G = "2/pi*(-C_T*vx*vy/v + C_R*w)"
D = "(A - (vx^2 - vy^2)/v^2)*v/pi"
[equations.rates]
vx = "((I + 1)*w*vy - G*vy - sin(theta) - D*vx)/(I + beta2)"
vy = "(-(I + beta2)*w*vx + G*vx - cos(theta) - D*vy)/(I + 1)"
w = "(-(1 - beta2)*vx*vy - 0.2*(1 + abs(w))*w)/(0.25*(I*(1 + beta2) + 0.5*(1 - beta2)^2))"
theta = "w"
x = "vx*cos(theta) - vy*sin(theta)"
y = "vx*sin(theta) + vy*cos(theta)"
)toml";

RefiningState refined(const PlannedFall& fall, const motion::FoundFall& found) {
  RefiningState state = RefiningState::from(fall, fall.release(), found);
  refine_in_windows(fall, fall.release(), state, {});
  return state;
}

double deviation(const RefiningState& state) {
  return std::sqrt(state.best.end.square_time / state.best.end.t);
}

/// @param equations of the book's plan  @param rounds of timing
void report_book(const char* name, const std::string& equations, MotionPlan plan, int rounds) {
  const codebooks::Plan of_book = codebooks::parse_plan(equations + kWindows, "windows.toml");
  const codebooks::BuildResult built = codebooks::build(of_book);
  print({kMotion, name, "certificate_max", built.book.certificate()->max_error});
  print({kMotion, name, "build_time", built.book.provenance().build_seconds, "s"});
  const PlannedFall compiled(plan);
  motion::BeamState search = motion::BeamState::from(compiled.release());
  const motion::FoundFall found = search_beam(compiled, search, {}).falls.front();
  plan.model = of_book.parametric_model().shared_model();
  MotionPlan with_book = plan;
  with_book.codebook = std::make_shared<const codebooks::Codebook>(built.book);
  const PlannedFall by_steps(plan), by_book(with_book);

  const RefiningState ours = refined(by_book, found), theirs = refined(by_steps, found);
  constexpr const char* kBaseline = "tangents_of_steps";
  print({kMotion, name, "share", ours.use.share()});
  print({kMotion, name, "windows", static_cast<double>(ours.use.windows)});
  print({kMotion, name, "deviation", deviation(ours), "a", kBaseline, deviation(theirs) / deviation(ours)});
  const Pair all = time_both([&] { refined(by_book, found); }, [&] { refined(by_steps, found); }, rounds);
  print({kMotion, name, "refining_time", all.ours, "s", kBaseline, all.ratio()});
  print({kMotion, name, "refining_time_by_steps", all.theirs, "s"});
  // Of each line that is followed; build_time over it is how many lines pay for the build, where it is above zero.
  print({kMotion, name, "saved_time", all.theirs - all.ours, "s"});

  std::vector<motion::CourseKnot> knots = RefiningState::from(by_steps, by_steps.release(), found).knots;
  const motion::ReplayedFall now = replay(by_steps, by_steps.release(), knots);
  motion::Windows looks(by_book, knots), same(by_steps, knots);
  const Pair one = time_both([&] { looks.look(0, now, true); }, [&] { same.look(0, now, true); }, 3 * rounds);
  print({kMotion, name, "look_time", one.ours, "s", kBaseline, one.ratio()});
}

}  // namespace

void run_books(const Options& options) {
  if (options.wants("sketch_book"))
    report_book("sketch_book", "model = \"falling_plate_nd\"\n", s_plan(), options.quick ? 3 : 15);
  if (options.wants("sketch_book_text"))
    report_book("sketch_book_text", kEquations, s_plan(), options.quick ? 1 : 3);
}

}  // namespace samara::benchmarks::motion_cases
