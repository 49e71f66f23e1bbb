#include "samara/codebooks/build/stepped_builder.h"

#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/codebooks/book/book_model.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/models/integrators/integrate.h"
#include "same_codebook.h"
#include "sample_books.h"
#include "stepped_builds.h"

// Codebooks of whole trajectories by Runge-Kutta steps.

using namespace samara::codebooks;
using Catch::Matchers::Contains;

namespace {

/// Largest error at random points, over the ranges of the certificate, against the reference integrator.
double error_of_steps(const Codebook& book, int points, unsigned seed) {
  const samara::models::ParametricModel model = model_of(book);
  const Eigen::MatrixXd x = random_points(book, points, seed);
  std::vector<double> times;
  for (int i = 0; i <= 40; ++i) times.push_back(book.coordinates().front().upper * i / 40.0);
  TrajectoryQuery query(book, times);
  Eigen::MatrixXd values(static_cast<Eigen::Index>(times.size()), book.output_count());
  double worst = 0.0;
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    const auto q = point(x, j).subspan(1);
    const samara::models::Trajectory exact = samara::models::integrate(model, q, times);
    REQUIRE(exact.is_usable());
    query.values(q, values);
    for (int o = 0; o < book.output_count(); ++o) {
      worst = std::max(worst, (values.col(o) - exact.states.col(o)).cwiseAbs().maxCoeff() /
                                  book.certificate()->outputs[static_cast<std::size_t>(o)].range);
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("a codebook of trajectories by steps agrees with direct integration, and says what it took") {
  const BuildResult result = built_by_steps(stepped_plate(kSteps));
  const BuildRecord& record = result.book.build();
  INFO(result.message << "; " << record.message);
  CHECK(result.met);
  CHECK(record.builder == "sampling");
  CHECK(record.strategy == "steps");
  CHECK(record.status == samara::Termination::converged);
  CHECK(record.evaluations > 0.0);
  const FieldGroup& group = result.book.pieces().front().groups().front();
  REQUIRE(group.train() != nullptr);
  double grid = 1.0;
  for (std::size_t k = 1; k < group.axes().size(); ++k) grid *= group.axes()[k].size();
  CHECK(record.grid_size == grid);
  CHECK(result.book.certificate()->spent.discretisation <= 0.1 * 1e-3);
  CHECK(error_of_steps(result.book, 100, 17) <= 1e-3);
}

TEST_CASE("free initial values and axes under a transform are stepped, too") {
  const BuildResult result = built_by_steps(
      "model = \"falling_plate_nd\"\n[box]\nC_T = { range = [0.5, 2], transform = \"log\" }\nC_R = [2.5, "
      "3.3]\n"
      "\"theta(0)\" = [0.3, 0.5]\n\"w(0)\" = [-0.1, 0.1]\n[time]\nend = 1\n[tolerance]\nrelative = "
      "1e-4\n[builder]\n" +
      kSteps);
  INFO(result.message << "; " << result.book.build().message);
  CHECK(result.met);
  CHECK(result.book.coordinates()[3].role == samara::pgd::AxisRole::initial);
  CHECK(result.book.pieces().front().groups().front().axes()[1].transform() ==
        samara::pgd::Transform::logarithm);
  CHECK(error_of_steps(result.book, 50, 5) <= 1e-4);
}

TEST_CASE("the number of threads changes no byte of a build by steps outside the provenance") {
  const TemporaryDirectory directory;
  for (const std::string threads : {"1", "2"}) {
    const Codebook book =
        built_by_steps(stepped_plate(kSteps + "threads = " + threads + "\n"), {.certificate_points = 50})
            .book;
    save(Codebook(book.model(), book.pieces(), book.build(), {}, book.certificate(), book.title()),
         directory / threads);
  }
  CHECK(content(directory / "1") == content(directory / "2"));
}

TEST_CASE("the kind auto takes steps for more than two coordinates, and says why") {
  const BuildResult result = built_by_steps(stepped_plate("kind = \"auto\"\n"));
  INFO(result.message << "; " << result.book.build().message);
  CHECK(result.met);
  CHECK(result.book.build().strategy == "steps");
  CHECK_THAT(result.book.build().message, Contains("chosen because trajectories by steps met the tolerance"));
}

TEST_CASE("steps are halved where the first are so long that a trajectory overflows") {
  const BuildResult result = build(parse_plan(R"toml(model = "immersed_body"
[fixed]
a = "3.5 cm"
b = "2 cm"
c = "0.1 mm"
density = 1200
C_D0 = 0.05
C_w = 2
"qw(0)" = 0.996194698
"qx(0)" = 0.05
"qy(0)" = 0.0711
[box]
C_D90 = [0.249, 0.251]
C_T = [0.729, 0.731]
C_R = [0.719, 0.721]
[time]
end = 0.9
[tolerance]
relative = 1e-2
[builder]
kind = "sampling"
strategy = "steps"
)toml",
                                              "plan.toml"),
                                   {.certificate_points = 50});
  INFO(result.message);
  CHECK(result.met);
}

TEST_CASE("steps that may not integrate enough have no result, and leave the kind auto to the others") {
  CHECK_THAT(error_text<samara::NoResultError>(
                 [&] { built_by_steps(stepped_plate(kSteps + "max_calls = 1000\n")); }),
             Contains("trajectories of the 1000 allowed"));
  const BuildResult few = built_by_steps(stepped_plate("kind = \"auto\"\nmax_calls = 1000\n"));
  INFO(few.message << "; " << few.book.build().message);
  CHECK(few.book.build().strategy != "steps");
}

TEST_CASE("too few ranks or nodes leave the best field, which says by how much it misses") {
  for (const auto& [limit, end] : {std::pair{"max_rank = 3\n", "6"}, {"max_nodes = 7\n", "12"}}) {
    const BuildResult result = built_by_steps(stepped_plate(kSteps + limit, end), {.certificate_points = 50});
    INFO(limit << result.book.build().message);
    CHECK_FALSE(result.met);
    CHECK(result.book.build().status == samara::Termination::exhausted);
    CHECK(result.book.certificate()->max_error > 1e-3);
    CHECK_THAT(result.book.build().message, Contains("allowed do not suffice; the best field errs by"));
    if (!std::string(limit).starts_with("max_nodes")) continue;
    CHECK_THAT(result.book.build().message,
               Contains("changes by its range within") && Contains(" nodes, and 7 err by"));
    CHECK(result.book.build().rounds == 1);
  }
}

TEST_CASE("a build by steps that is cancelled on the way has no result, once it has a field it keeps it") {
  for (const std::string stage : {"pilots", "lines", "coarse cross", "certificate"}) {
    bool cancelled = false;
    int reports_after = 0;
    const BuildOptions options{.certificate_points = 50, .progress = [&](const samara::Progress& report) {
                                 if (cancelled) ++reports_after;
                                 cancelled = cancelled || report.stage == stage;
                                 return !cancelled;
                               }};
    INFO(stage);
    if (stage != "certificate") {
      CHECK_THAT(error_text<samara::NoResultError>([&] { built_by_steps(stepped_plate(kSteps), options); }),
                 Contains("cancelled"));
    } else {
      CHECK_FALSE(built_by_steps(stepped_plate(kSteps), options).met);
    }
    CHECK(cancelled);
    CHECK(reports_after == 0);
  }
}

TEST_CASE("a field by steps that a certificate refutes is kept with the error that was found") {
  const Plan plan = parse_plan(stepped_plate(kSteps), "plan.toml");
  const samara::models::ParametricModel model = plan.parametric_model();
  bool is_refuted = false;
  const CertifyClaim refute = [&](const Piece&, double) {
    is_refuted = true;
    Measured measured;
    measured.certificate.max_error = 0.5;
    measured.wrong = Eigen::MatrixXd::Zero(3, 1);
    return measured;
  };
  const auto go_on = [&](const samara::Progress&) { return !is_refuted; };
  const auto solution = solve_by_steps(plan, model, 20'000'000, go_on, refute);
  REQUIRE(is_refuted);
  REQUIRE(solution);
  CHECK_THAT(solution->record.message, Contains("the best field errs by 0.5"));
  CHECK(solution->spent.compression >= 0.5);
}

TEST_CASE("where lines need more nodes than are allowed, the kind auto ends soon, with the reason") {
  const BuildResult result =
      built_by_steps(stepped_plate("kind = \"auto\"\nmax_nodes = 7\n", "12"), {.certificate_points = 50});
  INFO(result.message);
  CHECK_FALSE(result.met);
  CHECK_THAT(result.book.build().message, Contains("changes by its range within"));
}

TEST_CASE("a build by steps that is killed at any moment and resumed equals an undisturbed one") {
  const TemporaryDirectory directory;
  const std::filesystem::path checkpoint = directory / "book.h5.checkpoint";
  const std::string plan = stepped_plate(kSteps, "6");
  int whole = 0;
  const BuildResult undisturbed =
      built_by_steps(plan, {.certificate_points = 50, .progress = [&](const auto&) {
                              ++whole;
                              return true;
                            }});
  struct Killed {};
  std::set<std::string> states;
  for (int kill = 1; kill < whole; kill += 1 + whole / 12) {
    int left = kill;
    BuildOptions options{.certificate_points = 50, .checkpoint = checkpoint};
    options.progress = [&](const samara::Progress&) {
      if (--left < 0) throw Killed();
      return true;
    };
    CHECK_THROWS_AS(built_by_steps(plan, options), Killed);
    const bool has_state = std::filesystem::exists(checkpoint);
    if (has_state) states.insert(content(checkpoint));
    int reports = 0;
    options.resume = true;
    options.progress = [&](const samara::Progress&) {
      ++reports;
      return true;
    };
    const BuildResult resumed = built_by_steps(plan, options);
    INFO("killed at report " << kill << " of " << whole << ", went on with " << reports);
    check_same_but_provenance(resumed.book, undisturbed.book);
    CHECK(resumed.message == undisturbed.message);
    CHECK(directory.file_count() == 0);
  }
  CHECK(states.size() >= 2);
}

TEST_CASE("a state of steps that is of another kind of build is refused") {
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory / "checkpoint";
  const Plan plan = parse_plan(stepped_plate(kSteps), "plan.toml");
  Checkpoint(path, plan.whole_text()).save_steps({1.0, 2.0, 3.0});
  CHECK(Checkpoint(path, plan.whole_text()).steps() == std::vector<double>{1.0, 2.0, 3.0});
  CHECK_THAT(error_text<samara::InputError>([&] { build(plan, {.checkpoint = path, .resume = true}); }),
             Contains("--fresh begins anew"));
}

TEST_CASE("a state of steps with a number too many, other times or another grid is refused") {
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory / "checkpoint";
  const Plan plan = parse_plan(stepped_plate(kSteps), "plan.toml");
  struct Killed {};
  const auto until_kept = [&](const samara::Progress&) {
    if (std::filesystem::exists(path)) throw Killed();
    return true;
  };
  CHECK_THROWS_AS(build(plan, {.checkpoint = path, .progress = until_kept}), Killed);
  const std::vector<double> state = Checkpoint(path, plan.whole_text()).steps();
  REQUIRE(state.size() > 100);
  const auto refused = [&](const std::vector<double>& numbers) {
    std::filesystem::remove(path);
    Checkpoint(path, plan.whole_text()).save_steps(numbers);
    return error_text<samara::InputError>([&] { build(plan, {.checkpoint = path, .resume = true}); });
  };
  std::vector<double> longer = state;
  longer.push_back(0.0);
  CHECK_THAT(refused(longer), Contains("too long") && Contains("--fresh begins anew"));
  std::vector<double> other_times = state;  // how many, then the first
  other_times[1] += 1e-9;
  CHECK_THAT(refused(other_times), Contains("other times") && Contains("--fresh begins anew"));
}

TEST_CASE("steps are refused where there are no trajectories of a model to sample") {
  const auto refused = [](const std::string& builder) {
    return error_text<samara::InputError>([&] { parse_plan(stepped_plate(builder), "p.toml"); });
  };
  CHECK_THAT(refused("kind = \"pgd\"\nstrategy = \"steps\"\n"),
             Contains("[builder] strategy: is \"steps\", which is one of the builder \"sampling\""));
  CHECK_THAT(refused("strategy = \"steps\"\n"), Contains("[builder] strategy: is \"steps\""));
  CHECK_THAT(refused(kSteps + "max_cells = 2\n"), Contains("[builder] max_cells: is 2"));
}
