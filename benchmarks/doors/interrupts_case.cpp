/// `samara build` killed and interrupted at random moments: the same line again must end in the content of an
/// undisturbed build, provenance aside.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "cases.h"
#include "child.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks::doors {

namespace {

using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

/// A falling plate with three coefficients, by slabs.
constexpr const char* kPlan =
    "model = 'falling_plate_nd'\n[fixed]\n'theta(0)' = 0.4\n"
    "[box]\nC_T = [0.8, 1.4]\nC_R = [2, 4]\nA = [1, 1.8]\n[time]\nend = 3\n"
    "[builder]\nkind = 'pgd'\nstrategy = 'slabs'\n";

pid_t start(const fs::path& plan, const fs::path& book) {
  return start_samara({"build", plan.string(), "-o", book.string()});
}

/// All that a codebook file holds but where and when it was made.
std::string content(const fs::path& file) {
  const codebooks::Codebook book = codebooks::load(file);
  const fs::path stripped = fs::path(file).concat(".stripped");
  codebooks::save(
      codebooks::Codebook(book.model(), book.pieces(), book.build(), {}, book.certificate(), book.title()),
      stripped);
  std::ifstream in(stripped, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

void interrupts_case(const Options& options) {
  constexpr const char* kName = "interrupts";
  if (!options.wants(kName)) return;
  const fs::path folder = fs::temp_directory_path() / fmt::format("samara_interrupts_{}", getpid());
  fs::create_directories(folder);
  const fs::path plan = folder / "plan.toml";
  std::ofstream(plan) << kPlan;
  const Clock::time_point begin = Clock::now();
  if (wait_for(start(plan, folder / "whole.h5")) != 0) throw std::runtime_error("samara build failed");
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  const std::string whole = content(folder / "whole.h5");
  pgd::Random random(10);
  int identical = 0, kept = 0;
  const int builds = options.quick ? 4 : 40;
  for (int i = 0; i < builds; ++i) {
    const fs::path book = folder / fmt::format("cut_short{}.h5", i);
    const pid_t child = start(plan, book);
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds * random.uniform()));
    kill(child, i % 2 == 0 ? SIGKILL : SIGINT);
    wait_for(child);
    kept += fs::exists(fs::path(book).concat(".checkpoint")) ? 1 : 0;
    if (wait_for(start(plan, book)) == 0 && content(book) == whole) ++identical;
  }
  fs::remove_all(folder);
  print({kBench, kName, "identical", static_cast<double>(identical), fmt::format("of {}", builds)});
  print({kBench, kName, "had_checkpoint", static_cast<double>(kept), fmt::format("of {}", builds)});
}

}  // namespace samara::benchmarks::doors
