// A random train: nothing to gain but from the loops.
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <fmt/format.h>

#include "cases.h"
#include "samara/codebooks/query/query.h"

namespace samara::benchmarks {

namespace {

constexpr int kAxes = 6, kNodes = 16, kRank = 20, kPoints = 4096;

/// With cores of such a size that values are about one.
codebooks::Codebook random_book(PlainTrain& plain) {
  std::mt19937_64 engine(11);
  std::normal_distribution<double> normal;
  std::vector<pgd::Axis> axes;
  pgd::TensorTrain train;
  train.cores.emplace_back(1, 1, 1);
  train.cores[0].data[0] = 1.0;
  plain.ranks = {1};
  for (int k = 0; k < kAxes; ++k) {
    axes.push_back(pgd::Axis::chebyshev({fmt::format("x{}", k)}, -1.0, 1.0, kNodes));
    const int left = k == 0 ? 1 : kRank, right = k + 1 == kAxes ? 1 : kRank;
    pgd::TrainCore core(left, kNodes, right);
    std::vector<double> rows(static_cast<std::size_t>(core.data.size()));
    for (int l = 0; l < left; ++l)
      for (int i = 0; i < kNodes; ++i)
        for (int r = 0; r < right; ++r) {
          const double value = normal(engine) / std::sqrt(static_cast<double>(left));
          core.data[l + Eigen::Index{left} * (i + Eigen::Index{kNodes} * r)] = value;
          rows[static_cast<std::size_t>((l * kNodes + i) * right + r)] = value;
        }
    train.cores.push_back(std::move(core));
    plain.cores.push_back(std::move(rows));
    plain.ranks.push_back(right);
  }
  for (int i = 0; i < kNodes; ++i) {
    plain.nodes.push_back(axes[0].nodes()[i]);
    plain.barycentric.push_back((i % 2 == 0 ? 1.0 : -1.0) * (i == 0 || i + 1 == kNodes ? 0.5 : 1.0));
  }
  codebooks::ModelDescription model;
  model.name = codebooks::kCommandModel;
  return codebooks::Codebook(model,
                             {codebooks::Piece{{pgd::TrainField(axes, {{"u", "1"}}, std::move(train))}}});
}

}  // namespace

void run_trains(const Options& options) {
  const std::string name = "train_d6_n16_r20";
  if (!options.wants(name)) return;
  PlainTrain plain;
  const codebooks::Codebook book = random_book(plain);
  codebooks::Query query(book);
  std::srand(3);
  const Eigen::MatrixXd points = Eigen::MatrixXd::Random(kAxes, kPoints);
  Eigen::MatrixXd many(1, kPoints), slopes(1, kAxes);
  Eigen::VectorXd value(1);
  query.batch(points, many);
  for (Eigen::Index j = 0; j < 100; ++j) {
    query.values(std::span(points.col(j).data(), kAxes), value);
    const double expected = plain_value(plain, points.col(j).data());
    if (!(std::abs(value[0] - expected) < 1e-11 && std::abs(many(0, j) - expected) < 1e-11))
      throw std::runtime_error("the train and the plain loop differ");
  }
  Eigen::Index next = 0;
  double sink = 0.0;
  const auto x = [&] { return points.col(next++ % 256).data(); };
  const int rounds = options.quick ? 7 : 41;
  const auto ours = [&] { query.values(std::span(x(), kAxes), value); };
  const auto say = [&](const std::string& metric, const Pair& pair, const std::string& baseline) {
    print({kQuery, name, metric, pair.ours, "s", baseline, pair.ratio()});
  };
  const auto loop = [&] { sink += plain_value(plain, x()); };
  const auto native = [&] { sink += plain_value_native(plain, x()); };
  say("point", time_both(ours, loop, rounds), "bare_loop");
  say("point", time_both(ours, native, rounds), "bare_loop_native");
  const auto batch = [&](const auto& one) {
    Pair pair = time_both([&] { query.batch(points, many); }, one, rounds);
    pair.ours /= kPoints;
    return pair;
  };
  const Pair both = batch(loop);
  say("batch", both, "bare_loop");
  say("batch", batch(native), "bare_loop_native");
  // The products of a batch: four of 20 x 320 by 320 x points, and two small ones.
  const double product = 4.0 * gemm_seconds(kRank, kNodes * kRank, kPoints, false) +
                         gemm_seconds(kRank, kNodes, kPoints, false) +
                         gemm_seconds(1, kNodes * kRank, kPoints, false);
  print({kQuery, name, "gemm_fraction", product / (both.ours * kPoints)});
  print({kQuery, name, "gemm_rate",
         2.0 * kPoints * (4.0 * kRank * kNodes * kRank + 2.0 * kNodes * kRank) / product * 1e-9, "GFLOP/s"});
  const Pair gradient = time_both(
      ours, [&] { query.values(std::span(x(), kAxes), value, slopes); }, rounds);
  print({kQuery, name, "gradient_over_value", gradient.ratio()});
  const Pair threads =
      time_both([&] { query.batch(points, many, 2); }, [&] { query.batch(points, many, 1); }, rounds);
  print({kQuery, name, "threads2_over_1", threads.ratio()});
  if (std::isnan(sink)) throw std::runtime_error("a plain loop gave no number");
}

}  // namespace samara::benchmarks
