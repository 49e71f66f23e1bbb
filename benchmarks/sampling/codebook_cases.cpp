#include <algorithm>
#include <string>
#include <vector>

#include "cases.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/plan/plan.h"

// Codebooks built by sampling trajectories, and beside them by the PGD engine.

namespace samara::benchmarks {

namespace {

struct CodebookCase {
  std::string name;
  std::string plan;
};

/// The reference plate to t = 5.
std::string plate3(const std::string& tolerance) {
  return "model = 'falling_plate_nd'\n[box]\nC_T = [0.8, 1.4]\nC_R = [2, 4]\nA = [1, 1.8]\n[time]\nend = 5\n"
         "[tolerance]\nrelative = " +
         tolerance + "\n";
}

/// A coin in water, its speed at the beginning upward or downward: the drag has a kink where it turns.
std::string vertical_fall(const std::string& tolerance) {
  return "model = 'vertical_fall'\n[fixed]\narea = '4.71435e-4 m^2'\nthickness = '2.55 mm'\n"
         "density = 6338.6\n[box]\nC_D = [0.6, 2]\n'v(0)' = [-0.4, 0.8]\n[time]\nend = 0.5\n[tolerance]\n"
         "relative = " +
         tolerance + "\n";
}

/// The worst of some seeds.
struct Measured {
  double certificate_max = 0.0, evaluations = 0.0, seconds = 0.0, numbers = 0.0;
  bool met = true;
};

double numbers_of(const codebooks::Codebook& book) {
  long sum = 0;
  for (const codebooks::Piece& piece : book.pieces()) {
    for (const codebooks::FieldGroup& group : piece.groups()) sum += group.entries();
  }
  return static_cast<double>(sum);
}

Measured measure(const CodebookCase& test_case, const std::string& kind, std::uint64_t seeds) {
  Measured worst;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    codebooks::Plan plan = codebooks::parse_plan(test_case.plan, test_case.name);
    plan.builder.kind = kind;
    plan.builder.seed = seed;
    const codebooks::BuildResult result = codebooks::build(plan);
    const codebooks::Codebook& book = result.book;
    worst.certificate_max = std::max(worst.certificate_max, book.certificate()->max_error);
    worst.evaluations = std::max(worst.evaluations, book.build().evaluations);
    worst.seconds = std::max(worst.seconds, book.provenance().build_seconds);
    worst.numbers = std::max(worst.numbers, numbers_of(book));
    worst.met = worst.met && result.met;
  }
  return worst;
}

}  // namespace

void run_codebooks(const Options& options) {
  const std::vector<CodebookCase> cases = {{"plate3_1e-3", plate3("1e-3")},
                                           {"plate3_1e-4", plate3("1e-4")},
                                           {"vertical_fall_1e-3", vertical_fall("1e-3")},
                                           {"vertical_fall_1e-4", vertical_fall("1e-4")}};
  for (const CodebookCase& test_case : cases) {
    if (!options.wants(test_case.name)) continue;
    const Measured sampled = measure(test_case, "sampling", options.quick ? 1 : 5);
    print({kSampling, test_case.name, "certificate_max", sampled.certificate_max});
    print({kSampling, test_case.name, "met", sampled.met ? 1.0 : 0.0});
    print({kSampling, test_case.name, "calls", sampled.evaluations});
    print({kSampling, test_case.name, "numbers", sampled.numbers});
    const Measured solved = measure(test_case, "pgd", 1);
    print({kSampling, test_case.name, "time", sampled.seconds, "s", "pgd", solved.seconds / sampled.seconds});
    print({kSampling, test_case.name, "certificate_max_pgd", solved.certificate_max});
    print({kSampling, test_case.name, "evaluations_pgd", solved.evaluations});
    print({kSampling, test_case.name, "numbers_pgd", solved.numbers});
  }
}

}  // namespace samara::benchmarks
