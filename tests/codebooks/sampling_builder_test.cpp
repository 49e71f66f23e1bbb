#include <cmath>
#include <optional>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/models/integrators/integrate.h"
#include "samara/pgd/tensors/random.h"
#include "same_codebook.h"
#include "sample_books.h"

// Codebooks built by sampling, and the choice of a builder.

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;

namespace {

/// The plan of the coin with other words for its builder.
std::string coin_plan_of(const std::string& builder) {
  const std::string& text = coin_plan();
  return text.substr(0, text.find("[builder]")) + "[builder]\n" + builder;
}

/// A corner of the plate's box, and its first swing.
const std::string kPlate = R"toml(model = "falling_plate_nd"
[box]
C_T = [1.1, 1.3]
C_R = [2.9, 3.3]
A = [1.3, 1.5]
[time]
end = 2
[tolerance]
relative = 1e-3
[builder]
kind = "sampling"
)toml";

BuildResult built(const std::string& text, BuildOptions options = {.certificate_points = 200}) {
  return build(parse_plan(text, "plan.toml"), options);
}

const BuildResult& sampled_coin() {
  static const BuildResult result = built(coin_plan_of("kind = \"sampling\"\n"));
  return result;
}

/// Largest error at random points and 40 times, in the certificate's measure, by the test's own integrations.
double own_error(const Codebook& book, int points, unsigned seed) {
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

void check_sampled(const BuildResult& result, double tolerance) {
  INFO(result.message << "; " << result.book.build().message);
  CHECK(result.met);
  const BuildRecord& record = result.book.build();
  CHECK(record.builder == "sampling");
  CHECK(record.strategy == "cross");
  CHECK(record.status == samara::Termination::converged);
  CHECK(record.iterations == 0);
  CHECK(record.rounds > 0);
  // Fewer trajectories than points of the grid, of which each has all nodes of time.
  const FieldGroup& group = result.book.pieces().front().groups().front();
  REQUIRE(group.train() != nullptr);
  CHECK(record.evaluations > 0.0);
  const ErrorBudget& spent = result.book.certificate()->spent;
  CHECK(spent.discretisation <= 0.1 * tolerance);
  CHECK(spent.compression > 0.0);
  CHECK(spent.compression <= 0.6 * tolerance);  // of the cross 0.5, of rounding 0.1
  CHECK(own_error(result.book, 100, 17) <= tolerance);
}

}  // namespace

TEST_CASE("a sampled fall agrees with direct integration") {
  check_sampled(sampled_coin(), 1e-3);
  CHECK(sampled_coin().book.coordinates()[2].role == samara::pgd::AxisRole::initial);
  CHECK(sampled_coin().book.outputs()[1].unit == "m");
}

TEST_CASE("a sampled plate agrees with direct integration") {
  const BuildResult result = built(kPlate);
  check_sampled(result, 1e-3);
  CHECK(result.book.output_count() == 6);
}

TEST_CASE("both builders agree within the sum of their certificates") {
  Query sampled(sampled_coin().book), solved(coin_build().book);
  Eigen::VectorXd a(2), b(2);
  const Eigen::MatrixXd points = random_points(coin_build().book, 500, 3);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(2);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    sampled.values(point(points, j), a);
    solved.values(point(points, j), b);
    largest = largest.cwiseMax((a - b).cwiseAbs());
  }
  for (std::size_t o = 0; o < 2; ++o) {
    // The points are not those of the certificates: perhaps a little more.
    CHECK(largest[static_cast<Eigen::Index>(o)] <=
          1.5 * (sampled_coin().book.certificate()->outputs[o].max_si +
                 coin_build().book.certificate()->outputs[o].max_si));
  }
}

TEST_CASE("a sampled codebook has the derivatives of its own values, and nearly those of the trajectories") {
  const Codebook& book = sampled_coin().book;
  Query query(book);
  Eigen::VectorXd values(2), left(2), right(2);
  Eigen::MatrixXd gradient(2, 3);
  std::vector<double> x = {0.31, 1.1, 0.12};
  query.values(x, values, gradient);
  for (std::size_t k = 0; k < 3; ++k) {
    // Central differences of polynomials with third derivatives up to some 1e4.
    constexpr double kStep = 1e-5;
    std::vector<double> lower = x, upper = x;
    lower[k] -= kStep;
    upper[k] += kStep;
    query.values(lower, left);
    query.values(upper, right);
    const Eigen::VectorXd difference = (right - left) / (2.0 * kStep);
    CHECK((gradient.col(static_cast<Eigen::Index>(k)) - difference).cwiseAbs().maxCoeff() < 1e-6);
  }
  const auto exact =
      samara::models::integrate(model_of(book), std::vector{x[1], x[2]}, std::vector{x[0]}, {}, true);
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::VectorXd sensitivity = exact.sensitivities[k].row(0).transpose();
    CHECK((gradient.col(static_cast<Eigen::Index>(k) + 1) - sensitivity).cwiseAbs().maxCoeff() < 0.02);
  }
}

TEST_CASE("a trajectory query of a sampled codebook answers as a query does") {
  const Codebook& book = sampled_coin().book;
  const std::vector<double> times = {0.0, 0.07, 0.25, 0.5};
  TrajectoryQuery trajectory(book, times);
  Query query(book);
  Eigen::MatrixXd values(4, 2), derivatives(4, 4), gradient(2, 3);
  Eigen::VectorXd at_time(2);
  trajectory.values(std::vector{1.3, 0.2}, values, derivatives);
  for (Eigen::Index i = 0; i < 4; ++i) {
    query.values(std::vector{times[static_cast<std::size_t>(i)], 1.3, 0.2}, at_time, gradient);
    // The same products in another order, of numbers below 10.
    CHECK((values.row(i).transpose() - at_time).cwiseAbs().maxCoeff() < 1e-13);
    for (Eigen::Index k = 0; k < 2; ++k) {
      CHECK((derivatives.row(i).segment(2 * k, 2).transpose() - gradient.col(k + 1)).cwiseAbs().maxCoeff() <
            1e-12);
    }
  }
}

TEST_CASE("a build by sampling that may not integrate more ends with the status max_calls") {
  for (const int calls : {90, 110}) {
    const BuildResult result =
        built(coin_plan_of("kind = \"sampling\"\nmax_calls = " + std::to_string(calls)),
              {.certificate_points = 20});
    INFO(calls << ": " << result.message);
    CHECK_FALSE(result.met);
    CHECK(result.book.build().status == samara::Termination::max_calls);
    CHECK(result.book.build().evaluations <= calls);
    CHECK_THAT(result.message, Contains("allowed were used") && Contains("largest error "));
    const TemporaryDirectory directory;
    save(result.book, directory / "book.h5");
    check_same_codebook(load(directory / "book.h5"), result.book);
  }
}

TEST_CASE("a build by sampling without a single trajectory has no result, and says at which point") {
  // More steps than the integrator takes.
  std::string plan = kPlate;
  plan.replace(plan.find("end = 2"), 7, "end = 1e5");
  CHECK_THAT(error_text<samara::NoResultError>([&] { built(plan, {.certificate_points = 1}); }),
             Contains("no trajectory at C_T = 1.1, C_R = 2.9, A = 1.3: ") && Contains("steps"));
  const std::string hungry = coin_plan_of("kind = \"sampling\"\nmax_calls = 1\n");
  CHECK_THAT(error_text<samara::NoResultError>([&] { built(hungry, {}); }), Contains("of the 1 allowed"));
}

TEST_CASE("the number of threads changes no byte of a build by sampling outside the provenance") {
  const TemporaryDirectory directory;
  for (const std::string threads : {"1", "2"}) {
    const Codebook book = built(kPlate + "threads = " + threads + "\n", {.certificate_points = 50}).book;
    save(Codebook(book.model(), book.pieces(), book.build(), {}, book.certificate(), book.title()),
         directory / threads);
  }
  CHECK(content(directory / "1") == content(directory / "2"));
}

TEST_CASE(
    "a build by sampling that is cancelled says so and asks no more, and has a result once it has a field") {
  for (const std::string stage : {"pilots", "sampling", "certificate"}) {
    bool cancelled = false;
    int reports_after = 0;
    const BuildOptions options{.certificate_points = 50, .progress = [&](const samara::Progress& report) {
                                 if (cancelled) ++reports_after;
                                 cancelled = cancelled || report.stage == stage;
                                 return !cancelled;
                               }};
    const std::string plan = coin_plan_of("kind = \"sampling\"\n");
    INFO(stage);
    if (stage != "certificate") {
      CHECK_THAT(error_text<samara::NoResultError>([&] { built(plan, options); }), Contains("cancelled"));
      CHECK(reports_after == 0);
      continue;
    }
    const BuildResult result = built(plan, options);
    CHECK(cancelled);
    CHECK(reports_after == 0);
    CHECK_FALSE(result.met);
    CHECK(result.message == "the build was cancelled; its certificate covers 0 of 50 points");
    CHECK(result.book.build().status == samara::Termination::converged);
  }
}

TEST_CASE("a build by sampling that is killed again and again ends in the same codebook") {
  struct Killed {};
  // Of the kind auto the trial misses, and the engine has its own part of the checkpoint.
  for (const std::string builder : {"kind = \"sampling\"\n", "kind = \"auto\"\nmax_calls = 120\n"}) {
    const TemporaryDirectory directory;
    const std::string plan = coin_plan_of(builder);
    BuildOptions options{.certificate_points = 20, .checkpoint = directory / "c", .resume = true};
    const Codebook whole = built(plan, {.certificate_points = 20}).book;
    samara::pgd::Random random(11);
    int kills = 0;
    std::optional<BuildResult> result;
    while (!result) {
      int reports = kills < 12 ? 1 + random.below(4 + 4 * kills) : 1'000'000;
      options.progress = [&](const samara::Progress&) -> bool {
        return --reports > 0 ? true : throw Killed();
      };
      try {
        result = built(plan, options);
      } catch (const Killed&) {
        ++kills;
      }
    }
    INFO(builder << kills << " kills");
    CHECK(kills >= 3);
    check_same_but_provenance(result->book, whole);
    CHECK_FALSE(std::filesystem::exists(options.checkpoint));
  }
}

TEST_CASE("a build by sampling that was cancelled leaves its calls, which are not made again") {
  const TemporaryDirectory directory;
  const std::string plan = coin_plan_of("kind = \"sampling\"\n");
  BuildOptions options{.certificate_points = 20, .checkpoint = directory / "c"};
  options.progress = [](const samara::Progress& report) { return report.stage != "certificate"; };
  const BuildResult cancelled = built(plan, options);
  CHECK(cancelled.resumable);
  const std::vector<CallSheet> calls = Checkpoint(options.checkpoint, plan).calls();
  std::size_t count = 0;
  for (const CallSheet& sheet : calls) count += sheet.points.size() / 2;
  // Corners may be called on the grid and off it.
  CHECK(static_cast<double>(count) <= cancelled.book.build().evaluations);
  CHECK(static_cast<double>(count) >= cancelled.book.build().evaluations - 4.0);
  // As many calls as there are, all of them known: none is made, and the same codebook comes out.
  options.progress = {};
  options.resume = true;
  const BuildResult resumed = built(plan, options);
  check_same_but_provenance(resumed.book, built(plan, {.certificate_points = 20}).book);
}

TEST_CASE("a checkpoint that is none, or holds calls of another box, is refused") {
  const TemporaryDirectory directory;
  const std::string plan = coin_plan_of("kind = \"sampling\"\n");
  const BuildOptions options{.certificate_points = 20, .checkpoint = directory / "c", .resume = true};
  put_content(options.checkpoint, "state");
  CHECK_THAT(error_text<samara::InputError>([&] { built(plan, options); }),
             Contains("this is no checkpoint of a build or a cloud"));
  std::filesystem::remove(options.checkpoint);
  Checkpoint(options.checkpoint, "another plan").save_calls({{{}, {1.0, 2.0}, {3.0}}});
  CHECK_THAT(error_text<samara::InputError>([&] { built(plan, options); }),
             EndsWith("--fresh begins anew, and removes it"));
  Checkpoint(options.checkpoint, plan).save_calls({{{0.0, 0.1}, {1.0, 2.0}, {3.0}}});
  CHECK_THAT(error_text<samara::InputError>([&] { built(plan, options); }),
             Contains("other coordinates or outputs than the plan"));
}

TEST_CASE("calls and the engine's state keep each other in one checkpoint") {
  const TemporaryDirectory directory;
  const auto file = directory / "c";
  const std::vector<CallSheet> calls = {{{}, {1.0, 2.0, 3.0, 4.0}, {5.0, 6.0}, 0.25},
                                        {{0.0, 0.5}, {7.0, 8.0}, {9.0, 10.0}, 61.0}};
  Checkpoint of_calls(file, "plan"), of_march(file, "plan");
  of_calls.save_calls({calls[0]});
  CHECK(Checkpoint(file, "plan").march().empty());
  const std::vector<double> state = {17.0, 1.0 / 3.0};
  of_march.save_march(state);
  of_calls.save_calls(calls);
  CHECK(of_march.march() == state);
  const std::vector<CallSheet> loaded = of_march.calls();
  REQUIRE(loaded.size() == 2);
  for (std::size_t s = 0; s < 2; ++s) {
    CHECK(loaded[s].times == calls[s].times);
    CHECK(loaded[s].points == calls[s].points);
    CHECK(loaded[s].values == calls[s].values);
    CHECK(loaded[s].seconds == calls[s].seconds);
  }
  Checkpoint another(file, "another");  // whose state this is not
  another.save_calls(calls);
  CHECK(another.march().empty());
  // Of a build that begins anew, which has asked for something else.
  Checkpoint(file, "another").save_calls({{{}, {1.0, 2.5}, {5.5}, 0.25}});
  CHECK(another.calls()[0].points == std::vector<double>{1.0, 2.5});
}

TEST_CASE("the kind auto chooses sampling where its trial suffices, and says why") {
  const BuildResult result = built(coin_plan_of("kind = \"auto\"\n"));
  CHECK(result.met);
  CHECK(result.book.build().builder == "sampling");
  CHECK_THAT(result.book.build().message, Contains("chosen because it needed no more than"));
  check_same_group(result.book.pieces()[0].groups()[0], sampled_coin().book.pieces()[0].groups()[0]);
}

TEST_CASE(
    "the kind auto chooses the engine where a plan prescribes an axis, and says where neither suffices") {
  const std::string start = "model = \"constant_rate\"\n[box]\n";
  const std::string end = "[time]\nend = 1\n[tolerance]\nrelative = 1e-6\n";
  const BuildResult prescribed = built(start + "k = { range = [2, 5], nodes = 12 }\n" + end);
  CHECK(prescribed.met);
  CHECK(prescribed.book.build().builder == "pgd");
  CHECK_THAT(prescribed.book.build().message, Contains("chosen because the plan prescribes an axis"));
  const BuildResult neither = built(coin_plan_of("kind = \"auto\"\nmax_calls = 80\n"));
  CHECK_FALSE(neither.met);
  CHECK(neither.book.build().builder == "sampling");
  CHECK(neither.book.build().status == samara::Termination::max_calls);
  CHECK(neither.book.build().evaluations <= 80);
  CHECK_THAT(neither.book.build().message, Contains("chosen because neither builder converged in its trial"));
}

TEST_CASE("where the engine cannot solve a plan, what sampling found is not lost") {
  // A body with all its velocities free: the rates are more products than the engine holds.
  const std::string plan =
      "model = \"kirchhoff_body\"\n[fixed]\nmass = 1\nI_xx = 1\nI_yy = 2\nI_zz = 2.5\nr_cz = -0.05\n"
      "displaced_mass = 0.9\n[box]\n\"qx(0)\" = [-0.4, 0.4]\n\"qy(0)\" = [-0.4, 0.4]\n\"uz(0)\" = [-1, 1]\n"
      "\"wx(0)\" = [-1, 1]\n\"wy(0)\" = [-1, 1]\n\"wz(0)\" = [-1, 1]\n[time]\nend = 0.5\n[builder]\n";
  const BuildResult result = built(plan + "kind = \"auto\"\nmax_calls = 600\n", {.certificate_points = 20});
  CHECK_FALSE(result.met);
  CHECK(result.book.build().builder == "sampling");
  CHECK(result.book.build().status == samara::Termination::max_calls);
  CHECK_THAT(result.book.build().message, Contains("neither builder converged"));
}

TEST_CASE("a plan of sampling that prescribes nodes, a basis, a strategy or cells is refused with its line") {
  const auto refused = [](const std::string& entry, const std::string& builder = "") {
    return error_text<samara::InputError>([&] {
      parse_plan("model = 'constant_rate'\n[box]\nk = " + entry +
                     "\n[time]\nend = 1\n[builder]\nkind = 'sampling'\n" + builder,
                 "p.toml");
    });
  };
  CHECK(refused("{ range = [1, 2], transform = 'log' }") == "no exception");
  CHECK(refused("{ range = [1, 2], nodes = 9 }") ==
        "p.toml:3: [box] k: prescribes nodes, but the builder of kind \"sampling\" chooses that by itself");
  CHECK_THAT(refused("{ range = [1, 2], basis = 'legendre' }"), Contains("[box] k: prescribes a basis"));
  CHECK_THAT(refused("[1, 2]", "strategy = 'newton'\n"),
             Contains("[builder] strategy: is \"newton\", which is one of the builder \"pgd\""));
  CHECK_THAT(refused("[1, 2]", "max_cells = 5\n"), Contains("[builder] max_cells: is 5"));
  CHECK_THAT(refused("[1, 2]", "max_nodes = 129\n"),
             Contains("[builder] max_nodes: is 129, expected at most 128"));
  CHECK_THAT(refused("[1, 2]", "max_nodes = 5\n"), Contains("expected 7 to 1000"));
}

TEST_CASE("a plan limits nodes and ranks of either builder, and says how many points it checks itself at") {
  const auto with = [](const std::string& kind, const std::string& limits) {
    return built(
        "model = \"falling_plate_nd\"\n[fixed]\ninertia_ratio = 1.1\n\"w(0)\" = 0.001\n[box]\n"
        "C_T = [0.9, 1.4]\nC_R = [2.5, 3.5]\nA = [1.2, 1.6]\n[time]\nend = 4\n[tolerance]\n"
        "relative = 1e-4\n[builder]\nkind = \"" +
            kind + "\"\n" + limits,
        {.certificate_points = 50});
  };
  const auto largest = [](const Codebook& book) {
    std::pair<int, int> nodes_and_rank;
    for (const Piece& piece : book.pieces()) {
      const PieceOutline outline = piece.outline();
      for (std::size_t k = 1; k < outline.axes.size(); ++k)
        nodes_and_rank.first = std::max(nodes_and_rank.first, outline.axes[k].size());
      // Between outputs and time there is one of each output.
      for (const GroupOutline& group : outline.groups)
        for (std::size_t k = 1; k < group.ranks.size(); ++k)
          nodes_and_rank.second = std::max(nodes_and_rank.second, group.ranks[k]);
    }
    return nodes_and_rank;
  };
  const auto [nodes, rank] = largest(with("sampling", "").book);
  CAPTURE(nodes, rank);
  REQUIRE((nodes > 7 && rank > 4));
  CHECK(largest(with("sampling", "max_nodes = 7\n").book).first <= 7);
  CHECK(largest(with("sampling", "max_rank = 4\n").book).second <= 4);
  const BuildResult plain = with("pgd", ""), few = with("pgd", "max_rank = 4\n"),
                    guarded = with("pgd", "guards = 300\n");
  REQUIRE(plain.met);
  CHECK_FALSE(few.met);
  CHECK(guarded.met);
  CHECK(guarded.book.build().evaluations > plain.book.build().evaluations);
}
