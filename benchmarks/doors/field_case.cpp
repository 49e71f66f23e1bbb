/// A field of space by a plan: the rod from plan to file, against CVODE on other nodes.
#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "cases.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/pgd/tensors/random.h"
#include "tests/codebooks/rod_reference.h"

namespace samara::benchmarks::doors {

namespace {

constexpr const char* kRodPlan =
    "model = 'heat_rod'\n[fixed]\ncapacity = 3.6e6\nlength = 0.2\n"
    "[box]\nconductivity = [15, 60]\nleft = [0, 100]\nright = [0, 100]\namplitude = [-50, 50]\n"
    "[time]\nend = 600\n[tolerance]\nrelative = 1e-4\n";

/// The codebook as a file gives it back.
codebooks::Codebook after_a_file(const codebooks::Codebook& book) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("samara_heat_book_{}.h5", getpid());
  codebooks::save(book, file);
  codebooks::Codebook back = codebooks::load(file);
  std::filesystem::remove(file);
  return back;
}

}  // namespace

void field_case(const Options& options) {
  constexpr const char* kName = "heat_book";
  if (!options.wants(kName)) return;
  const codebooks::Plan plan = codebooks::parse_plan(kRodPlan, "heat_book");
  const codebooks::BuildResult built = codebooks::build(plan);
  const codebooks::Codebook book = after_a_file(built.book);
  codebooks::Query query(book);
  Eigen::VectorXd value(1);
  pgd::Random random(41);
  const Eigen::VectorXd places = Eigen::VectorXd::LinSpaced(33, 0.0, 0.2);
  std::vector<double> times = {0.0};
  for (double t = 1e-3; t < 600.0; t *= 1.7) times.push_back(t);
  times.push_back(600.0);
  double worst = 0.0, lowest = 1e300, highest = -1e300;
  for (int p = 0; p < 100; ++p) {
    std::vector<double> q;
    for (std::size_t k = 0; k < plan.box.size(); ++k) {
      const double share = p < 16 ? (p >> k) % 2 : random.uniform();  // corners first
      q.push_back(plan.box[k].lower + share * (plan.box[k].upper - plan.box[k].lower));
    }
    const Eigen::MatrixXd exact = rod_by_cvode({q[0], 3.6e6, 0.2, q[1], q[2], q[3]}, times, places);
    for (Eigen::Index i = 0; i < exact.cols(); ++i) {
      for (Eigen::Index j = 0; j < exact.rows(); ++j) {
        query.values(std::vector{times[static_cast<std::size_t>(i)], places[j], q[0], q[1], q[2], q[3]},
                     value);
        worst = std::max(worst, std::abs(value[0] - exact(j, i)));
      }
    }
    lowest = std::min(lowest, exact.minCoeff());
    highest = std::max(highest, exact.maxCoeff());
  }
  print({kBench, kName, "error_max", worst / (highest - lowest)});
  print({kBench, kName, "certificate_max", book.certificate()->max_error});
  print({kBench, kName, "met", built.met ? 1.0 : 0.0});
  print({kBench, kName, "time", book.provenance().build_seconds, "s"});
}

}  // namespace samara::benchmarks::doors
