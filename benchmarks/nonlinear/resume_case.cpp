// `samara build` killed at random moments: each resume must end in the content of an undisturbed build,
// provenance aside.
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

namespace samara::benchmarks {

namespace {

using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

/// A coin in water, its drag and its first speed free, by slabs.
constexpr const char* kPlan =
    "model = 'vertical_fall'\n[fixed]\narea = '4.71435e-4 m^2'\nthickness = '2.55 mm'\ndensity = 6338.6\n"
    "[box]\nC_D = [0.6, 2]\n'v(0)' = [-0.4, 0.8]\n[time]\nend = 0.5\n[tolerance]\nrelative = 1e-4\n"
    "[builder]\nkind = 'pgd'\nstrategy = 'slabs'\n";

fs::path command() {
  return fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "apps" / "samara";
}

/// Starts `samara build`, its words sent nowhere.
pid_t start(const fs::path& plan, const fs::path& book, bool resume) {
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child > 0) return child;
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  execl(command().c_str(), "samara", "build", plan.c_str(), "-o", book.c_str(), resume ? "--resume" : nullptr,
        nullptr);
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

void run_resume(const Options& options) {
  constexpr const char* kName = "resume";
  if (!options.wants(kName)) return;
  const fs::path folder = fs::temp_directory_path() / fmt::format("samara_resume_{}", getpid());
  fs::create_directories(folder);
  const fs::path plan = folder / "plan.toml";
  std::ofstream(plan) << kPlan;
  const Clock::time_point begin = Clock::now();
  if (wait_for(start(plan, folder / "whole.h5", false)) != 0)
    throw std::runtime_error(fmt::format("{} build failed", command().string()));
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  const std::string whole = content(folder / "whole.h5");
  pgd::Random random(10);
  int identical = 0, resumed = 0;
  const int builds = options.quick ? 3 : 10;
  for (int i = 0; i < builds; ++i) {
    const fs::path book = folder / fmt::format("killed{}.h5", i);
    const pid_t child = start(plan, book, false);
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds * random.uniform()));
    kill(child, SIGKILL);
    wait_for(child);
    resumed += fs::exists(fs::path(book).concat(".checkpoint")) ? 1 : 0;
    if (wait_for(start(plan, book, true)) == 0 && content(book) == whole) ++identical;
  }
  fs::remove_all(folder);
  print({kNonlinear, kName, "identical", static_cast<double>(identical), fmt::format("of {}", builds)});
  print({kNonlinear, kName, "had_checkpoint", static_cast<double>(resumed), fmt::format("of {}", builds)});
}

}  // namespace samara::benchmarks
