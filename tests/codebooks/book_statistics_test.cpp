#include "samara/codebooks/statistics/book_statistics.h"

#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "samara/base/errors.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/statistics/input_draws.h"
#include "sample_books.h"

using namespace samara;
using namespace samara::codebooks;
using Catch::Contains;

namespace {

constexpr auto kNormal = DistributionKind::normal;
constexpr auto kLogNormal = DistributionKind::log_normal;
constexpr auto kUniform = DistributionKind::uniform;

/// Of the standard normal distribution, below which lie 5 and 95 %.
constexpr double kFivePercent = -1.6448536269514722;

Eigen::Index row_of(const Codebook& book, const std::string& output) {
  return book.output_index(output);
}

const OutputStatistics& of(const BookStatistics& s, const Codebook& book, const std::string& output) {
  return s.outputs[static_cast<std::size_t>(row_of(book, output))];
}

std::string refusal(const Codebook& book, const StatisticsRequest& request) {
  return error_text<Error>([&] { take_statistics(book, request); });
}

/// One output u, the same all over the axes.
Piece constant_piece(const std::vector<pgd::Axis>& axes, double value) {
  std::vector<Eigen::MatrixXd> factors;
  for (const pgd::Axis& axis : axes) factors.emplace_back(Eigen::MatrixXd::Ones(axis.size(), 1));
  return Piece::Groups{
      pgd::SeparatedField(axes, {{"u", "m"}}, factors, Eigen::RowVectorXd::Constant(1, value))};
}

/// Of a model that this program does not know, and that may do without time.
Codebook book_of(const std::vector<Piece>& pieces) {
  ModelDescription model;
  model.name = "constants";
  return Codebook(model, pieces);
}

pgd::Axis t_axis(double lower, double upper) {
  return pgd::Axis::radau({"t", "s", pgd::AxisRole::time}, lower, upper, 1, 2);
}
pgd::Axis x_axis(double lower, double upper) {
  return pgd::Axis::p1({"x", "m"}, lower, upper, 2);
}
pgd::Axis plies_axis(const std::vector<double>& values) {
  return pgd::Axis::discrete(
      {"plies"}, Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
}

}  // namespace

TEST_CASE(
    "the distribution function and its inverse undo each other, and the rule integrates what lies on the "
    "axis",
    "[codebooks]") {
  const auto axis = pgd::Axis::chebyshev({"x"}, 0.5, 2.5, 9);
  for (const Distribution& d : {Distribution{kUniform, 0.75, 2.0}, Distribution{kNormal, 1.4, 0.1},
                                Distribution{kNormal, 2.4, 0.02}, Distribution{kLogNormal, 1.2, 0.3}}) {
    INFO(to_string(d));
    for (const double share : {0.001, 0.2, 0.5, 0.9, 0.9999})
      CHECK(probability_below(d, quantile_of(d, share)) == Approx(share).epsilon(1e-12));
    const pgd::QuadratureRule rule = rule_of(d, axis);
    CHECK(rule.weights.sum() == Approx(1.0).epsilon(1e-14));
    CHECK(rule.nodes.minCoeff() >= axis.lower());
    CHECK(rule.nodes.maxCoeff() <= axis.upper());
    // E[x 1(x < c)] needs a border of its own; E[x], E[x^2] by the distribution function: E[g] = g(b) - int g' F.
    const double below = probability_below(d, axis.lower()),
                 inside = probability_below(d, axis.upper()) - below;
    double mean = axis.upper(), square = axis.upper() * axis.upper();
    constexpr int kSteps = 2'000'000;
    const double step = axis.length() / kSteps;
    for (int k = 0; k < kSteps; ++k) {
      const double x = axis.lower() + (k + 0.5) * step, f = (probability_below(d, x) - below) / inside;
      mean -= f * step;
      square -= 2.0 * x * f * step;
    }
    CHECK(rule.weights.dot(rule.nodes) == Approx(mean).epsilon(1e-9));
    CHECK(rule.weights.dot(rule.nodes.cwiseAbs2()) == Approx(square).epsilon(1e-9));
  }
}

TEST_CASE(
    "a uniform distribution over all of an axis is what the axis itself integrates, whatever its transform") {
  using pgd::Axis;
  using pgd::Transform;
  const auto role = pgd::AxisRole::parameter;
  for (const Axis& axis : {Axis::chebyshev({"x"}, -1.0, 3.0, 12),
                           Axis::chebyshev({"x", "1", role, Transform::logarithm}, 1e-4, 10.0, 24),
                           Axis::chebyshev({"x", "1", role, Transform::reciprocal}, 0.1, 20.0, 24),
                           Axis::chebyshev({"x", "1", role, Transform::square_root}, 0.0, 4.0, 16),
                           Axis::p2({"x"}, 0.0, 1.0, 5), Axis::fourier({"x"}, 0.0, 2.0, 9)}) {
    const pgd::QuadratureRule rule = rule_of({kUniform, axis.lower(), axis.upper()}, axis);
    pgd::InterpolationStencil stencil = axis.make_stencil();
    Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(axis.size(), axis.size());
    for (Eigen::Index i = 0; i < rule.nodes.size(); ++i) {
      axis.interpolate(rule.nodes[i], stencil, false);
      const auto at = Eigen::seqN(stencil.first, stencil.value.size());
      mass(at, at) += rule.weights[i] * stencil.value * stencil.value.transpose();
    }
    INFO(pgd::to_string(axis.basis()) << " " << pgd::to_string(axis.transform()));
    CHECK((mass - Eigen::MatrixXd(axis.mass()) / axis.measure()).cwiseAbs().maxCoeff() < 1e-11);
  }
}

TEST_CASE("means, deviations, indices and quantiles of normal and uniform inputs are those in closed form",
          "[codebooks]") {
  // v = v(0) + C_D t and x = v(0) t + C_D t^2/2; what of the bell lies outside [-1, 2] does not count in doubles.
  const Codebook book = golden_book();
  const double mean = 0.5, deviation = 0.15;
  const BookStatistics s = take_statistics(book, {.inputs = {{"C_D", {kNormal, mean, deviation}}},
                                                  .groups = {{"C_D", "v(0)"}, {"v(0)"}},
                                                  .quantiles = {0.5}});
  CHECK(s.inputs == std::vector<std::string>{"C_D", "v(0)"});
  for (const std::string& note : s.notes) CHECK_THAT(note, !Contains("outside"));
  const OutputStatistics &v = of(s, book, "v"), &x = of(s, book, "x");
  for (Eigen::Index i = 0; i < s.times.size(); ++i) {
    const double t = s.times[i], by_C_D = std::pow(deviation * t, 2), by_start = 1.0 / 12.0;
    CHECK(v.mean[i] == Approx(0.5 + mean * t).margin(1e-12));
    CHECK(v.deviation[i] == Approx(std::sqrt(by_C_D + by_start)).margin(1e-12));
    CHECK(v.first_order(i, 0) == Approx(by_C_D / (by_C_D + by_start)).margin(1e-11));
    CHECK(v.total(i, 1) == Approx(by_start / (by_C_D + by_start)).margin(1e-11));
    CHECK(v.group_closed(i, 0) == Approx(1.0).margin(1e-11));
    CHECK(v.group_total(i, 1) == Approx(v.total(i, 1)).margin(1e-12));
    // Both inputs are symmetric, so is their sum: its median is its mean.
    CHECK(v.quantiles(i, 0) == Approx(v.mean[i]).margin(0.01));
    CHECK(x.mean[i] == Approx(0.5 * t + 0.5 * mean * t * t).margin(1e-12));
  }
  const BookStatistics held = take_statistics(book, {.inputs = {{"C_D", {kNormal, mean, deviation}}},
                                                     .fixed = {{"v(0)", 0.25}},
                                                     .quantiles = {0.05, 0.95}});
  CHECK(held.inputs == std::vector<std::string>{"C_D"});
  for (Eigen::Index i = 0; i < held.times.size(); ++i) {
    const double t = held.times[i], reach = -kFivePercent * deviation * t;
    CHECK(of(held, book, "v").quantiles(i, 0) ==
          Approx(0.25 + mean * t - reach).margin(2e-3 * deviation * t));
    CHECK(of(held, book, "v").quantiles(i, 1) ==
          Approx(0.25 + mean * t + reach).margin(2e-3 * deviation * t));
  }
}

TEST_CASE("trains and sums of products have the same statistics", "[codebooks]") {
  const StatisticsRequest request{.inputs = {{"C_D", {kNormal, 0.3, 0.4}}, {"v(0)", {kUniform, 0.2, 0.7}}},
                                  .quantiles = {0.1}};
  const BookStatistics a = take_statistics(golden_book(), request),
                       b = take_statistics(golden_trains(), request);
  REQUIRE(a.outputs.size() == b.outputs.size());
  for (std::size_t o = 0; o < a.outputs.size(); ++o) {
    CHECK((a.outputs[o].mean - b.outputs[o].mean).cwiseAbs().maxCoeff() < 1e-12);
    CHECK((a.outputs[o].deviation - b.outputs[o].deviation).cwiseAbs().maxCoeff() < 1e-12);
    CHECK((a.outputs[o].quantiles - b.outputs[o].quantiles).cwiseAbs().maxCoeff() < 1e-12);
  }
}

TEST_CASE("of a box in cells, integrals by parts agree with averages of random points", "[codebooks]") {
  const Codebook book = four_pieces();
  const Coordinate start = book.coordinates()[2];
  const StatisticsRequest request{.inputs = {{"C_D", {kNormal, 1.05, 0.2}}}};
  const BookStatistics s = take_statistics(book, request);
  CHECK(s.inputs.empty());
  REQUIRE_FALSE(s.notes.empty());
  std::mt19937 random(73);
  std::normal_distribution<double> C_D(1.05, 0.2);
  std::uniform_real_distribution<double> v(start.lower, start.upper);
  Query query(book);
  Eigen::VectorXd values(book.output_count());
  for (const Eigen::Index i : {s.times.size() / 3, s.times.size() - 1}) {
    constexpr int kDraws = 40'000;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(book.output_count()), squares = sum;
    for (int k = 0; k < kDraws;) {
      const double drag = C_D(random);
      if (drag < book.coordinates()[1].lower || drag > book.coordinates()[1].upper) continue;
      query.values(std::vector<double>{s.times[i], drag, v(random)}, values);
      sum += values;
      squares += values.cwiseAbs2();
      ++k;
    }
    for (Eigen::Index o = 0; o < sum.size(); ++o) {
      const double mean = sum[o] / kDraws, deviation = std::sqrt(squares[o] / kDraws - mean * mean);
      const OutputStatistics& output = s.outputs[static_cast<std::size_t>(o)];
      CHECK(output.mean[i] == Approx(mean).margin(5.0 * deviation / std::sqrt(kDraws)));
      CHECK(output.deviation[i] == Approx(deviation).epsilon(0.03));
    }
  }
}

TEST_CASE("held where cells with slabs of their own meet, statistics are those of what queries answer",
          "[codebooks]") {
  const Codebook book(sample_model(), {random_piece({0.0, kSlabBorder, 0.5, kCellBorder}, 1),
                                       random_piece({kSlabBorder, 0.5, 0.5, kCellBorder}, 2),
                                       random_piece({0.0, 0.5, kCellBorder, 2.0}, 3)});
  const std::map<std::string, double> held = {{"C_D", kCellBorder}};
  const BookStatistics s = take_statistics(book, {.fixed = held});
  Query query(book, {.outputs = {"E"}, .fixed = held});
  // Linear in v(0) between the nodes: the mean is that of trapezoids.
  const Eigen::VectorXd nodes = book.pieces().front().groups().front().axes()[2].nodes();
  for (Eigen::Index i = 0; i < s.times.size(); ++i) {
    CHECK((i == 0 || s.times[i - 1] < s.times[i]));
    Eigen::VectorXd value(1);
    double mean = 0.0, before = 0.0;
    for (Eigen::Index j = 0; j < nodes.size(); ++j) {
      query.values(std::vector<double>{s.times[i], nodes[j]}, value);
      if (j > 0) mean += 0.5 * (before + value[0]) * (nodes[j] - nodes[j - 1]);
      before = value[0];
    }
    mean /= nodes[nodes.size() - 1] - nodes[0];
    CHECK(of(s, book, "E").mean[i] == Approx(mean).margin(1e-12));
  }
}

TEST_CASE("inputs that are normal together have the deviation that their covariance gives a sum",
          "[codebooks]") {
  const Codebook book = golden_book();
  Eigen::Matrix2d covariance;
  covariance << 0.01, -0.008, -0.008, 0.01;
  const BookStatistics s = take_statistics(
      book,
      {.quantiles = {0.05}, .joint = JointNormal{{"C_D", "v(0)"}, Eigen::Vector2d(0.5, 0.5), covariance}});
  CHECK(s.inputs.empty());
  CHECK_THAT(s.notes.front(), Contains("correlated"));
  const OutputStatistics& v = of(s, book, "v");
  for (Eigen::Index i = 0; i < s.times.size(); ++i) {
    const double t = s.times[i];
    const double deviation = std::sqrt(0.01 * t * t - 2.0 * 0.008 * t + 0.01);
    CHECK(v.mean[i] == Approx(0.5 + 0.5 * t).margin(0.002));
    CHECK(v.deviation[i] == Approx(deviation).epsilon(0.01));
    CHECK(v.quantiles(i, 0) == Approx(0.5 + 0.5 * t + kFivePercent * deviation).margin(0.02 * deviation));
  }
}

TEST_CASE(
    "draws of inputs that are normal together have their covariance, however far apart their scales are",
    "[codebooks]") {
  const auto axis = [](const char* name, double reach) { return pgd::Axis::p1({name}, -reach, reach, 2); };
  const Codebook book = book_of({constant_piece({axis("a", 1.0), axis("b", 1e-6), axis("c", 20.0)}, 1.0)});
  const Eigen::Vector3d deviations(0.05, 1e-8, 1.0);
  Eigen::Matrix3d correlation;
  correlation << 1.0, 0.3, 0.5, 0.3, 1.0, 0.4, 0.5, 0.4, 1.0;
  const Eigen::MatrixXd covariance = deviations.asDiagonal() * correlation * deviations.asDiagonal();
  const InputDraws draws = draw_inputs(
      book,
      {.joint = JointNormal{{"a", "b", "c"}, Eigen::Vector3d(0.1, 0.0, -2.0), covariance}, .draws = 16'384});
  REQUIRE(draws.points.cols() == 16'384);
  const Eigen::VectorXd mean = draws.points.rowwise().mean();
  const Eigen::MatrixXd centred = draws.points.colwise() - mean;
  const Eigen::MatrixXd found = centred * centred.transpose() / static_cast<double>(centred.cols());
  // Random points would be off by about 1/sqrt(16384) = 0.008, these are closer.
  for (Eigen::Index i = 0; i < 3; ++i) {
    CHECK(std::sqrt(found(i, i)) == Approx(deviations[i]).epsilon(0.01));
    for (Eigen::Index j = 0; j < i; ++j)
      CHECK(found(i, j) / std::sqrt(found(i, i) * found(j, j)) == Approx(correlation(i, j)).margin(0.01));
  }
}

TEST_CASE("a matrix that is no covariance is refused") {
  const auto refusal_of = [](double a, double upper, double lower, double b) {
    Eigen::Matrix2d covariance;
    covariance << a, upper, lower, b;
    return refusal(golden_book(),
                   {.joint = JointNormal{{"C_D", "v(0)"}, Eigen::Vector2d(0.5, 0.5), covariance}});
  };
  CHECK_THAT(refusal_of(1.0, 0.0, 0.0, -1e-11), Contains("gives \"v(0)\" the variance -1e-11"));
  CHECK_THAT(refusal_of(1.0, 0.9, 0.0, 1.0),
             Contains("\"C_D\" and \"v(0)\" have the covariance 0.9 above the diagonal and 0 below it"));
  CHECK_THAT(refusal_of(1.0, 1e-3, 1e-3, 0.0), Contains("expected 0 beside a variance of 0"));
  CHECK_THAT(refusal_of(1.0, std::nan(""), std::nan(""), 1.0), Contains("finite"));
  CHECK_THAT(refusal_of(1e-16, 1.1e-8, 1.1e-8, 1.0), Contains("negative variance"));
  CHECK(refusal_of(1e-4, 0.0, 0.0, 0.0) == "no exception");
}

TEST_CASE("where pieces overlap, the one that queries come to counts") {
  SECTION("without time") {
    const BookStatistics s = take_statistics(
        book_of({constant_piece({x_axis(0.0, 2.0)}, 1.0), constant_piece({x_axis(1.0, 3.0)}, 4.0)}));
    // Two thirds of 1 and a third of 4.
    CHECK(s.outputs[0].mean[0] == Approx(2.0).epsilon(1e-12));
    CHECK(s.outputs[0].deviation[0] == Approx(std::sqrt(2.0)).epsilon(1e-12));
  }
  SECTION("as slabs over the whole box, with each time once") {
    const BookStatistics s =
        take_statistics(book_of({constant_piece({t_axis(0.0, 2.0), x_axis(0.0, 1.0)}, 1.0),
                                 constant_piece({t_axis(1.0, 3.0), x_axis(0.0, 1.0)}, 4.0)}));
    CHECK(s.inputs == std::vector<std::string>{"x"});
    REQUIRE(s.outputs[0].mean.size() == s.times.size());
    for (Eigen::Index i = 0; i < s.times.size(); ++i) {
      CHECK((i == 0 || s.times[i - 1] < s.times[i]));
      CHECK(s.outputs[0].mean[i] == Approx(s.times[i] <= 2.0 ? 1.0 : 4.0).epsilon(1e-12));
    }
  }
  SECTION("as cells in time") {
    const BookStatistics s =
        take_statistics(book_of({constant_piece({t_axis(0.0, 2.0), x_axis(0.0, 1.0)}, 1.0),
                                 constant_piece({t_axis(1.0, 3.0), x_axis(0.5, 1.5)}, 4.0)}));
    for (Eigen::Index i = 0; i < s.times.size(); ++i) {
      const double t = s.times[i];
      CHECK((i == 0 || s.times[i - 1] < t));
      // Together x from 0 to 1 of the first piece, and from 1 to 1.5 of the second.
      const double expected = t < 1.0 ? 1.0 : t <= 2.0 ? 2.0 : 4.0;
      CHECK(s.outputs[0].mean[i] == Approx(expected).epsilon(1e-12));
    }
  }
}

TEST_CASE("what pieces share that a period keeps whole is said to count twice") {
  const auto angle = [](double period) { return pgd::Axis::fourier({"angle", "rad"}, 0.0, period, 3); };
  const BookStatistics s =
      take_statistics(book_of({constant_piece({angle(1.0)}, 1.0), constant_piece({angle(2.0)}, 4.0)}));
  REQUIRE_FALSE(s.notes.empty());
  CHECK_THAT(s.notes.back(), Contains("counts more than once"));
}

TEST_CASE("a distribution that lies in a gap between pieces is refused") {
  const Codebook book =
      book_of({constant_piece({x_axis(0.0, 1.0)}, 1.0), constant_piece({x_axis(2.0, 3.0)}, 4.0)});
  CHECK_THAT(refusal(book, {.inputs = {{"x", {kUniform, 1.2, 1.8}}}}),
             Contains("less than 1e-14 of the distribution"));
}

TEST_CASE("every value of a list counts alike, in whichever pieces the values stand") {
  const auto statistics_of = [](const std::vector<double>& first, const std::vector<double>& second) {
    const pgd::Axis x = x_axis(0.0, 1.0);
    return take_statistics(
        book_of({constant_piece({plies_axis(first), x}, 1.0), constant_piece({plies_axis(second), x}, 4.0)}),
        {.quantiles = {0.2, 0.9}});
  };
  const BookStatistics singles = statistics_of({1.0}, {2.0});
  CHECK(singles.outputs[0].mean[0] == Approx(2.5).epsilon(1e-12));
  CHECK(singles.outputs[0].deviation[0] == Approx(1.5).epsilon(1e-12));
  CHECK(singles.outputs[0].quantiles(0, 0) == Approx(1.0));
  CHECK(singles.outputs[0].quantiles(0, 1) == Approx(4.0));
  CHECK(statistics_of({1.0, 5.0}, {2.0}).outputs[0].mean[0] == Approx(2.0).epsilon(1e-12));
  // The first piece answers where both have a value.
  CHECK(statistics_of({1.0, 2.0}, {2.0, 3.0}).outputs[0].mean[0] == Approx(2.0).epsilon(1e-12));
}

TEST_CASE("a list of one value counts in cells along another coordinate, and over time") {
  const pgd::Axis plies = plies_axis({3.0});
  const BookStatistics s = take_statistics(book_of(
      {constant_piece({plies, x_axis(0.0, 1.0)}, 1.0), constant_piece({plies, x_axis(1.0, 3.0)}, 4.0)}));
  CHECK(s.outputs[0].mean[0] == Approx(3.0).epsilon(1e-12));
  const BookStatistics over_time =
      take_statistics(book_of({constant_piece({t_axis(0.0, 1.0), plies_axis({1.0})}, 1.0),
                               constant_piece({t_axis(0.0, 1.0), plies_axis({2.0, 3.0})}, 4.0)}));
  for (const double mean : over_time.outputs[0].mean) CHECK(mean == Approx(3.0).epsilon(1e-12));
}

TEST_CASE("where a held value leaves some pieces, draws take the values of their lists") {
  const pgd::Axis y = pgd::Axis::p1({"y"}, 0.0, 1.0, 2);
  const BookStatistics s =
      take_statistics(book_of({constant_piece({plies_axis({1.0}), x_axis(0.0, 1.0), y}, 1.0),
                               constant_piece({plies_axis({2.0}), x_axis(1.0, 3.0), y}, 4.0)}),
                      {.fixed = {{"x", 2.0}}, .quantiles = {0.5}});
  CHECK(s.outputs[0].mean[0] == Approx(4.0));
  CHECK(s.outputs[0].quantiles(0, 0) == Approx(4.0));
}

TEST_CASE("a coordinate that is a list in one piece and an interval in another has no statistics") {
  const pgd::Axis x = x_axis(0.0, 1.0), interval = pgd::Axis::p1({"plies"}, 2.0, 3.0, 2);
  CHECK_THAT(
      refusal(book_of({constant_piece({plies_axis({1.0}), x}, 1.0), constant_piece({interval, x}, 4.0)}), {}),
      Contains("a list of values in one piece"));
}

TEST_CASE("a list is held at one of its values, and nothing without meaning is taken", "[codebooks]") {
  const Codebook kinds = all_kinds(), book = golden_book();
  const BookStatistics two = take_statistics(kinds, {.fixed = {{"plies", 2.0}, {"k", 0.5}}});
  CHECK(std::ranges::find(two.inputs, "plies") == two.inputs.end());
  CHECK_THAT(refusal(kinds, {.inputs = {{"plies", {kNormal, 2.0, 1.0}}}}), Contains("list of values"));
  const JointNormal joint{{"v(0)", "m"}, Eigen::Vector2d(0.5, 2.0), 0.01 * Eigen::Matrix2d::Identity()};
  CHECK_THAT(refusal(kinds, {.inputs = {{"plies", {kNormal, 2.0, 1.0}}}, .joint = joint}),
             Contains("list of values"));
  CHECK_THAT(refusal(book, {.inputs = {{"C_D", {kLogNormal, 0.5, 1e9}}}}), Contains("at most 100"));
  CHECK_THAT(refusal(book, {.inputs = {{"C_d", {}}}}), Contains("did you mean \"C_D\""));
  CHECK_THAT(refusal(book, {.inputs = {{"t", {}}}}), Contains("is the time"));
  CHECK_THAT(refusal(book, {.inputs = {{"C_D", {kNormal, 5.0, 0.1}}}}),
             Contains("outside the codebook's box"));
  CHECK_THAT(refusal(book, {.inputs = {{"C_D", {kNormal, 0.5, 0.0}}}}), Contains("deviation above 0"));
  CHECK_THAT(refusal(book, {.inputs = {{"C_D", {kUniform, 0.5, 0.5}}}}), Contains("below the largest"));
  CHECK_THAT(refusal(book, {.inputs = {{"C_D", {kNormal, std::nan(""), 1.0}}}}), Contains("finite"));
  CHECK_THAT(refusal(book, {.fixed = {{"C_D", 3.0}}}), Contains("outside the codebook's box"));
  CHECK_THAT(refusal(book, {.fixed = {{"C_D", 1.0}, {"v(0)", 0.5}}}), Contains("no free parameter"));
  CHECK_THAT(refusal(book, {.inputs = {{"C_D", {}}}, .fixed = {{"C_D", 0.5}}}), Contains("is held"));
  CHECK_THAT(refusal(book, {.quantiles = {1.0}}), Contains("above 0 and below 1"));
  CHECK_THAT(refusal(book, {.quantiles = {0.5, 0.5}}), Contains("the quantile at 0.5 is asked for twice"));
  CHECK_THAT(refusal(book, {.groups = {{"C_D", "C_D"}}}), Contains("twice"));
  CHECK_THAT(refusal(book, {.draws = 5}), Contains("draws"));
  Eigen::Matrix2d wrong;
  wrong << 1.0, 2.0, 2.0, 1.0;
  CHECK_THAT(refusal(book, {.joint = JointNormal{{"C_D", "v(0)"}, Eigen::Vector2d(0.5, 0.5), wrong}}),
             Contains("negative variance"));
}

TEST_CASE("quantiles of a list of values count each by its weight") {
  // u = v(0) sqrt(m) + t log(C_D) cos(2 angle) plies + k^2/h: with all else held, linear in plies, which are 1, 2, 4.
  const Codebook book = all_kinds();
  const BookStatistics s = take_statistics(
      book, {.fixed = {{"C_D", 1.5}, {"angle", 0.25}, {"v(0)", 0.5}, {"m", 1.0}, {"k", 0.5}, {"h", 2.0}},
             .quantiles = {0.2, 0.5, 0.9}});
  const Eigen::Index last = s.times.size() - 1;
  for (const auto& [q, plies] : {std::pair{0, 1.0}, {1, 2.0}, {2, 4.0}}) {
    const double value = 0.5 + s.times[last] * std::log(1.5) * std::cos(0.5) * plies + 0.125;
    CHECK(s.outputs[0].quantiles(last, q) == Approx(value).epsilon(1e-6));
  }
}

TEST_CASE("what lies outside the box is left out, and said", "[codebooks]") {
  const Codebook book = golden_book();
  const BookStatistics s = take_statistics(book, {.inputs = {{"C_D", {kNormal, 1.5, 0.5}}}});
  REQUIRE_FALSE(s.notes.empty());
  CHECK_THAT(s.notes.front(), Contains("15.9 %"));
  // Of a normal distribution cut at one deviation above its mean, the mean is phi(1)/Phi(1) deviations lower.
  const double phi = std::exp(-0.5) / std::sqrt(2.0 * 3.14159265358979323846), below = 0.841344746068543;
  const Eigen::Index last = s.times.size() - 1;
  CHECK(of(s, book, "v").mean[last] == Approx(0.5 + s.times[last] * (1.5 - 0.5 * phi / below)).epsilon(1e-6));
}
