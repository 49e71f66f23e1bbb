#include "sample_books.h"

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "samara/pgd/tensors/tensor_train.h"

namespace {

using namespace samara::codebooks;
using samara::pgd::Axis;
using samara::pgd::AxisRole;
using samara::pgd::OutputLabel;
using samara::pgd::SeparatedField;
using samara::pgd::TrainField;

std::vector<Axis> sample_axes(const PieceBox& box) {
  const double length = box.t_upper - box.t_lower;
  return {
      Axis::radau({"t", "s", AxisRole::time},
                  Eigen::Vector3d(box.t_lower, box.t_lower + 0.37 * length, box.t_upper), 4),
      Axis::chebyshev({"C_D", "1", AxisRole::parameter}, box.C_D_lower, box.C_D_upper, 7),
      Axis::p1({"v(0)", "m/s", AxisRole::initial}, Eigen::Vector4d(-0.3, -0.1, 0.05, 0.6)),
  };
}

SeparatedField random_field(const std::vector<Axis>& axes, const std::vector<OutputLabel>& outputs, int rank,
                            std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto matrix = [&](Eigen::Index rows, Eigen::Index columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(random); }).eval();
  };
  std::vector<Eigen::MatrixXd> factors;
  for (const Axis& axis : axes) factors.push_back(matrix(axis.size(), rank));
  return SeparatedField(axes, outputs, factors, matrix(static_cast<Eigen::Index>(outputs.size()), rank));
}

/// A factor matrix from functions of the coordinate, one per column.
template <class... Functions>
Eigen::MatrixXd columns_of(const Axis& axis, const Functions&... functions) {
  Eigen::MatrixXd factor(axis.size(), static_cast<Eigen::Index>(sizeof...(functions)));
  Eigen::Index r = 0;
  ((factor.col(r++) = axis.nodes().unaryExpr(functions)), ...);
  return factor;
}

Piece golden_piece(double t_lower, double t_upper) {
  const std::vector<Axis> axes = {Axis::radau({"t", "s", AxisRole::time}, t_lower, t_upper, 2, 3),
                                  Axis::chebyshev({"C_D", "1", AxisRole::parameter}, -1.0, 2.0, 4),
                                  Axis::p1({"v(0)", "m/s", AxisRole::initial}, 0.0, 1.0, 3)};
  const auto one = [](double) { return 1.0; };
  const auto same = [](double a) { return a; };
  const auto half_square = [](double a) { return 0.5 * a * a; };
  const std::vector<Eigen::MatrixXd> v = {columns_of(axes[0], one, same), columns_of(axes[1], one, same),
                                          columns_of(axes[2], same, one)};
  const std::vector<Eigen::MatrixXd> x = {columns_of(axes[0], same, half_square),
                                          columns_of(axes[1], one, same), columns_of(axes[2], same, one)};
  const Eigen::RowVector2d weights = Eigen::RowVector2d::Ones();
  return {{SeparatedField(axes, {{"v", "m/s"}}, v, weights), SeparatedField(axes, {{"x", "m"}}, x, weights)}};
}

}  // namespace

const std::string& coin_plan() {
  static const std::string text = R"toml(model = "vertical_fall"
title = "a coin"
[fixed]
density = 6339
area = 4.714e-4
thickness = "2.55 mm"
[box]
C_D = [0.8, 1.6]
"v(0)" = [0.0, 0.3]
[time]
end = 0.5
[tolerance]
relative = 1e-3
[builder]
kind = "pgd"
)toml";
  return text;
}

const BuildResult& coin_build() {
  static const BuildResult result = build(parse_plan(coin_plan(), "coin.toml"));
  return result;
}

Piece random_piece(const PieceBox& box, unsigned seed, int rank) {
  std::mt19937_64 random(seed);
  const std::vector<Axis> axes = sample_axes(box);
  return {{random_field(axes, {{"x", "m"}, {"v", "m/s"}}, rank, random),
           random_field(axes, {{"E", "J"}}, rank + 2, random)}};
}

Codebook four_pieces() {
  return Codebook(sample_model(), {random_piece({0.0, kSlabBorder, 0.5, kCellBorder}, 1),
                                   random_piece({0.0, kSlabBorder, kCellBorder, 2.0}, 2),
                                   random_piece({kSlabBorder, 0.5, 0.5, kCellBorder}, 3),
                                   random_piece({kSlabBorder, 0.5, kCellBorder, 2.0}, 4)});
}

Piece as_trains(const Piece& piece) {
  Piece::Groups trains;
  for (const FieldGroup& group : piece.groups()) {
    const SeparatedField& sum = *group.sum();
    samara::pgd::SeparatedTensor tensor;
    tensor.weights = Eigen::VectorXd::Ones(sum.rank());
    tensor.factors.push_back(sum.weights());
    for (const Eigen::MatrixXd& factor : sum.factors()) tensor.factors.push_back(factor);
    trains.emplace_back(TrainField(sum.axes(), sum.outputs(), to_train(tensor)));
  }
  return trains;
}

Codebook four_pieces_of_trains() {
  const Codebook sums = four_pieces();
  std::vector<Piece> pieces;
  for (const Piece& piece : sums.pieces()) pieces.push_back(as_trains(piece));
  return Codebook(sample_model(), std::move(pieces));
}

Piece random_train_piece(const PieceBox& box, unsigned seed, int rank) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const std::vector<Axis> axes = sample_axes(box);
  std::vector<OutputLabel> outputs = {{"x", "m"}, {"v", "m/s"}, {"E", "J"}};
  samara::pgd::TensorTrain train;
  int left = 1;
  for (std::size_t k = 0; k <= axes.size(); ++k) {
    const int size = k == 0 ? static_cast<int>(outputs.size()) : axes[k - 1].size();
    train.cores.emplace_back(left, size, k == axes.size() ? 1 : rank);
    for (double& entry : train.cores.back().data) entry = uniform(random);
    left = rank;
  }
  return {{TrainField(axes, std::move(outputs), std::move(train))}};
}

Codebook golden_trains() {
  const Piece sums = golden_piece(0.0, 2.0);
  // v and x over the terms of both.
  samara::pgd::SeparatedTensor both;
  both.weights = Eigen::VectorXd::Ones(4);
  both.factors.push_back((Eigen::MatrixXd(2, 4) << 1, 1, 0, 0, 0, 0, 1, 1).finished());
  const SeparatedField& v = *sums.groups()[0].sum();
  const SeparatedField& x = *sums.groups()[1].sum();
  for (std::size_t k = 0; k < v.axes().size(); ++k) {
    Eigen::MatrixXd factor(v.axes()[k].size(), 4);
    factor << v.factors()[k], x.factors()[k];
    both.factors.push_back(std::move(factor));
  }
  both.factors[0].leftCols(2) *= v.weights().row(0).asDiagonal();
  both.factors[0].rightCols(2) *= x.weights().row(0).asDiagonal();
  const TrainField train(v.axes(), {v.outputs()[0], x.outputs()[0]}, to_train(both));
  const Codebook bare(sample_model(), {Piece{{train}}, golden_piece(2.0, 3.0)}, sample_build(),
                      sample_provenance(), {}, "the golden codebook");
  return bare.with_certificate(sample_certificate(bare));
}

Codebook golden_command() {
  const std::vector<Axis> axes = {Axis::chebyshev({"a", "m"}, -1.0, 2.0, 3),
                                  Axis::chebyshev({"b", "kg"}, 0.0, 1.0, 2)};
  // Outputs (a, 1) by a and b: u = a b, v = a + 1.
  samara::pgd::TrainCore outputs(1, 2, 2), by_a(2, 3, 2), by_b(2, 2, 1);
  outputs.left_unfolding().setIdentity();
  for (int i = 0; i < 3; ++i) {
    const double a = axes[0].nodes()[i];
    by_a.data[0 + 2 * i] = a;              // u: a times the first of b
    by_a.data[1 + 2 * (i + 3)] = a + 1.0;  // v: a + 1 times the second
  }
  for (int i = 0; i < 2; ++i) {
    by_b.data[0 + 2 * i] = axes[1].nodes()[i];
    by_b.data[1 + 2 * i] = 1.0;
  }
  samara::pgd::TensorTrain train{{outputs, by_a, by_b}};
  ModelDescription model;
  model.name = kCommandModel;
  model.title = "what a program answers";
  model.equations = "python3 product.py --fast";
  model.fixed = {{"c", 1.0 / 3.0}};
  model.fixed_units = {{"c", "m/s"}};
  const TrainField field(axes, {{"u", "m kg"}, {"v", "m"}}, std::move(train));
  const Codebook bare(model, {Piece{{field}}}, sample_build(), sample_provenance(), {}, "the golden command");
  Certificate certificate = sample_certificate(bare);
  certificate.times = 0;
  return bare.with_certificate(certificate);
}

Codebook golden_climbs() {
  const Codebook book = golden_command();
  Certificate certificate = *book.certificate();
  certificate.wrong_points = 0;
  certificate.climbed_points = 17;
  certificate.refuted_before = 2;
  return book.with_certificate(certificate);
}

Codebook golden_mesh() {
  // The square of unit sides, cut by the diagonal between nodes 1 and 2.
  Eigen::MatrixXd points(2, 4);
  points << 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0;
  Eigen::MatrixXi cells(3, 2);
  cells << 0, 3, 1, 2, 2, 1;
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(4, 4);
  for (const auto& cell : cells.colwise()) {
    for (const int a : cell) {
      for (const int b : cell) mass(a, b) += a == b ? 1.0 / 12.0 : 1.0 / 24.0;
    }
  }
  const Axis node = Axis::imported({"node", "1", AxisRole::space}, mass.sparseView());
  const Axis k = Axis::chebyshev({"k", "K"}, 0.0, 1.0, 2);
  Eigen::MatrixXd over_nodes(4, 2), over_k(2, 2);
  over_nodes << Eigen::VectorXd::Ones(4), (points.row(0) + 2.0 * points.row(1)).transpose();
  over_k << k.nodes(), Eigen::VectorXd::Ones(2);
  const SeparatedField field({node, k}, {{"u", "K"}}, {over_nodes, over_k}, Eigen::RowVector2d::Ones());
  ModelDescription model;
  model.name = "golden_mesh";
  model.equations = "u = k + x + 2 y";
  const Codebook bare(model, {Piece{{field}}}, sample_build(), sample_provenance(), {}, "the golden mesh");
  Certificate certificate = sample_certificate(bare);
  certificate.places = 4;
  return bare.with_mesh(SpaceMesh({"x", "y"}, "m", points, cells)).with_certificate(certificate);
}

Codebook golden_front() {
  const std::vector<Axis> axes = {
      Axis::radau({"t", "s", AxisRole::time}, 0.0, 2.0, 2, 3),
      Axis::of_elements({"C", "kg"}, samara::pgd::Basis::chebyshev, Eigen::Vector3d(1.0, 1.8, 3.0), 3),
      Axis::chebyshev({"k", "1"}, 0.0, 1.0, 4), Axis::p1({"m", "kg"}, 0.0, 1.0, 3),
      Axis::chebyshev({"h", "m"}, -2.0, 2.0, 3)};
  const auto one = [](double) { return 1.0; };
  const auto same = [](double a) { return a; };
  const auto more = [](double a) { return 1.0 + a; };
  const auto square = [](double a) { return a * a; };
  const SeparatedField u(axes, {{"u", "kg"}},
                         {columns_of(axes[0], more, one, one), columns_of(axes[1], same, one, one),
                          columns_of(axes[2], one, square, one), columns_of(axes[3], one, one, same),
                          columns_of(axes[4], one, one, one)},
                         Eigen::RowVector3d::Ones());
  const SeparatedField w(axes, {{"w", "kg^2 m"}},
                         {columns_of(axes[0], one), columns_of(axes[1], square), columns_of(axes[2], one),
                          columns_of(axes[3], one), columns_of(axes[4], same)},
                         Eigen::RowVectorXd::Ones(1));
  Eigen::VectorXd place = Eigen::VectorXd::Zero(6);
  place[0] = 0.1;   // 1
  place[1] = 0.2;   // K
  place[2] = -0.3;  // H
  place[5] = 0.15;  // K T_2(H)
  FrontMap front(1, 1.0, 3.0, {{2, 0.0, 1.0, 2}, {4, -2.0, 2.0, 3}}, place);
  ModelDescription model;
  model.name = "golden_front";
  model.equations = "u = (1 + t) s + k^2 + m, w = s^2 h";
  const Codebook bare(model, {Piece({u, w}, std::move(front))}, sample_build(), sample_provenance(), {},
                      "the golden front");
  return bare.with_certificate(sample_certificate(bare));
}

ModelDescription sample_model() {
  ModelDescription model;
  model.name = "vertical_fall";
  model.title = "Fall \"broadside\" \xE2\x80\x94 caf\xC3\xA9";
  model.equations = "(m + m_a) v' = W - D |v| v,\n  x' = v";
  model.frames = "v and x are positive downward";
  model.source = "";
  model.fixed = {{"density", 1.0 / 3.0}, {"g", 9.81}, {"x(0)", -0.0}};
  model.fixed_units = {{"density", "kg/m^3"}, {"g", "m/s^2"}, {"x(0)", "m"}};
  return model;
}

BuildRecord sample_build() {
  return {"pgd", "newton", samara::Termination::not_resolved, "the axes do not resolve it", 1e17 / 3.0, 1e300,
          7,     3};
}

Provenance sample_provenance() {
  return {"samara 0.1.0", "model = \"vertical_fall\"\n# \xC2\xB5m\n", "2026-01-02T03:04:05Z", "host", 0.1};
}

Certificate sample_certificate(const Codebook& book) {
  Certificate certificate;
  certificate.tolerance = 1e-3;
  certificate.met = true;
  certificate.max_error = std::numbers::pi * 1e-4;
  certificate.points = 2000;
  certificate.times = 73;
  certificate.failed_points = 2;
  certificate.seed = 0xFFFF'FFFF'FFFF'FFF1;
  certificate.integrator = "CVODES";
  certificate.integrator_tolerance = 1e-10;
  certificate.residual = 1.0 / 7.0;
  certificate.spent = {1.0 / 9.0, 1.0 / 11.0, 1.0 / 13.0};
  double value = 1.0;
  for (const OutputLabel& output : book.outputs()) {
    value += 1.0 / 3.0;
    certificate.outputs.push_back({output.name,
                                   output.unit,
                                   value,
                                   value / 3.0,
                                   value / 7.0,
                                   value / 9.0,
                                   value / 11.0,
                                   value / 13.0,
                                   {}});
    for (const Coordinate& c : book.coordinates())
      certificate.outputs.back().worst.push_back(c.lower + value * 1e-3);
  }
  return certificate;
}

Codebook golden_book() {
  const Codebook bare(sample_model(), {golden_piece(0.0, 2.0), golden_piece(2.0, 3.0)}, sample_build(),
                      sample_provenance(), {}, "the golden codebook");
  return bare.with_certificate(sample_certificate(bare));
}

Codebook all_kinds() {
  using samara::pgd::Transform;
  const auto label = [](const char* name, Transform transform = Transform::none) {
    return Axis::Label{name, "1", AxisRole::parameter, transform};
  };
  const std::vector<Axis> axes = {
      Axis::legendre({"t", "s", AxisRole::time}, Eigen::Vector3d(0.0, 0.5, 2.0), 3),
      Axis::chebyshev(label("C_D", Transform::logarithm), Eigen::Vector3d(0.01, 0.3, 10.0), 2),
      Axis::fourier(label("angle"), 0.0, std::numbers::pi, 5),
      Axis::discrete(label("plies"), Eigen::Vector3d(1.0, 2.0, 4.0)),
      Axis::p1({"v(0)", "m/s", AxisRole::initial}, 0.0, 1.0, 3),
      Axis::chebyshev(label("m", Transform::square_root), 0.0, 4.0, 3),
      Axis::p2(label("k"), Eigen::Vector3d(-1.0, 0.2, 1.0)),
      Axis::legendre(label("h", Transform::reciprocal), 0.5, 8.0, 4),
  };
  const auto one = [](double) { return 1.0; };
  const auto same = [](double x) { return x; };
  const auto logarithm = [](double x) { return std::log(x); };
  const auto wave = [](double x) { return std::cos(2.0 * x); };
  const auto root = [](double x) { return std::sqrt(x); };
  const auto square = [](double x) { return x * x; };
  const auto inverse = [](double x) { return 1.0 / x; };
  const std::vector<Eigen::MatrixXd> factors = {
      columns_of(axes[0], one, same, one),   columns_of(axes[1], one, logarithm, one),
      columns_of(axes[2], one, wave, one),   columns_of(axes[3], one, same, one),
      columns_of(axes[4], same, one, one),   columns_of(axes[5], root, one, one),
      columns_of(axes[6], one, one, square), columns_of(axes[7], one, one, inverse)};
  return Codebook(sample_model(),
                  {{{SeparatedField(axes, {{"u", "m"}}, factors, Eigen::RowVector3d::Ones())}}},
                  sample_build(), sample_provenance(), {}, "an axis of every kind");
}

Eigen::MatrixXd random_points(const Codebook& book, int count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Eigen::MatrixXd points(book.coordinate_count(), count);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
      const Coordinate& c = book.coordinates()[static_cast<std::size_t>(k)];
      const Axis& axis = book.pieces().front().groups().front().axes()[static_cast<std::size_t>(k)];
      const double u = uniform(random);
      points(k, j) = axis.is_list() ? axis.nodes()[static_cast<Eigen::Index>(u * axis.size())]
                                    : c.lower + u * (c.upper - c.lower);
    }
  }
  return points;
}
