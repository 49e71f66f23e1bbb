// Fronts in boxes of builds by steps: followed by elements, or counted from.
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "../io/temporary_directory.h"
#include "samara/codebooks/book/book_model.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/statistics/book_statistics.h"
#include "samara/models/integrators/integrate.h"
#include "samara/pgd/tensors/random.h"
#include "same_codebook.h"
#include "sample_books.h"
#include "stepped_builds.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;

namespace {

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

}  // namespace

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

  // Points of our own about the front, where the certificate has few. Slopes there are about e^(rate end) = 50; those
  // of a polynomial err by its error times the square of its degree over half of an element.
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
  const TemporaryDirectory directory;
  save(result.book, directory / "counted.h5");
  check_same_codebook(load(directory / "counted.h5"), result.book);

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
