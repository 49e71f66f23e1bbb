#include "samara/flow/books/field_book.h"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>
#include <string>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/codebooks/book/provenance.h"
#include "samara/codebooks/query/place_query.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/flow/books/cell_mesh.h"
#include "samara/flow/books/energy_book.h"
#include "samara/flow/books/field_flow.h"
#include "samara/flow/books/leja_grid.h"
#include "samara/flow/books/planned_flow.h"
#include "samara/models/bodies/mesh_shapes.h"
#include "tests/io/temporary_directory.h"

using namespace samara;
using namespace samara::flow;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;

namespace {

const char* const kPlan = R"(title = "an ellipse that turns"
[flow]
shape = { kind = "ellipse", length = 1, thickness = 0.5 }
reynolds = 20
turbulence = "none"
cells_per_length = 4
extent = { before = 1.5, behind = 2, side = 1.5 }
end = "steady"
max_time = 100
[box]
angle_of_attack = ["0 deg", "30 deg"]
[book]
kind = "fields"
certificate_points = 2
[tolerance]
relative = 0.04
)";

struct Built {
  FlowPlan plan = parse_flow_plan(kPlan, "plan.toml");
  codebooks::BuildResult result = build_field_book(plan);
};

const Built& built() {
  static const Built book;
  return book;
}

}  // namespace

TEST_CASE(
    "a grid of Leja points interpolates polynomials of its degree, and is the same on Chebyshev points") {
  LejaGrid grid(2);
  grid.set_counts({3, 4});
  const auto polynomial = [](double x, double y) { return 1.0 + x * x - 2.0 * x * y + y * y * y; };
  CHECK(grid.missing({3, 4}) == 12);
  grid.for_missing([&](const std::vector<int>& numbers) {
    const std::vector<double> unit = grid.unit_of(numbers);
    grid.put(numbers, Eigen::VectorXd::Constant(1, polynomial(unit[0], unit[1])));
  });
  CHECK_THAT(grid.at({0.3, -0.7})[0], WithinAbs(polynomial(0.3, -0.7), 1e-13));
  const Eigen::MatrixXd moved = grid.on_chebyshev_points();
  // Number 1 of 3 and number 2 of 4.
  CHECK_THAT(moved(0, 1 + 3 * 2), WithinAbs(polynomial(0.0, -std::cos(std::numbers::pi * 2 / 3)), 1e-13));
  // A larger grid keeps what is there.
  CHECK(grid.missing({3, 5}) == 3);
}

TEST_CASE("a grid grows along the coordinate that needs it until the next node is foretold") {
  LejaGrid grid(2);
  const auto wave = [](double x, double y) { return std::exp(2.0 * x) + 0.1 * y; };
  const auto solve = [&](const std::vector<double>& unit) -> Eigen::VectorXd {
    return Eigen::VectorXd::Constant(1, wave(unit[0], unit[1]));
  };
  const auto apart = [](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return std::abs(a[0] - b[0]); };
  const GridGrowth growth = grow(grid, solve, apart, 1e-3, 100);
  CHECK(growth.status == Termination::converged);
  CHECK(growth.worst <= 1e-3);
  CHECK(grid.counts()[0] > 5);
  CHECK(grid.counts()[1] == 3);
  CHECK(growth.solved == static_cast<long>(grid.columns().size()));
  for (const double x : {-0.9, 0.3, 0.77}) CHECK_THAT(grid.at({x, 0.4})[0], WithinAbs(wave(x, 0.4), 5e-3));

  LejaGrid small(2);
  const GridGrowth few = grow(small, solve, apart, 1e-9, 20);
  CHECK(few.status == Termination::max_calls);
  CHECK(few.solved <= 20);
  CHECK(small.missing(small.counts()) == 0);
}

TEST_CASE("an energy book takes few flows, answers as they do, and goes on from its checkpoint") {
  FlowPlan plan = parse_flow_plan(kPlan, "plan.toml");
  plan.of_fields = false;
  const TemporaryDirectory directory;
  codebooks::BuildOptions options;
  options.checkpoint = directory / "book.checkpoint";
  options.keep_checkpoint = true;
  const codebooks::BuildResult result = build_energy_book(plan, options);
  INFO(result.message);
  CHECK(result.met);
  CHECK(result.book.build().strategy == "grid");
  CHECK(result.book.build().evaluations <= 12);
  codebooks::Query query(result.book);
  Eigen::VectorXd asked(result.book.output_count());
  const std::vector<double> point = {0.2};
  query.values(point, asked);
  const Eigen::VectorXd solved = solve_energy(plan, point, {});
  CHECK_THAT(asked(0), WithinAbs(solved(0), 0.04 * std::abs(solved(0))));  // C_D
  CHECK_THAT(asked(1), WithinAbs(solved(1), 0.04));                        // C_L

  // From the flows that are kept: one that is solved would be cancelled.
  options.resume = true;
  options.progress = [](const Progress& report) { return !report.stage.starts_with("flow at"); };
  const codebooks::BuildResult again = build_energy_book(plan, options);
  Eigen::VectorXd the_same(again.book.output_count());
  codebooks::Query(again.book).values(point, the_same);
  CHECK(the_same == asked);
  CHECK(again.book.certificate()->max_error == result.book.certificate()->max_error);
  // Cancelled in a flow of the certificate.
  std::filesystem::remove(options.checkpoint);
  options.keep_checkpoint = false;
  std::set<std::string> flows;
  int after = 0;
  bool cancelled = false;
  options.progress = [&](const Progress& report) {
    after += cancelled ? 1 : 0;
    if (cancelled) return true;
    if (report.stage.starts_with("flow at")) flows.insert(report.stage);
    cancelled = static_cast<double>(flows.size()) > result.book.build().evaluations;
    return !cancelled;
  };
  const codebooks::BuildResult stopped = build_energy_book(plan, options);
  CHECK(cancelled);
  CHECK(after == 0);
  CHECK_FALSE(stopped.met);
  CHECK(stopped.resumable);
  CHECK(std::filesystem::exists(options.checkpoint));
  // A build that is done removes its checkpoint, unless it is to be kept.
  options.progress = {};
  CHECK(build_energy_book(plan, options).met);
  CHECK_FALSE(std::filesystem::exists(options.checkpoint));

  plan.max_calls = 3;
  CHECK_THROWS_WITH(build_energy_book(plan), Contains("max_calls") && Contains("at least 4"));
  plan.box.clear();
  CHECK_THROWS_WITH(build_energy_book(plan), Contains("needs a box"));
}

TEST_CASE("flows on twice the cells that were found before an interruption are not solved again") {
  const FlowPlan& plan = built().plan;
  const TemporaryDirectory directory;
  codebooks::BuildOptions options;
  options.checkpoint = directory / "book.checkpoint";
  options.resume = true;
  std::set<std::string> flows;
  const auto flows_of = [&](std::size_t most) {
    flows.clear();
    options.progress = [&flows, most](const Progress& report) {
      flows.insert(report.stage);
      return flows.size() <= most;
    };
  };
  const auto checked = [&](const auto& change_of, const codebooks::Codebook& book) {
    std::filesystem::remove(finer_checkpoint(options.checkpoint));
    flows_of(1);
    CHECK_THROWS_AS(change_of(plan, book, options), NoResultError);
    CHECK(flows.size() == 2);
    flows_of(2);
    const Eigen::VectorXd change = change_of(plan, book, options);
    CHECK(flows.size() == 1);
    CHECK(change == change_of(plan, book, codebooks::BuildOptions()));
    CHECK(change.minCoeff() >= 0.0);
    CHECK(change.maxCoeff() > 0.0);
  };
  checked(field_discretisation, built().result.book);
  checked(discretisation, build_energy_book(plan).book);
}

TEST_CASE("twice the cells lie within those that they are compared with, whatever fractions the extent has") {
  FlowPlan plan = parse_flow_plan(kPlan, "plan.toml");
  plan.flow.extent = {.before = 1.63, .behind = 2.1, .side = 1.63};
  const MacGrid coarse = grid_of(plan.flow), fine = grid_of(finer_plan(plan).flow);
  for (std::size_t d = 0; d < 2; ++d) CHECK(fine.cells[d] == 2 * coarse.cells[d]);
  CHECK((fine.origin - coarse.origin).norm() < 1e-12);
}

TEST_CASE("a book does not go on from the flows of another solver, and says so") {
  FlowPlan plan = parse_flow_plan(kPlan, "plan.toml");
  const TemporaryDirectory directory;
  codebooks::BuildOptions options;
  options.checkpoint = directory / "book.checkpoint";
  options.resume = true;
  options.progress = [](const Progress&) { return false; };
  std::string older = checkpointed_text(plan);
  older.back() = 'x';
  for (const std::string& text : {plan.text, older}) {
    std::filesystem::remove(options.checkpoint);
    codebooks::Checkpoint(options.checkpoint, text).save_calls({});
    CHECK_THROWS_WITH(build_energy_book(plan, options),
                      Contains("belongs to another plan") && Contains("--fresh"));
    CHECK_THROWS_WITH(build_field_book(plan, options),
                      Contains("belongs to another plan") && Contains("--fresh"));
  }
  // That of this one is taken up, and the first flow is cancelled.
  std::filesystem::remove(options.checkpoint);
  codebooks::Checkpoint(options.checkpoint, checkpointed_text(plan)).save_calls({});
  CHECK_THROWS_AS(build_energy_book(plan, options), NoResultError);
  CHECK_THROWS_AS(build_field_book(plan, options), NoResultError);
}

TEST_CASE("flows about another mesh in the file that a plan names are those of another book") {
  const std::string text = R"([flow]
dimensions = 3
shape = { kind = "mesh", file = "body.obj", thickness = 0.25 }
reynolds = 50
turbulence = "none"
cells_per_length = 8
extent = { before = 1.5, behind = 2, side = 1.5 }
[box]
angle_of_attack = ["0 deg", "30 deg"]
[book]
kind = "fields"
)";
  const auto box_of = [](double width) {
    return [width](const std::string&) { return models::box_mesh({2.0, 0.5, width}, 2, 2, 2); };
  };
  const FlowPlan narrow = parse_flow_plan(text, "plan.toml", box_of(1.0)),
                 wide = parse_flow_plan(text, "plan.toml", box_of(1.5));
  CHECK(checkpointed_text(narrow) != checkpointed_text(wide));
  CHECK(checkpointed_text(narrow) == checkpointed_text(parse_flow_plan(text, "plan.toml", box_of(1.0))));
  // Nor are the flows of a book shown about the other.
  codebooks::ModelDescription model = built().result.book.model();
  model.source = book_source(narrow);
  const codebooks::Codebook book(model, built().result.book.pieces(), built().result.book.build(),
                                 codebooks::made_now(text, 1.0));
  CHECK_THROWS_WITH(flow_of(book, {{"angle_of_attack", 0.1}}, "book.h5", box_of(1.5)),
                    Contains("book.h5") && Contains("about another mesh"));
  CHECK_THROWS_WITH(flow_of(book, {{"angle_of_attack", 0.1}}, "book.h5", box_of(1.0)),
                    Contains("on another grid"));
}

TEST_CASE("what a flow of a book warns of is told, and of which flow") {
  FlowPlan plan = parse_flow_plan(kPlan, "plan.toml");
  plan.flow.turbulence = TurbulenceModel::k_epsilon;
  std::vector<std::string> told;
  codebooks::BuildOptions options;
  options.warning = [&](const std::string& sentence) { told.push_back(sentence); };
  options.progress = [](const Progress&) { return false; };
  const auto told_by = [&](const auto& build) {
    told.clear();
    CHECK_THROWS_AS(build(plan, options), NoResultError);
    REQUIRE_FALSE(told.empty());
    CHECK_THAT(told.front(), Catch::StartsWith("flow at ") && Contains("high Reynolds numbers"));
  };
  told_by(build_energy_book);
  told_by(build_field_book);
}

TEST_CASE("a book whose body comes too near to a border between the ends of its box is refused") {
  FlowPlan plan = parse_flow_plan(kPlan, "plan.toml");
  plan.flow.shape = rectangle_section(1.0, 0.25);
  plan.flow.cells_per_length = 16;
  plan.flow.extent = {.before = 0.75, .side = 5.0};
  plan.box.front().lower = -plan.box.front().upper;
  for (const double end : {plan.box.front().lower, plan.box.front().upper})
    CHECK_NOTHROW(check_case(flow_case_at(plan, {end}), plan.max_memory));
  // The diagonal of the rectangle lies along the stream at 14 degrees.
  CHECK_THROWS_WITH(check_book(plan), Contains("of a border, expected at least 0.25, four cells"));
}

TEST_CASE("a book refuses another file in place of its checkpoints before the first flow") {
  const FlowPlan plan = parse_flow_plan(kPlan, "plan.toml");
  const TemporaryDirectory directory;
  codebooks::BuildOptions options;
  options.checkpoint = directory / "book";
  int reports = 0;
  options.progress = [&](const Progress&) { return ++reports > 0; };
  for (const std::string name : {"book", "book.finer"}) {
    const std::filesystem::path capture = directory.put(name, "t,z\n0,1\n");
    const auto refused = Contains(name + ": this is no checkpoint of a build or a cloud, and would be lost");
    CHECK_THROWS_WITH(build_energy_book(plan, options), refused);
    CHECK_THROWS_WITH(build_field_book(plan, options), refused);
    CHECK(content(capture) == "t,z\n0,1\n");
    std::filesystem::remove(capture);
  }
  CHECK(reports == 0);
}

TEST_CASE("the build of a book that was cancelled once is not asked again, and may go on later") {
  codebooks::BuildOptions options;
  int asked = 0;
  options.progress = [&](const Progress&) { return ++asked != 2; };
  const codebooks::BuildResult result = run_build(options, [&](const codebooks::BuildOptions& guarded) {
    CHECK(guarded.progress({"first flow", 0.5}));
    CHECK_FALSE(guarded.progress({"first flow", 1.0}));
    CHECK_FALSE(guarded.progress({"next flow", 0.0}));
    return built().result;
  });
  CHECK(asked == 2);
  CHECK(result.resumable);
  CHECK_FALSE(built().result.resumable);
}

TEST_CASE("cells fill the box of their centres, and closed ones go on from the surface") {
  for (const int dimensions : {2, 3}) {
    const MacGrid grid(dimensions, {5, 4, dimensions == 3 ? 3 : 1}, 0.5, Eigen::Vector3d(-1.0, -1.0, 0.0));
    const codebooks::SpaceMesh mesh = cell_mesh(grid);
    CHECK(mesh.node_count() == grid.cell_count());
    // Each simplex holds a sixth of a cube or half a square.
    const double volume =
        static_cast<double>(mesh.cells().cols()) * std::pow(0.5, dimensions) / (dimensions == 3 ? 6.0 : 2.0);
    CHECK_THAT(volume, WithinAbs((mesh.upper() - mesh.lower()).prod(), 1e-12));
    CHECK_THAT(cell_axis(grid).measure(),
               WithinAbs(static_cast<double>(grid.cell_count()) * std::pow(0.5, dimensions), 1e-12));
    const Eigen::VectorXd numbers = Eigen::VectorXd::LinSpaced(grid.cell_count(), 1.0, 2.0);
    CHECK(cells_in_order(grid, field_in_order(grid, numbers)) == numbers);
  }
  const MacGrid grid(2, {8, 8, 1}, 0.5, Eigen::Vector3d(-2.0, -2.0, 0.0));
  Borders borders;
  const Openness body =
      measure_openness(grid, borders, PlacedShape(rectangle_section(2.0, 2.0), Eigen::Vector3d::Zero(), 0.0));
  Field field = grid.field();
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 8; ++i) {
      const auto c = static_cast<std::size_t>(grid.at(i, j));
      field[c] = body.inverse_cell[c] > 0.0 ? 3.0 : -1e9;
    }
  }
  continue_into_body(grid, body, field);
  CHECK(cells_in_order(grid, field) == Eigen::VectorXd::Constant(64, 3.0));
}

TEST_CASE("a codebook of fields has the flows that its builder solved, and is near those it did not see") {
  const codebooks::BuildResult& result = built().result;
  INFO(result.message);
  CHECK(result.met);
  const codebooks::Certificate& certificate = *result.book.certificate();
  CHECK(certificate.points == 2);
  CHECK(certificate.places == 14 * 12);
  // What is told beside the 95 %: of every output the largest error anywhere.
  for (const pgd::OutputLabel& output : field_outputs(built().plan.flow))
    CHECK_THAT(certificate.integrator, Contains(" " + output.name + " "));
  FlowCase flow = built().plan.flow;
  flow.angle_of_attack = 30.0 / 180.0 * std::numbers::pi;
  const FlowResult solved = solve_flow(flow, {.end = FlowEnd::steady, .max_time = 100.0});
  const StoredFlow stored = flow_of(result.book, {{"angle_of_attack", flow.angle_of_attack}}, "book.h5");
  const std::vector<CentreField> centres = centre_fields(solved);
  for (const char* name : {"u", "v"}) {
    const Eigen::VectorXd expected =
        cells_in_order(solved.grid, std::ranges::find(centres, name, &CentreField::name)->values);
    const Eigen::VectorXd found = cells_in_order(stored.grid, stored.field(name).values);
    // An end of the box is a node: only truncated modes are between them, 0.2 % of the range in the mean.
    CHECK(std::sqrt((found - expected).squaredNorm() / static_cast<double>(found.size())) < 0.004);
  }
  CHECK(stored.open == solved.body.cell);
  CHECK(std::isnan(stored.summary.drag));
}

TEST_CASE(
    "a codebook of fields whose certificate lacks a flow says so, and the next build goes on from there") {
  const TemporaryDirectory directory;
  codebooks::BuildOptions options;
  options.checkpoint = directory / "book.checkpoint";
  options.resume = true;
  // Cancelled in the last flow of all, the second of the certificate.
  std::set<std::string> flows;
  options.progress = [&](const Progress& report) {
    flows.insert(report.stage);
    return static_cast<double>(flows.size()) < built().result.book.build().evaluations;
  };
  const codebooks::BuildResult stopped = build_field_book(built().plan, options);
  CHECK_FALSE(stopped.met);
  CHECK(stopped.resumable);
  const codebooks::Certificate& certificate = *stopped.book.certificate();
  CHECK(certificate.failed_points == 1);
  CHECK_THAT(certificate.failure, Contains("ends as \"cancelled\""));
  CHECK(certificate.max_error > 0.0);
  CHECK(std::filesystem::exists(options.checkpoint));
  flows.clear();
  const codebooks::BuildResult whole = build_field_book(built().plan, options);
  CHECK(flows.size() == 1);
  CHECK(whole.met);
  CHECK(whole.book.certificate()->max_error == built().result.book.certificate()->max_error);
  CHECK_FALSE(std::filesystem::exists(options.checkpoint));
}

TEST_CASE("a codebook of fields is asked at places, with gradients by the angle") {
  codebooks::PlaceQuery query(built().result.book);
  REQUIRE(query.coordinates().size() == 3);
  Eigen::VectorXd values(4), ahead(4);
  Eigen::MatrixXd gradient(4, 3);
  query.values(std::vector{1.1, 0.2, 0.3}, values, gradient);
  query.values(std::vector{1.1, 0.2, 0.3 + 1e-5}, ahead);
  for (Eigen::Index o = 0; o < 4; ++o)
    CHECK_THAT(gradient(o, 2),
               WithinAbs((ahead[o] - values[o]) / 1e-5, 1e-3 * (1.0 + std::abs(gradient(o, 2)))));
}

TEST_CASE("what is no flow of a codebook of fields is refused") {
  const codebooks::Codebook& book = built().result.book;
  CHECK_THROWS_WITH(flow_of(book, {}, "book.h5"),
                    Contains("book.h5 needs a value of angle_of_attack, from 0 to 0.523599"));
  CHECK_THROWS_AS(flow_of(book, {{"angle_of_attack", 1.0}}, "book.h5"), OutsideBoxError);
  CHECK_THROWS_WITH(flow_of(book, {{"angle_of_attack", 0.1}, {"log10_reynolds", 3.0}}, "book.h5"),
                    Contains("log10_reynolds"));
  CHECK_THROWS_WITH(flow_of(book, {{"angle_of_attack", 0.1}, {"node", 3.0}}, "book.h5"),
                    "book.h5 has its flows at every node: expected no value of it");
  // Plans of other flows than those that it holds.
  const auto of_plan = [&](const std::string& from, const std::string& to) {
    std::string text = kPlan;
    text.replace(text.find(from), from.size(), to);
    return codebooks::Codebook(book.model(), book.pieces(), book.build(), codebooks::made_now(text, 1.0));
  };
  const auto two = of_plan("[book]", "log10_reynolds = [1, 1.5]\n[book]");
  CHECK_THROWS_WITH(
      flow_of(two, {{"angle_of_attack", 0.1}}, "book.h5"),
      Contains(
          "has the coordinates angle_of_attack beside its places, expected angle_of_attack, log10_reynolds"));
  const auto wide = of_plan("side = 1.5", "side = 1e9");
  CHECK_THROWS_WITH(flow_of(wide, {{"angle_of_attack", 0.1}}, "book.h5"),
                    Contains("at most 1000 body lengths"));
  FlowPlan plan = built().plan;
  plan.box.clear();
  CHECK_THROWS_WITH(build_field_book(plan), Contains("needs a box"));
  // Fewer flows than a first grid takes give a book that says so.
  FlowPlan few = built().plan;
  few.max_calls = 4;
  few.relative = 1e-4;
  few.certificate_points = 1;
  const TemporaryDirectory directory;
  codebooks::BuildOptions options;
  options.checkpoint = directory / "book.checkpoint";
  const codebooks::BuildResult missed = build_field_book(few, options);
  CHECK_FALSE(missed.met);
  CHECK_FALSE(std::filesystem::exists(options.checkpoint));
  CHECK_THAT(missed.message, Contains("no more than 4 flows were allowed"));
}
