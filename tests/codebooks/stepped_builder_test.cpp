#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/codebooks/statistics/book_statistics.h"
#include "samara/models/integrators/integrate.h"
#include "same_codebook.h"
#include "sample_books.h"

// Codebooks of whole trajectories by Runge-Kutta steps.

using namespace samara::codebooks;
using Catch::Matchers::Contains;

namespace {

/// The reference plate over three coefficients, to its first swing.
std::string stepped_plate(const std::string& builder, const std::string& end = "2") {
  return "model = \"falling_plate_nd\"\n[box]\nC_T = [0.9, 1.3]\nC_R = [2.5, 3.3]\nA = [1.2, "
         "1.6]\n[time]\nend = " +
         end + "\n[tolerance]\nrelative = 1e-3\n[builder]\n" + builder;
}

const std::string kSteps = "kind = \"sampling\"\nstrategy = \"steps\"\n";

/// x ends near 1 or -1, whichever side of -bias it starts on: a front of width e^(-rate end) that moves with the bias.
std::string parting(const std::string& builder, const std::string& rates = "[3.8, 4]",
                    const std::string& relative = "1e-3") {
  return R"toml([equations]
name = "parting"
states.x = { initial = 0 }
parameters.bias = { default = 0 }
parameters.rate = { unit = "1/s", default = 4, above = 0 }
rates.x = "rate*(x - x^3 + bias)"
[box]
"x(0)" = [-1, 1]
bias = [-0.1, 0.1]
rate = )toml" +
         rates + R"toml(
[time]
end = 1
[tolerance]
relative = )toml" +
         relative + R"toml(
[builder]
)toml" + builder;
}

/// The same with a front 2e-4 wide, which moves by 0.2.
std::string narrowly_parting() {
  return parting(kSteps, "[8.4, 8.5]", "1e-2");
}

/// Where x stays: between the two places that it goes to otherwise.
double parting_place(double bias) {
  double x = -bias;
  for (int i = 0; i < 50; ++i) x = x * x * x - bias;
  return x;
}

BuildResult built_by_steps(const std::string& text, BuildOptions options = {.certificate_points = 200}) {
  return build(parse_plan(text, "plan.toml"), options);
}

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

TEST_CASE("nodes that a plan allows beyond those of polynomials are for elements") {
  const BuildResult result = built_by_steps(parting(kSteps + "max_nodes = 600\n"));
  INFO(result.message << "; " << result.book.build().message);
  CHECK(result.met);
  CHECK_THAT(result.book.build().message, Contains("elements along x(0)"));
}

TEST_CASE("a front that moves is followed by elements, by values, derivatives and means") {
  const BuildResult result = built_by_steps(parting(kSteps));
  INFO(result.message << "; " << result.book.build().message);
  CHECK(result.met);
  CHECK_THAT(result.book.build().message, Contains("elements along x(0)"));
  const TemporaryDirectory directory;
  save(result.book, directory / "parting.h5");
  const Codebook book = load(directory / "parting.h5");
  const samara::pgd::Axis& axis = book.pieces().front().groups().front().axes()[1];
  CHECK(axis.elements() > 2);
  const Eigen::VectorXd& borders = axis.borders();
  const Eigen::VectorXd sizes = borders.tail(axis.elements()) - borders.head(axis.elements());
  CHECK(sizes.maxCoeff() > 3.0 * sizes.minCoeff());

  // Points of our own about the front, where the certificate has few. Slopes there are about e^(rate end) = 50; those of
  // a polynomial err by its error times the square of its degree over half of an element.
  const samara::models::ParametricModel model = model_of(book);
  Query query(book);
  samara::pgd::Random random(29);
  Eigen::VectorXd value(1), ahead(1), behind(1);
  Eigen::MatrixXd gradient(1, 4);
  double worst = 0.0, worst_slope = 0.0, steepest = 0.0;
  for (int j = 0; j < 500; ++j) {
    const double bias = -0.1 + 0.2 * random.uniform();
    const std::vector<double> x = {1.0, -bias + 0.2 * (random.uniform() - 0.5), bias,
                                   3.8 + 0.2 * random.uniform()};
    const auto exact_at = [&](double start) {
      const std::vector<double> q = {start, x[2], x[3]};
      return samara::models::integrate(model, q, std::vector<double>{1.0}).states(0, 0);
    };
    query.values(x, value, gradient);
    worst = std::max(worst, std::abs(value[0] - exact_at(x[1])));
    constexpr double kStep = 1e-5;
    const double slope = (exact_at(x[1] + kStep) - exact_at(x[1] - kStep)) / (2.0 * kStep);
    steepest = std::max(steepest, std::abs(slope));
    worst_slope = std::max(worst_slope, std::abs(gradient(0, 1) - slope));
  }
  CHECK(worst <= 1e-3 * result.book.certificate()->outputs.front().range);
  CHECK(steepest > 20.0);
  CHECK(worst_slope <= 64.0 * worst / (0.5 * sizes.minCoeff()));

  // Turned round, the box and the motion are the same: means vanish.
  const BookStatistics statistics = take_statistics(book);
  CHECK(statistics.outputs.front().mean.cwiseAbs().maxCoeff() <= 1e-3);
  CHECK(statistics.inputs.size() == 3);
}

TEST_CASE("a coordinate is counted from a front that elements do not follow, and the codebook is met") {
  const BuildResult result = built_by_steps(narrowly_parting());
  const BuildRecord& record = result.book.build();
  INFO(result.message << "; " << record.message);
  CHECK(result.met);
  CHECK_THAT(record.message, Contains("; x(0) is counted from a front"));
  CHECK(record.grid_size <= 10'000.0);
  const FrontMap* front = result.book.front();
  REQUIRE(front != nullptr);
  CHECK(front->coordinate() == 1);

  // Points of our own about the front, where the certificate has none.
  const samara::models::ParametricModel model = model_of(result.book);
  Query query(result.book);
  samara::pgd::Random random(29);
  Eigen::VectorXd value(1);
  double worst = 0.0, worst_place = 0.0;
  int in_front = 0;
  for (int j = 0; j < 500; ++j) {
    const double bias = -0.1 + 0.2 * random.uniform(), rate = 8.4 + 0.1 * random.uniform();
    const double width = std::exp(-rate), place = parting_place(bias);
    const std::vector<double> x = {1.0, place + 4.0 * width * (2.0 * random.uniform() - 1.0), bias, rate};
    const std::vector<double> q = {x[1], x[2], x[3]};
    const double exact = samara::models::integrate(model, q, std::vector<double>{1.0}).states(0, 0);
    query.values(x, value);
    worst = std::max(worst, std::abs(value[0] - exact));
    worst_place = std::max(worst_place, std::abs(front->front_at(x.data()) - place) / width);
    if (std::abs(exact) < 0.7) ++in_front;
  }
  CHECK(in_front > 50);
  CHECK(worst <= 1e-2 * result.book.certificate()->outputs.front().range);
  CHECK(worst_place <= 0.5);
}

TEST_CASE("a coordinate is a coordinate where polynomials or elements follow all fronts") {
  CHECK(built_by_steps(stepped_plate(kSteps)).book.front() == nullptr);
  CHECK(built_by_steps(parting(kSteps)).book.front() == nullptr);
}

TEST_CASE("a build over elements that is killed and resumed equals an undisturbed one") {
  const std::string plan = GENERATE(parting(kSteps), narrowly_parting());
  const TemporaryDirectory directory;
  const std::filesystem::path checkpoint = directory / "book.h5.checkpoint";
  const BuildResult undisturbed = built_by_steps(plan, {.certificate_points = 50});
  struct Killed {};
  BuildOptions options{.certificate_points = 50, .checkpoint = checkpoint};
  int left = 3;  // reports after there is a state
  options.progress = [&](const samara::Progress&) {
    if (std::filesystem::exists(checkpoint) && --left < 0) throw Killed();
    return true;
  };
  CHECK_THROWS_AS(built_by_steps(plan, options), Killed);
  options.resume = true;
  options.progress = {};
  const Codebook resumed = built_by_steps(plan, options).book;
  check_same_but_provenance(resumed, undisturbed.book);
  REQUIRE((resumed.front() == nullptr) == (undisturbed.book.front() == nullptr));
  if (resumed.front()) CHECK(same_bits(resumed.front()->place(), undisturbed.book.front()->place()));
}

TEST_CASE(
    "elements that err between the lines that made them are halved, and a killed build halves them again") {
  // y has a front at x(0) = 0 in a small part of the box, which few lines cross. It is a polynomial of the others, for
  // which more nodes are of no use. x does not count. The seed is one whose lines see too little.
  const std::string plan = R"toml([equations]
name = "rare_front"
states.x = { initial = 0 }
states.y = { initial = 0 }
parameters.a = { default = 0.5 }
parameters.b = { default = 0.5 }
parameters.c = { default = 0.5 }
rates.x = "6*(x - x^3)"
rates.y = "(64*a*(1 - a)*b*(1 - b)*c*(1 - c))^8 * x"
[box]
"x(0)" = [-1, 0.9]
a = [0, 1]
b = [0, 1]
c = [0, 1]
[time]
end = 1
[tolerance]
relative = 1e-3
absolute = { x = 1e6 }
[builder]
seed = 30
)toml" + kSteps;
  const BuildResult undisturbed = built_by_steps(plan);
  INFO(undisturbed.message << "; " << undisturbed.book.build().message);
  CHECK(undisturbed.met);
  CHECK(undisturbed.book.build().rounds > 1);
  CHECK_THAT(undisturbed.book.build().message, Contains("elements along x(0)"));

  const TemporaryDirectory directory;
  const std::filesystem::path checkpoint = directory / "book.h5.checkpoint";
  struct Killed {};
  BuildOptions options{.certificate_points = 200, .checkpoint = checkpoint};
  options.progress = [&](const samara::Progress& report) {
    if (report.stage == "certificate") throw Killed();
    return true;
  };
  CHECK_THROWS_AS(built_by_steps(plan, options), Killed);
  options.resume = true;
  options.progress = {};
  check_same_but_provenance(built_by_steps(plan, options).book, undisturbed.book);
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
