/// Case `eval_h` of the benchmark `command`: points of codebooks by samara_eval.h beside the library, one call after the
/// other in the same process.
#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <vector>

#include "report.h"
#include "samara/base/streams.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/capi/samara_eval.h"
#include "samara/codebooks/file/flat_file.h"
#include "samara/codebooks/query/query.h"

namespace {

using namespace samara::benchmarks;
using samara::codebooks::Codebook;
using samara::codebooks::Query;

constexpr Eigen::Index kPoints = 1000;

Codebook built(const char* plan) {
  return samara::codebooks::build(
             samara::codebooks::read_plan(std::filesystem::path(SAMARA_EXAMPLES_DIR) / plan))
      .book;
}

Eigen::MatrixXd points_of(const Codebook& book) {
  samara::Stream stream(1, 0);
  Eigen::MatrixXd points(book.coordinate_count(), kPoints);
  for (Eigen::Index j = 0; j < kPoints; ++j) {
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
      const auto& c = book.coordinates()[static_cast<std::size_t>(k)];
      points(k, j) = c.lower + (c.upper - c.lower) * stream.uniform();
    }
  }
  return points;
}

struct Worst {
  Pair point, gradient;
  double difference = 0.0;
};

void compare(const Codebook& book, bool quick, Worst& worst) {
  const std::string bytes = samara::codebooks::format_flat(book);
  samara_eval* flat = nullptr;
  const char* why = "";
  if (samara_eval_open_memory(bytes.data(), bytes.size(), &flat, &why) != SAMARA_EVAL_DONE)
    throw std::runtime_error(why);
  std::vector<double> work(samara_eval_work_size(flat));
  const Eigen::MatrixXd points = points_of(book);
  const auto d = static_cast<std::size_t>(points.rows());
  Query query(book);
  const Eigen::Index outputs = book.output_count();
  Eigen::VectorXd values(outputs), answer(outputs), slopes(outputs * points.rows());
  Eigen::MatrixXd gradient(outputs, points.rows());
  const auto ours = [&](bool slope) {
    for (Eigen::Index j = 0; j < kPoints; ++j)
      samara_eval_point(flat, work.data(), points.col(j).data(), answer.data(),
                        slope ? slopes.data() : nullptr);
  };
  const auto theirs = [&](bool slope) {
    for (Eigen::Index j = 0; j < kPoints; ++j) {
      if (slope) {
        query.values({points.col(j).data(), d}, values, gradient);
      } else {
        query.values({points.col(j).data(), d}, values);
      }
    }
  };
  const int rounds = quick ? 5 : 25;
  for (const bool slope : {false, true}) {
    const Pair pair = time_both([&] { ours(slope); }, [&] { theirs(slope); }, rounds);
    Pair& kept = slope ? worst.gradient : worst.point;
    if (kept.ours == 0.0 || pair.ratio() < kept.ratio()) kept = pair;
  }
  Eigen::VectorXd largest = Eigen::VectorXd::Constant(outputs, 1e-300),
                  apart = Eigen::VectorXd::Zero(outputs);
  for (Eigen::Index j = 0; j < kPoints; ++j) {
    query.values({points.col(j).data(), d}, values);
    samara_eval_point(flat, work.data(), points.col(j).data(), answer.data(), nullptr);
    largest = largest.cwiseMax(values.cwiseAbs());
    apart = apart.cwiseMax((values - answer).cwiseAbs());
  }
  worst.difference = std::max(worst.difference, apart.cwiseQuotient(largest).maxCoeff());
  samara_eval_close(flat);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options chosen = options(argc, argv);
    if (!chosen.wants("eval_h")) return 0;
    Worst worst;
    for (const char* plan : {"coin/plan.toml", "query/plate.toml"}) compare(built(plan), chosen.quick, worst);
    const auto line = [](const char* metric, const Pair& pair) {
      print({"command", "eval_h", metric, pair.ours / kPoints, "s", "library", pair.ratio()});
    };
    line("point", worst.point);
    line("gradient", worst.gradient);
    print({"command", "eval_h", "difference", worst.difference});
    print({"command", "eval_h", "bytes", static_cast<double>(std::filesystem::file_size(SAMARA_EVAL_OBJECT)),
           "B"});
  } catch (const std::exception& error) {
    std::cerr << "command_eval: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
