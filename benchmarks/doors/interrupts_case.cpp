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

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cases.h"
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

fs::path command() {
  return fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "apps" / "samara";
}

/// Starts `samara build`, its words sent nowhere.
pid_t start(const fs::path& plan, const fs::path& book) {
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child > 0) return child;
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  execl(command().c_str(), "samara", "build", plan.c_str(), "-o", book.c_str(), nullptr);
  _exit(127);
}

int wait_for(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
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
  if (wait_for(start(plan, folder / "whole.h5")) != 0)
    throw std::runtime_error(fmt::format("{} build failed", command().string()));
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
