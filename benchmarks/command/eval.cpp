/// Points of codebooks by samara_eval.h beside the library, one call after the other in the same process: `eval_h`
/// with the flags of the machine, as the library's own kernels have, `eval_h_flags` with -O3 alone, `eval_h_plain` by
/// plain loops with -O3, as for compilers that are neither GCC nor Clang. Cases of the benchmark `command`.
#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "report.h"
#include "samara/base/streams.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/capi/samara_eval.h"
#include "samara/codebooks/file/flat_file.h"
#include "samara/codebooks/query/query.h"
#include "tests/codebooks/flat_eval_variant.h"

extern const FlatEval kEvalOfAnyMachine, kEvalPlain;

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

void compare(const Codebook& book, const FlatEval& eval, bool quick, Worst& worst) {
  const std::string bytes = samara::codebooks::format_flat(book);
  samara_eval* flat = nullptr;
  const char* why = "";
  if (eval.open_memory(bytes.data(), bytes.size(), &flat, &why) != SAMARA_EVAL_DONE)
    throw std::runtime_error(why);
  std::vector<double> work(eval.work_size(flat));
  const Eigen::MatrixXd points = points_of(book);
  const auto d = static_cast<std::size_t>(points.rows());
  Query query(book);
  const Eigen::Index outputs = book.output_count();
  Eigen::VectorXd values(outputs), answer(outputs), slopes(outputs * points.rows());
  Eigen::MatrixXd gradient(outputs, points.rows());
  const auto ours = [&](bool slope) {
    for (Eigen::Index j = 0; j < kPoints; ++j)
      eval.point(flat, work.data(), points.col(j).data(), answer.data(), slope ? slopes.data() : nullptr);
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
    eval.point(flat, work.data(), points.col(j).data(), answer.data(), nullptr);
    largest = largest.cwiseMax(values.cwiseAbs());
    apart = apart.cwiseMax((values - answer).cwiseAbs());
  }
  worst.difference = std::max(worst.difference, apart.cwiseQuotient(largest).maxCoeff());
  eval.close(flat);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options chosen = options(argc, argv);
    const FlatEval of_this_machine = {&samara_eval_open_memory, &samara_eval_work_size, &samara_eval_point,
                                      &samara_eval_close};
    std::vector<Codebook> books;
    for (const auto& [test_case, eval] :
         {std::pair("eval_h", &of_this_machine), std::pair("eval_h_flags", &kEvalOfAnyMachine),
          std::pair("eval_h_plain", &kEvalPlain)}) {
      if (!chosen.wants(test_case)) continue;
      if (books.empty()) books = {built("coin/plan.toml"), built("query/plate.toml")};
      Worst worst;
      for (const Codebook& book : books) compare(book, *eval, chosen.quick, worst);
      print({"command", test_case, "point", worst.point.ours / kPoints, "s", "library", worst.point.ratio()});
      print({"command", test_case, "gradient", worst.gradient.ours / kPoints, "s", "library",
             worst.gradient.ratio()});
      print({"command", test_case, "difference", worst.difference});
    }
    if (chosen.wants("eval_h"))
      print({"command", "eval_h", "bytes",
             static_cast<double>(std::filesystem::file_size(SAMARA_EVAL_OBJECT)), "B"});
  } catch (const std::exception& error) {
    std::cerr << "command_eval: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
