// Sweeps: what is run, the same bits whether interrupted or not, files, and plans that cannot be meant.
#include "samara/motion/sweeps/sweep.h"

#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>

#include "known_motions.h"
#include "plates_sweep.h"
#include "samara/motion/sweeps/landing.h"
#include "samara/motion/sweeps/pattern_map.h"
#include "samara/motion/sweeps/refining.h"
#include "samara/motion/sweeps/sweep_file.h"
#include "tests/io/temporary_directory.h"

using namespace samara::motion;

namespace {

void check_same_falls(const Sweep& first, const Sweep& second) {
  REQUIRE(first.fall_count() == second.fall_count());
  for (std::size_t n = 0; n < first.labels.size(); ++n) {
    CHECK(first.labels[n].pattern == second.labels[n].pattern);
    CHECK(first.labels[n].margin == second.labels[n].margin);
    CHECK(first.status[n] == second.status[n]);
    for (std::size_t f = 0; f < kFeatures; ++f)
      CHECK(are_same(first.features[n].values[f], second.features[n].values[f]));
    const auto k = static_cast<Eigen::Index>(n);
    CHECK(first.reached[k] == second.reached[k]);
    for (Eigen::Index c = 0; c < 3; ++c) CHECK(are_same(first.landing(k, c), second.landing(k, c)));
  }
}

}  // namespace

TEST_CASE("a sweep labels each fall as its trajectory alone is labelled") {
  const Sweep sweep = run_sweep(plates()).sweep;
  REQUIRE(sweep.fall_count() == 36);
  for (Eigen::Index n = 0; n < 36; n += 5) {
    const Eigen::VectorXd point = sweep.points.row(sweep.point_of(n));
    const double theta = sweep.releases[static_cast<std::size_t>(sweep.release_of(n))].tilt;
    MotionRecord alone =
        simulated("falling_plate_nd",
                  {{"beta", 0.0}, {"inertia_ratio", point[0]}, {"C_R", point[1]}, {"theta(0)", theta}}, 120.0,
                  0.2, 0.05);
    const Features f = features(alone, {.settle = 60.0});
    CHECK(sweep.labels[static_cast<std::size_t>(n)].pattern == label(f).pattern);
    CHECK(sweep.features[static_cast<std::size_t>(n)][Feature::tilt] ==
          Approx(f[Feature::tilt]).epsilon(1e-6));
  }
  const std::vector<int> counts = sweep.counts(0);
  CHECK(counts[static_cast<std::size_t>(Pattern::zigzag)] > 3);
  CHECK(counts[static_cast<std::size_t>(Pattern::autorotation)] >= 1);
  CHECK(counts[static_cast<std::size_t>(Pattern::chaotic)] >= 1);
}

TEST_CASE(
    "a sweep that was cancelled goes on from its checkpoint to the same bits, on any number of threads") {
  const TemporaryDirectory folder;
  const auto checkpoint = folder.path() / "sweep.h5.part";
  const SweepPlan plan = plates("", "count = 9", "count = 700");  // 2,800 falls, three chunks
  const Sweep whole = run_sweep(plan, {.threads = 1}).sweep;
  int calls = 0;
  const SweepResult cut = run_sweep(plan, {.progress =
                                               [&](const samara::Progress& p) {
                                                 ++calls;
                                                 return p.fraction < 0.5;
                                               },
                                           .checkpoint = checkpoint});
  CHECK_FALSE(cut.complete);
  CHECK(cut.message.find("cancelled after ") == 0);
  REQUIRE(cut.falls_done > 0);
  REQUIRE(std::filesystem::exists(checkpoint));
  CHECK(error_text<samara::InputError>([&] {
          run_sweep(plates("", "count = 9", "count = 701"), {.checkpoint = checkpoint});
        }).find("belongs to another plan") != std::string::npos);
  // Nor may another program, or another model of the same name, go on with it.
  const auto refused = [&](const auto& change) {
    const auto other = folder.path() / "other.part";
    Sweep kept = load_sweep(checkpoint);
    change(kept);
    save_checkpoint(kept, other);
    return error_text<samara::InputError>([&] { run_sweep(plan, {.checkpoint = other}); });
  };
  CHECK(refused([](Sweep& kept) {
          kept.generator = "samara 0.0.1";
        }).find("is of samara 0.0.1, expected one of samara ") != std::string::npos);
  CHECK(refused([](Sweep& kept) { kept.model_text += "C_Q [1] 0"; }).find("of another model") !=
        std::string::npos);
  // One that cannot be written is told, and does not end the sweep.
  std::vector<std::string> told;
  const SweepResult unkept =
      run_sweep(plan, {.progress = [](const samara::Progress& p) { return p.fraction < 0.5; },
                       .checkpoint = folder.path() / std::string(300, 'n'),
                       .warning = [&](const std::string& sentence) { told.push_back(sentence); }});
  CHECK(unkept.falls_done == cut.falls_done);
  REQUIRE(told.size() == 1);
  CHECK(told.front().find("no checkpoint: cannot write") == 0);
  const SweepResult resumed = run_sweep(plan, {.threads = 2, .checkpoint = checkpoint});
  CHECK(resumed.complete);
  CHECK(resumed.taken_up == cut.falls_done);
  CHECK_FALSE(std::filesystem::exists(checkpoint));
  check_same_falls(whole, resumed.sweep);
}

TEST_CASE("a finished sweep, as any other file, is no checkpoint: it is refused, and stays as it is") {
  const TemporaryDirectory folder;
  const SweepPlan plan = plates();
  const auto result = folder / "leaf.h5", part = folder / "leaf.part";
  Sweep sweep = run_sweep(plan).sweep;
  save(sweep, result);
  CHECK_FALSE(is_sweep_checkpoint(result));
  for (const auto& path : {result, folder.put("capture.csv", "t,z\n0,1\n")}) {
    const std::string before = content(path);
    const std::string sentence = path.string() + ": this is no checkpoint of a sweep, and would be lost";
    CHECK(error_text<samara::InputError>([&] { run_sweep(plan, {.checkpoint = path}); }).find(sentence) == 0);
    CHECK(error_text<samara::InputError>([&] {
            refine_by_plan(plan, {.checkpoint = path}, sweep);
          }).find(sentence) == 0);
    CHECK(content(path) == before);
  }
  save_checkpoint(sweep, part);
  check_same_falls(load_sweep(part), sweep);
  std::filesystem::copy_file(part, folder / "cut.part");
  std::filesystem::resize_file(folder / "cut.part", std::filesystem::file_size(part) / 2);
  CHECK(is_sweep_checkpoint(folder / "cut.part"));
  CHECK(run_sweep(plan, {.checkpoint = part}).taken_up == 36);
  CHECK_FALSE(std::filesystem::exists(part));
}

TEST_CASE("a sweep comes back from its file, trajectories as well, and damaged files are refused") {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "sweep.h5";
  const Sweep sweep = run_sweep(plates("keep = \"trajectories\"\n[labels]\nsteady_tilt = 0.25\n")).sweep;
  save(sweep, path);
  REQUIRE(is_sweep(path));
  const Sweep again = load_sweep(path);
  check_same_falls(sweep, again);
  CHECK(again.points == sweep.points);
  CHECK(again.axes == sweep.axes);
  CHECK(again.thresholds.steady_tilt == 0.25);
  CHECK(again.names == std::vector<std::string>{"inertia_ratio", "C_R"});
  CHECK(again.labels[3].why == sweep.labels[3].why);
  REQUIRE(again.trajectories.size() == sweep.trajectories.size());
  CHECK(again.trajectories[7] == sweep.trajectories[7]);
  CHECK(again.times[again.times.size() - 1] == Approx(120.0));
  CHECK(again.trajectories[7](0, 3) == Approx(40.0 * std::numbers::pi / 180.0));
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  CHECK_FALSE(is_sweep(path));
  CHECK_FALSE(error_text<samara::InputError>([&] { load_sweep(path); }).empty());
  CHECK(error_text<samara::InputError>([&] { load_sweep(folder.path() / "no.h5"); }).find("no.h5") !=
        std::string::npos);
}

TEST_CASE("a sweep of falls that landed keeps their trajectories as far as they go, in its file as well") {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "sweep.h5";
  const Sweep sweep = run_sweep(plates("height = 30\nkeep = \"trajectories\"\n")).sweep;
  save(sweep, path);
  const Sweep again = load_sweep(path);
  check_same_falls(sweep, again);
  REQUIRE(again.trajectories.size() == sweep.trajectories.size());
  for (std::size_t n = 0; n < again.trajectories.size(); ++n) {
    REQUIRE(sweep.status[n] == FallStatus::landed);
    for (Eigen::Index k = 0; k < again.times.size(); ++k) {
      const double x = again.trajectories[n](k, 4);
      CHECK(are_same(x, sweep.trajectories[n](k, 4)));
      CHECK(std::isfinite(x) == (again.times[k] <= sweep.reached[static_cast<Eigen::Index>(n)] + 1e-9));
    }
  }
}

TEST_CASE("the exponent of a fall does not depend on the falls that are run beside it") {
  const std::string body = R"(model = "immersed_body"
[fixed]
b = "2 cm"
c = "0.01 cm"
density = 1200
C_D0 = 0.05
C_w = 2
C_D90 = 0.61
C_T = 1.81
C_R = 1.21
[axes]
a = LENGTHS
[releases]
tilt = ["10 deg"]
[run]
until = "1 s"
step = "1 ms"
spread = true
)";
  const auto swept = [&](const std::string& lengths) {
    std::string text = body;
    text.replace(text.find("LENGTHS"), 7, lengths);
    return run_sweep(parse_sweep_plan(text, "body.toml")).sweep;
  };
  const Sweep alone = swept("[0.035]"), beside = swept("[0.021, 0.035]");
  const double exponent = alone.features[0][Feature::spread];
  REQUIRE(std::isfinite(exponent));
  CHECK(beside.features[1][Feature::spread] == exponent);
}

TEST_CASE("exponents are those of the model sheet, and a fall in a plane is disturbed within it") {
  const Sweep plane = run_sweep(plates("spread = true\n", "until = 120", "until = 600")).sweep;
  for (Eigen::Index n = 0; n < plane.fall_count(); ++n) {
    const Features& f = plane.features[static_cast<std::size_t>(n)];
    const double I = plane.points(plane.point_of(n), 0),
                 exponent = f[Feature::spread] / f[Feature::swing_time];
    if (plane.points(plane.point_of(n), 1) < 3.0) continue;
    INFO("I* " << I << ", exponent " << exponent);
    if (I >= 1.8) CHECK(exponent == Approx(0.12).margin(0.06));
    if (I <= 1.1) CHECK(std::abs(exponent) < 0.02);
  }
  const std::string card = R"(model = "immersed_body"
[fixed]
a = "3.5 cm"
b = "2 cm"
c = "0.01 cm"
density = 1200
C_D0 = 0.05
C_w = 2
C_T = 2.71
C_R = 0.91
[axes]
C_D90 = [0.61]
[releases]
tilt = ["10 deg"]
axis = ["0 deg", "35 deg"]
[run]
until = "4 s"
step = "1 ms"
settle = "2 s"
spread = true
)";
  const Sweep body = run_sweep(parse_sweep_plan(card, "card.toml")).sweep;
  CHECK(body.labels[0].pattern == Pattern::autorotation);
  CHECK(body.labels[1].pattern == Pattern::chaotic);
  CHECK(std::abs(body.features[0][Feature::spread]) < 0.05);
  CHECK(body.features[1][Feature::spread] > 0.1);
}

TEST_CASE("falls end on the ground, and where they land is counted by pattern") {
  const Sweep sweep = run_sweep(plates("height = 30\n", "until = 120", "until = 240")).sweep;
  int landed = 0;
  for (Eigen::Index n = 0; n < sweep.fall_count(); ++n) {
    if (sweep.status[static_cast<std::size_t>(n)] != FallStatus::landed) continue;
    ++landed;
    CHECK(sweep.landing(n, 2) <= sweep.reached[n]);
    CHECK(sweep.landing(n, 2) > sweep.reached[n] - 0.21);
    CHECK(sweep.landing(n, 1) == 0.0);
  }
  CHECK(landed == 36);
  double share = 0.0;
  int falls = 0;
  for (const LandingStatistics& s : landing_statistics(sweep, 1)) {
    share += s.share.value;
    // A share of all or nothing is not known for sure either.
    CHECK(s.share.upper - s.share.lower > 0.05);
    falls += s.falls;
    CHECK(s.distance >= std::abs(s.mean.x()) - 1e-12);
    if (s.falls > 1) CHECK(s.mean_error.x() == Approx(std::sqrt(s.covariance(0, 0) / s.falls)));
  }
  CHECK(share == Approx(1.0));
  CHECK(falls == 18);
  // One fall has no scatter, none no mean.
  Sweep few = sweep;
  few.landing.setConstant(NAN);
  few.landing.row(0) << 3.0, 4.0, 5.0;
  for (const LandingStatistics& s : landing_statistics(few, 0)) {
    CHECK(std::isnan(s.mean_error.x()));
    CHECK(std::isnan(s.distance_error));
    CHECK(std::isnan(s.covariance(0, 0)));
    CHECK(std::isnan(s.mean.x()) == (s.falls == 0));
    if (s.falls == 1) CHECK(s.distance == Approx(5.0));
  }
}

TEST_CASE("plans of sweeps that cannot be meant are refused with their line") {
  CHECK(refusal("inertia_ratio", "inertia_rato").find("sweep.toml:5: [axes] inertia_rato") == 0);
  CHECK(refusal("inertia_ratio", "inertia_rato").find("did you mean \"inertia_ratio\"") != std::string::npos);
  CHECK(refusal("from = 0.8", "from = 8").find("goes from 8 to 2.4, expected from < to") !=
        std::string::npos);
  CHECK(refusal("from = 0.8", "from = -1e70")
            .find("from: has the number -1e+70, expected at most 1e+60 in size") != std::string::npos);
  CHECK(refusal("from = 0.8", "from = -1").find("inertia_ratio") != std::string::npos);
  CHECK(refusal("count = 9", "count = 1").find("is 1, expected 2 to") != std::string::npos);
  CHECK(refusal("count = 9", "count = 9000000").find("expected at most 10000000") != std::string::npos);
  CHECK(refusal("[1.4, 3.14159]", "[3.0, 1.4]").find("expected them to increase") != std::string::npos);
  CHECK(refusal("settle = 60", "settle = 119").find("which leaves 5 frames") != std::string::npos);
  CHECK(refusal("settle = 60", "interval = 70").find("[run] interval: is 70, which leaves 0 frames") !=
        std::string::npos);
  CHECK(refusal("settle = 60", "settle = 60\n[refine]\nrounds = 10").find("falls") != std::string::npos);
  CHECK(error_text<samara::InputError>([] {
          plates("[sample]\ncount = 5\n[refine]\nrounds = 1\n",
                 "inertia_ratio = { from = 0.8, to = 2.4, count = 9 }\nC_R = [1.4, 3.14159]",
                 "inertia_ratio = { from = 0.8, to = 2.4 }\nC_R = { from = 1.4, to = 3.2 }");
        }).find("expected at least 8") != std::string::npos);
  CHECK(error_text<samara::InputError>([] {
          plates("[refine]\nrounds = 1\n", "count = 9", "count = 3");
        }).find("rounds: is 1 of a grid of 6 points, expected at least 8") != std::string::npos);
  CHECK(refusal("step = 0.05", "step = 0.05\ninterval = 1e-5").find("frames") != std::string::npos);
  CHECK(refusal("step = 0.05", "step = 0").find("is 0; more than 0 was expected") != std::string::npos);
  CHECK(refusal("falling_plate_nd", "vertical_fall").find("its motions have no patterns") !=
        std::string::npos);
  CHECK(refusal("beta = 0", "beta = 0\ntheta(0) = 1").find("sweep.toml:") == 0);
  CHECK(refusal("beta = 0", "beta = 0\n\"theta(0)\" = 1").find("stands beside theta(0)") !=
        std::string::npos);
  CHECK(refusal("tilt = [0.4, \"40 deg\"]", "tilt = [0.4]\naxis = [0.0]").find("axis") != std::string::npos);
  CHECK(
      refusal("settle = 60", "settle = 60\n[labels]\nsteady_tlit = 1").find("did you mean \"steady_tilt\"") !=
      std::string::npos);
}
