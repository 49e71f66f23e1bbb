#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "../../examples/own_model/predator_prey.h"
#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/composition/mixed_trajectories.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/codebooks/query/derived_query.h"
#include "samara/codebooks/query/query.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/reference_trajectories.h"

using namespace samara::codebooks;
namespace models = samara::models;
using Catch::Matchers::Contains;
using samara::ArgumentError;
using samara::InputError;

namespace {

constexpr const char* kEquations = R"([equations]
name = "hunters"
states.prey = { initial = 10 }
states.predator = { initial = 5 }
parameters.growth = { unit = "1/s", above = 0 }
parameters.hunt = { unit = "1/s", above = 0 }
parameters.gain = { unit = "1/s", default = 0.05 }
parameters.death = { unit = "1/s", default = 0.5 }
let.meetings = "prey*predator"
rates.prey = "growth*prey - hunt*meetings"
rates.predator = "gain*meetings - death*predator"
)";

constexpr const char* kBox = R"([box]
growth = [0.9, 1.1]
hunt = [0.09, 0.11]
[time]
end = 5
[tolerance]
relative = 1e-5
)";

Plan plan_of_text() {
  return parse_plan(std::string(kEquations) + kBox, "hunters.toml");
}

/// The same question in C++.
struct OwnQuestion {
  models::ParametricModel model{
      models::make_model<PredatorPrey>(), {{"gain", 0.05}, {"death", 0.5}}, {"growth", "hunt"}};
  BuildRequest request;

  OwnQuestion() {
    request.box = {{.name = "growth", .lower = 0.9, .upper = 1.1},
                   {.name = "hunt", .lower = 0.09, .upper = 0.11}};
    request.end = 5.0;
    request.relative = 1e-5;
  }
};

BuildOptions few() {
  BuildOptions options;
  options.certificate_points = 100;
  return options;
}

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path) << text;
}

}  // namespace

TEST_CASE("text and C++ end in the same codebook") {
  const BuildResult text = build(plan_of_text(), few());
  const OwnQuestion asked;
  const BuildResult compiled = build(asked.model, asked.request, few());
  CAPTURE(text.message, compiled.message);
  REQUIRE(text.met);
  REQUIRE(compiled.met);
  CHECK(compiled.book.model().name == "predator_prey_law");
  Query from_text(text.book), from_law(compiled.book);
  std::mt19937 random(31);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  Eigen::VectorXd a(2), b(2);
  for (int k = 0; k < 200; ++k) {
    const std::vector<double> point = {5.0 * share(random), 0.9 + 0.2 * share(random),
                                       0.09 + 0.02 * share(random)};
    from_text.values(point, a);
    from_law.values(point, b);
    CHECK((a - b).cwiseAbs().maxCoeff() < 2e-5 * 20.0);  // both within 1e-5 of ranges below 20
  }
}

TEST_CASE("a state that nothing gives a size is measured by its range, however small that is") {
  const BuildResult result = build(parse_plan(R"([equations]
name = "droplet"
states.x = { initial = 1 }
states.m = { unit = "kg" }
parameters.k = { unit = "1/s" }
rates.x = "-k*x"
rates.m = "1e-13 [kg]*k*x"
[box]
k = [1, 3]
[time]
end = "1 s"
[tolerance]
relative = 1e-4
)",
                                              "droplet.toml"),
                                   few());
  const OutputError& mass = result.book.certificate()->outputs.at(1);
  CHECK(mass.range < 1e-12);
  CHECK(mass.range > 1e-14);
}

TEST_CASE("a state that is constant up to rounding is met, by its size or the absolute tolerance") {
  const std::string equations = R"([equations]
name = "decay"
states.x = { initial = 1 }
states.c = { initial = 3 }
parameters.k = { unit = "1" }
rates.x = "-k*x"
rates.c = "(k + 0.1)*x - k*x - 0.1*x"
[box]
k = [1, 3]
[time]
end = 1
[tolerance]
relative = 1e-4
)";
  for (const std::string kind : {"auto", "pgd"}) {
    const std::string builder = "[builder]\nkind = '" + kind + "'\n";
    for (const std::string absolute : {"", "absolute = { c = 1e-3 }\n"}) {
      const BuildResult result = build(parse_plan(equations + absolute + builder, "decay.toml"), few());
      CAPTURE(kind, absolute, result.message);
      CHECK(result.met);
      const double scale = result.book.certificate()->outputs[1].range;
      CHECK(scale == Approx(absolute.empty() ? 3.0 : 1e-3));
    }
  }
}

TEST_CASE("a range that is small against its offset is met where doubles allow it") {
  const std::string plan = R"toml([equations]
name = "swing"
states.x = { initial = 1e4 }
parameters.k = { unit = "1" }
rates.x = "1e-3*sin(k*t)"
[box]
k = [1, 3]
[time]
end = 3
[tolerance]
relative = 1e-4
[builder]
)toml";
  for (const std::string kind : {"sampling", "pgd"}) {
    const BuildResult result = build(parse_plan(plan + "kind = '" + kind + "'\n", "swing.toml"), few());
    CAPTURE(kind, result.message);
    REQUIRE(result.met);
    Query query(result.book);
    Eigen::VectorXd x(1);
    query.values(std::vector{3.0, 2.0}, x);
    // Of a range of 2e-3.
    CHECK(x[0] - 1e4 == Approx(1e-3 * (1.0 - std::cos(6.0)) / 2.0).margin(2e-7));
  }
}

TEST_CASE("a codebook brings its equations along") {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "hunters.h5";
  const Codebook built = build(plan_of_text(), few()).book;
  save(built, path);
  const Codebook book = load(path);
  REQUIRE(known_model(book.model()));
  CHECK(models::find_model_or_null("hunters") == nullptr);
  CertifyOptions options;
  options.points = 50;
  options.seed = 9;
  options.tolerance = 1e-5;
  const Certificate again = certify(book, model_of(book), options);
  CHECK(again.met);
  const auto* before = models::equations_of(*built.model().of_text);
  const auto* after = models::equations_of(*book.model().of_text);
  CHECK(to_toml(*before) == to_toml(*after));
}

TEST_CASE("what is written of equations is read again as it was") {
  models::Equations equations;
  equations.name = "a \"name\"";
  equations.title = "tabs\tand \\ signs";
  equations.states = {{.name = "x", .unit = "m", .default_initial = 0.1, .description = "d", .scale = 1e-3}};
  equations.parameters = {{.name = "k",
                           .unit = "1/s",
                           .default_value = 1.0 / 3.0,
                           .lower = 0.0,
                           .lower_inclusive = true,
                           .upper = 7.5}};
  equations.abbreviations = {{"twice", "2*x"}, {"again", "twice + x"}};
  equations.rates = {"-k*again"};
  const std::string text = to_toml(equations);
  const models::Equations read = read_equations(samara::io::TomlTable::parse(text, "text"));
  CHECK(to_toml(read) == text);
  CHECK(read.name == equations.name);
  CHECK(read.parameters[0].default_value == 1.0 / 3.0);
  CHECK(read.abbreviations == equations.abbreviations);
}

TEST_CASE("a plan finds the file of its model beside itself, and its checkpoints know both") {
  const TemporaryDirectory folder;
  const auto plan_path = folder.path() / "plan.toml";
  std::string model = kEquations;
  model = model.substr(model.find('\n') + 1);  // without the head of the table
  write(folder.path() / "hunters.toml", model);
  write(plan_path, std::string("model = 'hunters.toml'\n") + kBox);
  const Plan plan = read_plan(plan_path);
  CHECK(plan.model == "hunters");
  write(folder.path() / "hunters.toml", model + "# the same\n");
  CHECK(read_plan(plan_path).whole_text() == plan.whole_text());
  model.replace(model.find("death*predator"), 5, "0.5*death");
  write(folder.path() / "hunters.toml", model);
  CHECK(read_plan(plan_path).whole_text() != plan.whole_text());
  CHECK(read_plan(plan_path).certificate_seed() != plan.certificate_seed());
  std::filesystem::remove(folder.path() / "hunters.toml");
  CHECK_THAT(error_text<InputError>([&] { read_plan(plan_path); }), Contains("hunters.toml"));
}

TEST_CASE("equations that are wrong are refused with the line of what is wrong") {
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text = std::string(kEquations) + kBox;
    text.replace(text.find(from), from.size(), to);
    return error_text<InputError>([&] { parse_plan(text, "p.toml"); });
  };
  CHECK_THAT(changed("growth*prey", "grwoth*prey"),
             Contains("p.toml:10") && Contains("there is no \"grwoth\"; did you mean \"growth\"?"));
  CHECK_THAT(changed("gain*meetings", "gain + meetings"), Contains("p.toml:11") && Contains("equal units"));
  CHECK_THAT(changed("\"prey*predator\"", "\"prey*\""),
             Contains("p.toml:9") && Contains("the expression ends"));
  CHECK_THAT(changed("rates.predator", "rates.predators"), Contains("predators"));
  CHECK_THAT(changed("rates.predator = \"gain*meetings - death*predator\"", ""), Contains("predator"));
  CHECK_THAT(changed("default = 0.05", "default = '5 cm'"), Contains("p.toml:7"));
  CHECK_THAT(changed("above = 0", "above = nan"), Contains("p.toml:5"));
  CHECK_THAT(changed("above = 0", "beyond = 0"), Contains("beyond"));
  CHECK_THAT(changed("name = \"hunters\"", "name = 'vertical_fall'"), Contains("another model"));
  CHECK_THAT(changed("[equations]", "model = 'vertical_fall'\n[equations]"), Contains("one of the two"));
  CHECK_THAT(changed("states.prey = { initial = 10 }", "states.prey = { initial = inf }"),
             Contains("p.toml:3"));
}

TEST_CASE("a request that makes no plan is refused") {
  const auto refused = [](const std::function<void(BuildRequest&)>& change) {
    OwnQuestion asked;
    change(asked.request);
    return error_text<ArgumentError>([&] { build(asked.model, asked.request); });
  };
  CHECK_THAT(refused([](BuildRequest& r) { r.box.pop_back(); }), Contains("\"hunt\" has no interval"));
  CHECK_THAT(refused([](BuildRequest& r) { r.box.push_back(r.box.front()); }), Contains("\"growth\""));
  CHECK_THAT(refused([](BuildRequest& r) { r.box.push_back({.name = "death", .lower = 0.1, .upper = 1.0}); }),
             Contains("\"death\", which is no free coordinate"));
  CHECK_THAT(refused([](BuildRequest& r) { r.box[0].upper = std::nan(""); }), Contains("growth"));
  CHECK_THAT(refused([](BuildRequest& r) { r.box[0].lower = -1.0; }), Contains("growth"));
  CHECK_THAT(refused([](BuildRequest& r) { r.end = 0.0; }), Contains("end"));
  CHECK_THAT(refused([](BuildRequest& r) { r.relative = 2.0; }), Contains("relative"));
  CHECK_THAT(refused([](BuildRequest& r) { r.builder.kind = "magic"; }), Contains("magic"));
}

TEST_CASE("what a model derives is asked for by name, in any order, with derivatives and held coordinates") {
  const std::string outputs = R"toml(outputs.all = "prey + predator"
outputs.hunted = { value = "hunt*prey*predator*(1 + 0.1 [1/s]*t)", unit = "1/s" }
)toml";
  const Codebook book = build(parse_plan(kEquations + outputs + kBox, "hunters.toml"), few()).book;
  DerivedQuery everything(book);
  std::vector<std::string> names;
  for (const auto& label : everything.outputs()) names.push_back(label.name + " " + label.unit);
  CHECK(names == std::vector<std::string>{"prey 1", "predator 1", "all 1", "hunted 1/s"});
  const std::vector<double> point = {2.3, 1.04, 0.093};  // t, growth, hunt
  Eigen::VectorXd y(4);
  everything.values(point, y);
  CHECK(y[2] == Approx(y[0] + y[1]).epsilon(1e-14));
  CHECK(y[3] == Approx(0.093 * y[0] * y[1] * 1.23).epsilon(1e-14));

  DerivedQuery some(book, {.outputs = {"hunted", "prey"}});
  Eigen::VectorXd z(2), above(2), below(2);
  Eigen::MatrixXd slopes(2, 3);
  some.values(point, z, slopes);
  CHECK(z[0] == y[3]);
  CHECK(z[1] == y[0]);
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> moved = point;
    const double step = 1e-6 * point[k];
    moved[k] += step;
    some.values(moved, above);
    moved[k] -= 2.0 * step;
    some.values(moved, below);
    for (Eigen::Index o = 0; o < 2; ++o) {
      const double difference = (above[o] - below[o]) / (2.0 * step);
      CHECK(slopes(o, static_cast<Eigen::Index>(k)) == Approx(difference).epsilon(1e-6).margin(1e-6));
    }
  }

  DerivedQuery held(book, {.outputs = {"hunted"}, .fixed = {{"t", 2.3}, {"hunt", 0.093}}});
  REQUIRE(held.coordinates().size() == 1);
  Eigen::VectorXd one(1);
  Eigen::MatrixXd by_growth(1, 1);
  held.values(std::vector{1.04}, one, by_growth);
  CHECK(one[0] == Approx(z[0]).epsilon(1e-13));
  CHECK(by_growth(0, 0) == Approx(slopes(0, 1)).epsilon(1e-12));

  using Names = std::vector<std::string>;
  CHECK_THROWS_WITH(DerivedQuery(book, {.outputs = Names{"all", "prey", "all"}}), Contains("chosen twice"));
  CHECK_THROWS_WITH(DerivedQuery(book, {.outputs = Names{"weight"}}),
                    Contains("no output \"weight\"; known: prey, predator, all, hunted"));
  CHECK_THROWS_WITH(book.output_index("all"), Contains("one that is stored was expected: prey, predator"));
  CHECK_THROWS_AS(some.values(std::vector{2.3, 1.2, 0.093}, z), samara::OutsideBoxError);
}

TEST_CASE("what a model derives is the same where trajectories come from a codebook and from an integrator") {
  const std::string outputs = R"toml(outputs.all = "prey + predator"
outputs.hunted = { value = "hunt*prey*predator*(1 + 0.1 [1/s]*t)", unit = "1/s" }
)toml";
  const Codebook book = build(parse_plan(kEquations + outputs + kBox, "hunters.toml"), few()).book;
  const std::map<std::string, double> held = {{"gain", 0.05}, {"death", 0.5}};
  const auto integrated = [&] {
    return models::reference_trajectories(model_of(book).shared_model(), held,
                                          {{"growth", {0.5, 1.5}}, {"hunt", {0.09, 0.11}}});
  };
  const auto mixed = mixed_trajectories(book, integrated());
  const std::vector<std::string> all = {"prey", "predator", "all", "hunted"};
  CHECK(models::output_names(mixed->info()) == all);
  const std::vector<double> times = {0.5, 2.0, 5.0};
  const std::vector<std::string> wanted = {"hunted", "prey", "all"};
  const auto answers = [&](const models::TrajectoryFamily& family, const std::vector<double>& q) {
    return models::trajectory(family, q, times, wanted, models::Derivatives::yes);
  };
  const std::vector<double> inside = {1.04, 0.093}, outside = {1.3, 0.093};
  const auto of_book = answers(*codebook_trajectories(book), inside), both = answers(*mixed, inside);
  CHECK(both.values == of_book.values);
  CHECK(both.derivatives == of_book.derivatives);
  const auto exact = answers(*integrated(), outside), beyond = answers(*mixed, outside);
  CHECK(beyond.values == exact.values);
  CHECK(beyond.derivatives == exact.derivatives);
  // Where both answer they differ by the codebook's error, 1e-5 of ranges of ten.
  CHECK((answers(*integrated(), inside).values - both.values).cwiseAbs().maxCoeff() < 1e-3);
}

TEST_CASE("models that are added are known by their names, and take nobody else's") {
  const auto model = models::make_model<PredatorPrey>();
  models::add_model(model);
  models::add_model(model);
  CHECK(models::find_model("predator_prey_law") == model);
  CHECK_THAT(error_text<ArgumentError>([] { models::add_model(models::make_model<PredatorPrey>()); }),
             Contains("another model \"predator_prey_law\""));
  CHECK_THAT(error_text<ArgumentError>([] { models::add_model(nullptr); }), Contains("null pointer"));
}
