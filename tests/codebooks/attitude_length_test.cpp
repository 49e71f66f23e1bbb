#include "samara/codebooks/book/attitude_length.h"

#include <cmath>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "flat_answers.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"

using namespace samara::codebooks;
using samara::pgd::Axis;
using samara::pgd::AxisRole;

namespace {

constexpr int kTimes = 3;

/// A body's attitude, nearly of the length 2 with which it begins, and a place; t in [0, 1] and two
/// coefficients.
Codebook body_book(const std::string& axis = "C_T") {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> number(-0.02, 0.02);
  const std::vector<Axis> axes = {Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 2, 3),
                                  Axis::chebyshev({axis}, 0.0, 1.0, 4),
                                  Axis::chebyshev({"C_R"}, 0.0, 1.0, 4)};
  std::vector<Eigen::MatrixXd> factors;
  for (const Axis& a : axes) {
    Eigen::MatrixXd factor = Eigen::MatrixXd::NullaryExpr(a.size(), 3, [&] { return 25.0 * number(engine); });
    factor.col(0).setOnes();
    factors.push_back(factor);
  }
  Eigen::MatrixXd weights = Eigen::MatrixXd::NullaryExpr(5, 3, [&] { return 50.0 * number(engine); });
  weights.col(0) << 1.21, 0.0, 1.61, 0.0, 0.3;
  ModelDescription model;
  model.name = "immersed_body";
  model.fixed = {{"qw(0)", 1.2}, {"qx(0)", 0.0}, {"qy(0)", 1.6}, {"qz(0)", 0.0}};
  if (axis == "qx(0)") model.fixed.erase(axis);
  return Codebook(model, {Piece{{samara::pgd::SeparatedField(
                             axes, {{"qw"}, {"qx"}, {"qy"}, {"qz"}, {"x", "m"}}, factors, weights)}}});
}

}  // namespace

TEST_CASE("an attitude has the length with which it began, and derivatives of such a one") {
  const Codebook book = body_book();
  Query query(book);
  Eigen::VectorXd values(5), raw(5), ahead(5), behind(5);
  Eigen::MatrixXd gradient(5, 3), hessian(5, 9), left(5, 3), right(5, 3);
  std::vector<double> x = {0.37, 0.21, 0.83};
  query.values(x, values, gradient, hessian);
  FieldGroup::Workspace workspace = book.pieces()[0].groups()[0].make_workspace();
  book.pieces()[0].groups()[0].evaluate(x, raw, workspace);
  REQUIRE(std::abs(raw.head<4>().norm() - 2.0) > 1e-3);
  CHECK(values.head<4>().norm() == Approx(2.0).epsilon(1e-14));
  CHECK((values.head<4>().normalized() - raw.head<4>().normalized()).norm() < 1e-14);
  CHECK(values[4] == Approx(raw[4]).epsilon(1e-14));
  // Differences over 2e-5: their own error is of the order of 1e-10 times a third derivative.
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 3; ++k) {
    const auto at = static_cast<std::size_t>(k);
    x[at] += kStep;
    query.values(x, ahead, right);
    x[at] -= 2.0 * kStep;
    query.values(x, behind, left);
    x[at] += kStep;
    CHECK(((ahead - behind) / (2.0 * kStep) - gradient.col(k)).cwiseAbs().maxCoeff() < 1e-7);
    for (int j = 0; j < 3; ++j)
      CHECK(((right - left).col(j) / (2.0 * kStep) - hessian.col(j + 3 * k)).cwiseAbs().maxCoeff() < 1e-6);
  }
}

TEST_CASE("batches and trajectories give attitudes the same length as points do") {
  const Codebook book = body_book();
  const std::vector<double> times = {0.1, 0.5, 1.0};
  Query query(book, {.outputs = {"x", "qz", "qy", "qx", "qw"}});
  TrajectoryQuery frames(book, times, {"x", "qz", "qy", "qx", "qw"});
  const Eigen::MatrixXd q = Eigen::MatrixXd::Random(2, 40).cwiseAbs();
  Eigen::MatrixXd points(3, 40), all(5, 40), paths(5 * kTimes, 40), path(kTimes, 5), slopes(kTimes, 10);
  points.bottomRows(2) = q;
  Eigen::VectorXd values(5);
  Eigen::MatrixXd gradient(5, 3);
  frames.batch(q, paths);
  for (int i = 0; i < kTimes; ++i) {
    points.row(0).setConstant(times[static_cast<std::size_t>(i)]);
    query.batch(points, all);
    for (int j = 0; j < 40; ++j) {
      query.values({points.col(j).data(), 3}, values, gradient);
      frames.values({q.col(j).data(), 2}, path, slopes);
      CHECK((all.col(j) - values).cwiseAbs().maxCoeff() < 1e-13);
      CHECK((path.row(i).transpose() - values).cwiseAbs().maxCoeff() < 1e-13);
      for (int o = 0; o < 5; ++o) {
        CHECK(paths(i + kTimes * o, j) == Approx(values[o]).margin(1e-13));
        for (int k = 0; k < 2; ++k) CHECK(slopes(i, o + 5 * k) == Approx(gradient(o, k + 1)).margin(1e-12));
      }
    }
  }
}

TEST_CASE("attitudes of which a part is asked, or that begin anywhere, are left as they are") {
  for (const auto& [axis, outputs] : {std::pair{"C_T", std::vector<std::string>{"qw", "qx", "qy"}},
                                      std::pair{"qx(0)", std::vector<std::string>{}}}) {
    const Codebook book = body_book(axis);
    Query query(book, {.outputs = outputs});
    Eigen::VectorXd values(query.output_count()), raw(5);
    const std::vector<double> x = {0.37, 0.21, 0.83};
    query.values(x, values);
    FieldGroup::Workspace workspace = book.pieces()[0].groups()[0].make_workspace();
    book.pieces()[0].groups()[0].evaluate(x, raw, workspace);
    CHECK((values - raw.head(values.size())).cwiseAbs().maxCoeff() < 1e-14);
  }
}

TEST_CASE("a flat file gives an attitude the length with which it began, as the library does") {
  const Codebook book = body_book();
  FlatAnswers flat(book);
  Query query(book);
  // Sums of three terms, and the quotient by a length.
  CHECK(flat.largest_difference(query, Eigen::MatrixXd::Random(3, 50).cwiseAbs()) < 1e-12);
  const Codebook free = body_book("qx(0)");
  FlatAnswers free_flat(free);
  Query free_query(free);
  CHECK(free_flat.largest_difference(free_query, Eigen::MatrixXd::Random(3, 50).cwiseAbs()) < 1e-12);
}
