// Opening a large file, and files that were damaged.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <random>
#include <stdexcept>

#include <fmt/format.h>

#include "cases.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "tests/codebooks/file_fuzz.h"
#include "tests/io/temporary_directory.h"

namespace samara::benchmarks {

namespace {

/// Slabs of random trains over four coordinates.
codebooks::Codebook random_slabs(int slabs, int rank) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  std::vector<codebooks::Piece> pieces;
  for (int s = 0; s < slabs; ++s) {
    const std::vector<pgd::Axis> axes = {
        pgd::Axis::radau({"t", "s", pgd::AxisRole::time}, Eigen::Vector2d(s, s + 1.0), 8),
        pgd::Axis::chebyshev({"a"}, 0.0, 1.0, 12), pgd::Axis::chebyshev({"b"}, 0.0, 1.0, 12),
        pgd::Axis::chebyshev({"c"}, 0.0, 1.0, 12)};
    pgd::TensorTrain train;
    int left = 1;
    for (std::size_t k = 0; k <= axes.size(); ++k) {
      const int right = k == axes.size() ? 1 : k == 0 ? 6 : rank;
      pgd::TrainCore core(left, k == 0 ? 6 : axes[k - 1].size(), right);
      for (double& entry : core.data) entry = normal(engine) / std::sqrt(static_cast<double>(left));
      train.cores.push_back(std::move(core));
      left = right;
    }
    pieces.push_back(codebooks::Piece{
        {pgd::TrainField(axes, {{"u0"}, {"u1"}, {"u2"}, {"u3"}, {"u4"}, {"u5"}}, std::move(train))}});
  }
  codebooks::ModelDescription model;
  model.name = codebooks::kCommandModel;
  return codebooks::Codebook(model, std::move(pieces));
}

void open_case(const Options& options) {
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory / "large.h5";
  codebooks::save(random_slabs(40, 38), path);
  print({kQuery, "open", "bytes", static_cast<double>(std::filesystem::file_size(path)), "B"});
  double best = 1e9;
  for (int i = 0; i < (options.quick ? 5 : 25); ++i) {
    const auto begin = std::chrono::steady_clock::now();
    const codebooks::Codebook book = codebooks::load(path);
    codebooks::Query query(book);
    Eigen::VectorXd values(6);
    const double x[] = {20.5, 0.3, 0.4, 0.5};
    query.values(x, values);
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    if (std::isnan(values.sum())) throw std::runtime_error("an answer is no number");
  }
  print({kQuery, "open", "time", best, "s"});
}

void fuzz_case(const Options& options) {
  const file_fuzz::Report report = file_fuzz::fuzz(random_slabs(2, 4), options.quick ? 500 : 10000, 1);
  print({kQuery, "fuzz", "mutated", static_cast<double>(report.mutated)});
  print({kQuery, "fuzz", "failures", static_cast<double>(report.failures)});
}

}  // namespace

void run_files(const Options& options) {
  if (options.wants("open")) open_case(options);
  if (options.wants("fuzz")) fuzz_case(options);
}

}  // namespace samara::benchmarks
