#include "samara/codebooks/build/build.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>
#include <tbb/task_arena.h>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/codebooks/build/effort.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/models/integrators/integrate.h"
#include "samara/pgd/evolution/slab_evolution.h"
#include "same_codebook.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// By the PGD engine, which is the subject here.
BuildResult built(const std::string& text, BuildOptions options = {.certificate_points = 500}) {
  Plan plan = parse_plan(text, "plan.toml");
  plan.builder.kind = "pgd";
  return build(plan, options);
}

/// The coin, marched.
std::string in_slabs() {
  return coin_plan() + "strategy = 'slabs'\n";
}

/// Vertical fall of a coin-like body to 1e-3.
std::string fall_plan(const std::string& fixed, const std::string& box, const std::string& end = "0.5",
                      const std::string& relative = "1e-3") {
  return "model = 'vertical_fall'\n[fixed]\n" + fixed + "[box]\n" + box + "[time]\nend = " + end +
         "\n[tolerance]\nrelative = " + relative + "\n";
}

/// Errors against integrations of the test's own, at random points and times that no certificate saw.
struct OwnCheck {
  Eigen::VectorXd max_error, rms;  ///< in the certificate's measures
};

OwnCheck own_check(const Codebook& book, int points, unsigned seed) {
  const samara::models::ParametricModel model = model_of(book);
  const Eigen::MatrixXd x = random_points(book, points, seed);
  std::vector<double> times;
  for (int i = 0; i <= 60; ++i) times.push_back(book.coordinates().front().upper * i / 60.0);
  const auto outputs = static_cast<Eigen::Index>(book.output_count());
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(outputs), error2 = largest, value2 = largest;
  Query query(book);
  Eigen::VectorXd values(outputs);
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    const auto q = point(x, j).subspan(1);
    const samara::models::Trajectory trajectory = samara::models::integrate(model, q, times);
    REQUIRE(trajectory.is_usable());
    for (std::size_t i = 0; i < times.size(); ++i) {
      std::vector<double> at(q.begin(), q.end());
      at.insert(at.begin(), times[i]);
      query.values(at, values);
      const Eigen::VectorXd state = trajectory.states.row(static_cast<Eigen::Index>(i)).transpose();
      largest = largest.cwiseMax((values - state).cwiseAbs());
      error2 += (values - state).cwiseAbs2();
      value2 += state.cwiseAbs2();
    }
  }
  OwnCheck check;
  check.max_error = largest;
  check.rms = (error2.array() / value2.array()).sqrt();
  for (Eigen::Index o = 0; o < outputs; ++o)
    check.max_error[o] /= book.certificate()->outputs[static_cast<std::size_t>(o)].range;
  return check;
}

/// The certificate is met, and says what the test's own integrations say.
void check_certificate(const BuildResult& result, double tolerance, int points = 200) {
  INFO(result.message);
  CHECK(result.met);
  REQUIRE(result.book.certificate());
  const Certificate& certificate = *result.book.certificate();
  CHECK(certificate.met);
  CHECK(certificate.failed_points == 0);
  CHECK(certificate.tolerance == tolerance);
  CHECK(certificate.max_error <= tolerance);
  CHECK(result.book.build().status == samara::Termination::converged);
  CHECK(result.book.build().evaluations > 0.0);
  CHECK(result.book.build().grid_size > 0.0);
  CHECK(result.book.build().rounds > 0);
  const OwnCheck own = own_check(result.book, points, 31);
  for (std::size_t o = 0; o < certificate.outputs.size(); ++o) {
    INFO(certificate.outputs[o].name);
    const auto i = static_cast<Eigen::Index>(o);
    // The largest of fewer, other points and times: perhaps a little more (errors peak in corners of the box,
    // which either set of points may come closer to), and not much less.
    CHECK(own.max_error[i] <= 1.5 * certificate.outputs[o].max);
    CHECK(own.max_error[i] >= 0.3 * certificate.outputs[o].max);
    CHECK_THAT(own.rms[i], WithinRel(certificate.outputs[o].rms, 0.5));  // of other times
  }
}

const std::string kCoin = "density = 6339\narea = 4.714e-4\nthickness = '2.55 mm'\n";

}  // namespace

TEST_CASE("the solution of (6.18), u(0) + (rate/k - 1) t, is of the least ranks, to 1e-10") {
  const BuildResult result =
      built("model = 'constant_rate'\n[box]\nk = [1, 5]\n[time]\nend = 1\n[tolerance]\nrelative = 1e-10\n");
  INFO(result.message);
  CHECK(result.met);
  CHECK(result.book.certificate()->max_error <= 1e-10);
  for (const Piece& piece : result.book.pieces()) {
    for (const int rank : piece.groups().front().train()->train().ranks()) CHECK(rank <= 2);
  }
  Query query(result.book);
  Eigen::VectorXd u(1);
  const Eigen::MatrixXd points = random_points(result.book, 500, 1);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    query.values(point(points, j), u);
    // u goes from -0.8... to 9: range 9.
    CHECK_THAT(u[0], WithinAbs((10.0 / points(1, j) - 1.0) * points(0, j), 1e-10 * 9.0));
  }
}

TEST_CASE("in the inverse of k, the first axis holds the solution of (6.18) over three decades") {
  const BuildResult result = built(
      "model = 'constant_rate'\n[box]\n"
      "k = { range = [0.01, 10], basis = 'legendre', transform = 'reciprocal' }\n"
      "[time]\nend = 1\n[tolerance]\nrelative = 1e-8\n");
  INFO(result.message);
  CHECK(result.met);
  CHECK(result.book.pieces().front().groups().front().axes()[1].size() ==
        samara::pgd::SlabOptions{}.first_nodes);
}

TEST_CASE("a logarithmic axis resolves a drag coefficient over three decades with fewer nodes") {
  const auto nodes = [](const std::string& transform) {
    const BuildResult result = built(
        "model = 'quadratic_drag_fall'\n[box]\nC_D = { range = [0.02, 20], basis = 'legendre', transform = "
        "'" +
        transform + "' }\n[time]\nend = 1\n[tolerance]\nrelative = 1e-4\n");
    INFO(result.message);
    CHECK(result.met);
    int most = 0;
    for (const Piece& piece : result.book.pieces())
      most = std::max(most, piece.groups().front().axes()[1].size());
    return most;
  };
  CHECK(nodes("log") < nodes("none"));
}

TEST_CASE("the fall of (6.20) follows the exact tanh to 1e-8") {
  const BuildResult result = built(
      "model = 'quadratic_drag_fall'\n[box]\nC_D = [0.5, 2]\n[time]\nend = 1\n[tolerance]\nrelative = "
      "1e-8\n");
  INFO(result.message);
  CHECK(result.met);
  Query query(result.book);
  Eigen::VectorXd u(1);
  const Eigen::MatrixXd points = random_points(result.book, 3000, 2);
  const auto terminal = [](double C_D) { return std::sqrt(2.0 * 0.1 * 9.81 / (1.23 * C_D * 0.5)); };
  const auto exact = [&](double t, double C_D) {
    return -terminal(C_D) * std::tanh(9.81 * t / terminal(C_D));
  };
  // u goes from 0 to that of the least drag at the end.
  const double range = std::abs(exact(1.0, 0.5));
  double largest = 0.0;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    query.values(point(points, j), u);
    largest = std::max(largest, std::abs(u[0] - exact(points(0, j), points(1, j))));
  }
  CHECK(largest <= 1e-8 * range);
  // The certificate's integrator contributes at most some 1e-10 per step.
  CHECK_THAT(result.book.certificate()->outputs[0].range, WithinRel(range, 1e-2));
}

TEST_CASE("a coin with C_D and v(0) free meets its tolerance, and the certificate is right") {
  const BuildResult& result = coin_build();
  check_certificate(result, 1e-3);
  CHECK_THAT(result.message, Contains("certified: largest error ") && Contains("<= 0.001 at 2000 points"));
  const Codebook& book = result.book;
  CHECK(book.title() == "a coin");
  REQUIRE(book.coordinate_count() == 3);
  CHECK(book.coordinates()[0].name == "t");
  CHECK(book.coordinates()[0].unit == "s");
  CHECK(book.coordinates()[0].lower == 0.0);
  CHECK(book.coordinates()[0].upper == 0.5);
  CHECK(book.coordinates()[1].name == "C_D");
  CHECK(book.coordinates()[1].role == samara::pgd::AxisRole::parameter);
  CHECK(book.coordinates()[1].lower == 0.8);
  CHECK(book.coordinates()[1].upper == 1.6);
  CHECK(book.coordinates()[2].name == "v(0)");
  CHECK(book.coordinates()[2].role == samara::pgd::AxisRole::initial);
  CHECK(book.coordinates()[2].unit == "m/s");
  CHECK(book.output_index("v") == 0);
  CHECK(book.output_index("x") == 1);
  CHECK(book.model().fixed.size() == 3);
  CHECK(book.model().fixed.at("area") == 4.714e-4);
  CHECK(book.model().fixed_units.at("density") == "kg/m^3");
  CHECK(book.model().fixed_units.size() == 3);
  CHECK(book.provenance().plan == coin_plan());
  CHECK(book.provenance().build_seconds > 0.0);
  CHECK(book.provenance().created.size() == std::string("2026-01-02T03:04:05Z").size());
}

TEST_CASE("the effort of a build counts all evaluations, against a sweep over the grid of the codebook") {
  const Plan plan = parse_plan(in_slabs(), "coin.toml");
  const Codebook book = build(plan, {.certificate_points = 200}).book;
  if (book.pieces().size() == 1) {
    const std::vector<samara::pgd::Axis> axes = book.pieces().front().outline().axes;
    CHECK(sweep_size(book.pieces()) == axes[1].size() * axes[2].size());
  }
  CHECK(book.build().grid_size ==
        sweep_size(book.pieces()) * evaluations_per_trajectory(plan, plan.parametric_model()));
}

TEST_CASE(
    "a march that works most at a kink of the law says when, of which term, and one over time says nothing") {
  const std::string card =
      "model = 'immersed_body'\n[fixed]\na = 0.035\nb = 0.02\nc = 1e-4\ndensity = 1200\nC_D0 = 0.05\nC_w = "
      "2\n"
      "C_T = 0.91\nspeed_floor = 1e-4\nvelocity_chord = 1\n'qw(0)' = 0.99619469809\n'qx(0)' = 0\n"
      "'qy(0)' = 0.08715574274\n[box]\nC_D90 = [0.28, 0.34]\nC_R = [0.56, 0.66]\n[time]\nend = 0.3\n"
      "[tolerance]\nrelative = 1e-3\nabsolute = { x = 0.1, y = 0.1, z = 0.1, qw = 1, qx = 1, qy = 1, qz = 1, "
      "ux = 0.1, uy = 0.1, uz = 0.1, wx = 5, wy = 5, wz = 5 }\n[builder]\nkind = 'pgd'\nstrategy = 'slabs'\n";
  const std::string message =
      build(parse_plan(card, "card.toml"), {.certificate_points = 20}).book.build().message;
  CHECK_THAT(message, Contains("of the evaluations of the march went into") &&
                          Contains("most of it is of the term \"rotational lift\""));
  CHECK_THAT(coin_build().book.build().message, !Contains("of the evaluations of the march"));
}

TEST_CASE("density, area, thickness and added mass may be free together") {
  check_certificate(built(fall_plan("C_D = 1.15\n",
                                    "density = [6300, 6400]\narea = ['4.6 cm^2', '4.8 cm^2']\n"
                                    "thickness = ['2.5 mm', '2.6 mm']\nm_a = [2e-3, 2.2e-3]\n",
                                    "0.3")),
                    1e-3);
}

TEST_CASE("an added mass that is derived follows a free area") {
  check_certificate(built(fall_plan("C_D = 1.15\n",
                                    "density = [6000, 6600]\narea = ['4 cm^2', '5.5 cm^2']\n"
                                    "thickness = ['2.4 mm', '2.7 mm']\n",
                                    "0.3")),
                    1e-3);
}

TEST_CASE("any two properties of the body may be free") {
  struct Case {
    std::string fixed, box;
  };
  for (const auto& [fixed, box] : std::vector<Case>{
           {"density = 6300\nthickness = 2.5e-3\n", "C_D = [1.0, 1.3]\narea = [4.5e-4, 5e-4]\n"},
           {"area = 4.7e-4\nC_D = 1.1\n", "density = [6000, 7000]\nthickness = [2.4e-3, 2.7e-3]\n"},
           {"area = 4.7e-4\ndensity = 6300\nthickness = 2.5e-3\n",
            "m_a = [4e-3, 5e-3]\nC_D = [1.0, 1.3]\n"}}) {
    INFO(box);
    check_certificate(built(fall_plan("\"v(0)\" = 0.1\n" + fixed, box, "0.4")), 1e-3, 100);
  }
}

TEST_CASE("a body lighter than the fluid rises") {
  const BuildResult result = built(
      fall_plan("area = 4.714e-4\nthickness = '2.55 mm'\n", "C_D = [0.8, 1.6]\ndensity = [500, 900]\n"));
  check_certificate(result, 1e-3);
  Query query(result.book);
  Eigen::VectorXd values(2);
  query.values(std::vector{0.5, 1.0, 700.0}, values);
  CHECK(values[0] < 0.0);
  CHECK(values[1] < 0.0);
}

TEST_CASE("a body as dense as the fluid stays: a codebook without terms") {
  const BuildResult result =
      built(fall_plan("density = 998.2\narea = 4.714e-4\nthickness = '2.55 mm'\n", "C_D = [0.8, 1.6]\n"));
  CHECK(result.met);
  CHECK(result.book.certificate()->max_error == 0.0);
  const TemporaryDirectory directory;
  save(result.book, directory / "still.h5");
  check_same_codebook(load(directory / "still.h5"), result.book);
}

TEST_CASE("nodes that a plan fixes are kept") {
  const BuildResult result = built(fall_plan(kCoin, "C_D = { range = [0.8, 1.6], nodes = 12 }\n"));
  CHECK(result.book.pieces().front().groups().front().axes()[1].size() == 12);
}

TEST_CASE("a codebook that misses its tolerance is marked, says by how much, and can be used") {
  const BuildResult result =
      built(fall_plan(kCoin, "C_D = { range = [0.5, 3], nodes = 3 }\n'v(0)' = [0, 0.3]\n", "0.5", "1e-5"));
  CHECK_FALSE(result.met);
  const Certificate& certificate = *result.book.certificate();
  CHECK_FALSE(certificate.met);
  CHECK(certificate.max_error > 1e-5);
  CHECK_THAT(result.message, Contains("missed its tolerance"));
  const std::string error = result.message.substr(result.message.find("largest error ") + 14);
  CHECK_THAT(std::stod(error), WithinRel(certificate.max_error, 5e-3));
  // Usable, with the error it states.
  const OwnCheck own = own_check(result.book, 100, 8);
  CHECK(own.max_error.maxCoeff() <= 1.5 * certificate.max_error);
  CHECK(own.max_error.maxCoeff() >= 0.3 * certificate.max_error);
}

TEST_CASE("the number of threads changes no byte outside the provenance") {
  const TemporaryDirectory directory;
  Plan plan = parse_plan(coin_plan(), "coin.toml");
  for (const int threads : {1, 2}) {
    plan.builder.threads = threads;
    const Codebook book = build(plan, {.certificate_points = 200}).book;
    const Codebook bare(book.model(), book.pieces(), book.build(), {}, book.certificate(), book.title());
    save(bare, directory / std::to_string(threads));
  }
  CHECK(content(directory / "1") == content(directory / "2"));
}

TEST_CASE("a build takes the threads of its plan and no more") {
  const std::string kind = GENERATE(as<std::string>{}, "pgd", "sampling");
  INFO(kind);
  const Plan plan = parse_plan(fall_plan(kCoin, "C_D = [0.8, 1.6]\n'v(0)' = [0, 0.3]\n") +
                                   "[builder]\nkind = '" + kind + "'\nthreads = 1\n",
                               "plan.toml");
  std::vector<int> threads;
  build(plan, {.certificate_points = 100, .progress = [&](const samara::Progress&) {
                 threads.push_back(tbb::this_task_arena::max_concurrency());
                 return true;
               }});
  REQUIRE_FALSE(threads.empty());
  CHECK(std::ranges::count(threads, 1) == std::ssize(threads));
}

TEST_CASE("the seed of a plan changes the course of a build, not its quality") {
  const BuildResult result = built(coin_plan() + "seed = 5\n");
  CHECK(result.met);
  CHECK(result.book.build().evaluations != coin_build().book.build().evaluations);
}

TEST_CASE(
    "a build in slabs that may not evaluate more ends with the status max_calls, after the slab it is at") {
  const std::string box = "C_D = [0.8, 1.6]\n'v(0)' = [0, 0.3]\n";
  const std::string builder = "[builder]\nkind = 'pgd'\nstrategy = 'slabs'\n";
  Plan plan = parse_plan(fall_plan(kCoin, box, "0.5", "1e-6") + builder, "plan.toml");
  plan.builder.max_calls = 50'000;
  const BuildResult result = build(plan, {.certificate_points = 100});
  CHECK_FALSE(result.met);
  CHECK(result.book.build().status == samara::Termination::max_calls);
  CHECK(result.book.build().evaluations <= 150'000);
  CHECK(result.book.build().strategy == "slabs");
}

TEST_CASE("progress is reported in stages, with fractions between 0 and 1") {
  std::vector<std::string> stages;
  built(in_slabs(), {.certificate_points = 100, .progress = [&](const samara::Progress& report) {
                       CHECK(report.fraction >= 0.0);
                       CHECK(report.fraction <= 1.0);
                       if (stages.empty() || stages.back() != report.stage) stages.push_back(report.stage);
                       return true;
                     }});
  REQUIRE(stages.size() > 2);
  CHECK(stages[0] == "survey of the box");
  CHECK(stages[1] == "slab 1");
  CHECK(stages.back() == "certificate");
}

TEST_CASE("a build that is cancelled says so, asks no more, and gives what it has") {
  for (const std::string stage : {"slab 2", "certificate"}) {
    bool cancelled = false;
    int reports_after = 0;
    const BuildResult result =
        built(in_slabs(), {.certificate_points = 100, .progress = [&](const samara::Progress& report) {
                             if (cancelled) ++reports_after;
                             cancelled = cancelled || report.stage == stage;
                             return !cancelled;
                           }});
    INFO(stage);
    CHECK(cancelled);
    CHECK(reports_after == 0);
    CHECK_FALSE(result.met);
    CHECK_FALSE(result.book.certificate()->met);
    CHECK(result.message == "the build was cancelled; its certificate covers 0 of 100 points");
    CHECK(result.book.build().status ==
          (stage == "slab 2" ? samara::Termination::cancelled : samara::Termination::converged));
    Query query(result.book);
    Eigen::VectorXd values(2);
    CHECK_NOTHROW(query.values(std::vector{0.02, 1.0, 0.1}, values));
  }
}

TEST_CASE("a build warns of parameters that no body has, by the centre of the box") {
  std::vector<std::string> warnings;
  BuildOptions options{.certificate_points = 20};
  options.warning = [&](const std::string& sentence) { warnings.push_back(sentence); };
  const auto fall = [](const std::string& thickness) {
    return fall_plan("area = 4.7144e-4\ndensity = 6338.5\n",
                     "C_D = [0.8, 1.6]\nthickness = " + thickness + "\n", "0.1");
  };
  built(fall("[2e-3, 3e-3]"), options);
  CHECK(warnings.empty());
  built(fall("[0.02, 0.04]"), options);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("thickness is 0.03 m, more than the radius of a disc of that area"));
}

TEST_CASE("axes are refined until they resolve the solution, to tight tolerances") {
  // u = (10 / k - 1) t: the pole at k = 0 lies near the box, so that the axis needs many nodes.
  const std::string plan =
      "model = \"constant_rate\"\n[box]\nk = [1.0, 100.0]\n[time]\nend = 1.0\n[tolerance]\nrelative = 1e-6\n";
  const BuildResult result = built(plan, {.certificate_points = 200});
  INFO(result.message);
  CHECK(result.met);
  CHECK(result.book.build().rounds <= 4);
}

TEST_CASE("an axis that cannot resolve the solution is named, with the nodes it has") {
  const std::string plan =
      "model = \"constant_rate\"\n[box]\nk = [0.01, 100.0]\n[time]\nend = 1.0\n[tolerance]\nrelative = "
      "1e-6\n";
  CHECK_THAT(error_text<samara::NoResultError>([&] { built(plan, {.certificate_points = 20}); }),
             Contains("nodes on the axis k do not suffice"));
}

TEST_CASE("a march that ends on its first slab has no result, and says so") {
  // Ten thousand turns of the plate in one element are beyond any refinement that slabs know.
  const std::string plan =
      "model = 'falling_plate_nd'\n[box]\nC_T = [0.8, 1.4]\n[time]\nend = 1e6\n"
      "[builder]\nkind = 'pgd'\nstrategy = 'slabs'\n";
  CHECK_THAT(error_text<samara::NoResultError>([&] { build(parse_plan(plan, "plan.toml")); }),
             Contains("no result on the first slab: "));
}

TEST_CASE("a plan that names a strategy is solved by it, also where it names no kind") {
  const std::string plan = fall_plan("area = 4.7144e-4\nthickness = 0.00255\ndensity = 6338.5\n",
                                     "C_D = [0.8, 1.6]\n'v(0)' = [0, 0.4]\n", "0.2");
  const BuildResult result =
      build(parse_plan(plan + "[builder]\nstrategy = 'slabs'\n", "plan.toml"), {.certificate_points = 20});
  CHECK(result.book.build().strategy == "slabs");
  CHECK_THAT(result.book.build().message, Contains("chosen because the plan names a strategy"));
}

TEST_CASE("a plan of enrichment is answered by sums of products, certified, of few terms") {
  const BuildResult result = built(fall_plan("area = 4.7144e-4\nthickness = 0.00255\ndensity = 6338.5\n",
                                             "C_D = [0.8, 1.6]\n'v(0)' = [0, 0.4]\n", "0.4", "1e-4") +
                                   "[builder]\nstrategy = 'enrichment'\n");
  INFO(result.message);
  CHECK(result.met);
  CHECK(result.book.build().strategy == "enrichment");
  for (const Piece& piece : result.book.pieces()) {
    const samara::pgd::SeparatedField* sum = piece.groups().front().sum();
    REQUIRE(sum != nullptr);
    CHECK(sum->rank() <= 20);
  }
  CHECK(result.book.pieces().size() <= 2);  // slabs are joined
}
