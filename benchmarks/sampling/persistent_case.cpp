#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

#include "cases.h"
#include "samara/codebooks/source/command_function.h"
#include "samara/pgd/tensors/random.h"

// 20,000 calls of examples/command/suspension.py in batches as sampling makes them: kept between batches,
// started for every batch, and by a thin client, which writes the same batches to a pipe and reads the
// answers without any check.

namespace samara::benchmarks {

namespace {

constexpr int kInputs = 3, kOutputs = 2;
constexpr Eigen::Index kBatch = 50;

Eigen::MatrixXd random_points(Eigen::Index count) {
  pgd::Random random(5);
  Eigen::MatrixXd points(kInputs, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    points.col(j) << 5e-5 + 4.5e-4 * random.uniform(), 0.1 + 0.5 * random.uniform(),
        1500.0 + 1500.0 * random.uniform();
  }
  return points;
}

/// Values at the points, asked for batch by batch.
template <class Ask>
Eigen::MatrixXd in_batches(const Eigen::MatrixXd& points, const Ask& ask) {
  Eigen::MatrixXd values(kOutputs, points.cols());
  for (Eigen::Index first = 0; first < points.cols(); first += kBatch) {
    const Eigen::Index count = std::min(kBatch, points.cols() - first);
    values.middleCols(first, count) = ask(points.middleCols(first, count));
  }
  return values;
}

/// Pipes to and from a program, no more.
class ThinClient {
 public:
  explicit ThinClient(const std::vector<std::string>& run) {
    std::array<int, 2> in{}, out{};
    if (pipe(in.data()) != 0 || pipe(out.data()) != 0) throw std::runtime_error("no pipes");
    child_ = fork();
    if (child_ == 0) {
      dup2(in[0], STDIN_FILENO);
      dup2(out[1], STDOUT_FILENO);
      for (const int descriptor : {in[0], in[1], out[0], out[1]}) close(descriptor);
      std::vector<char*> arguments;
      for (const std::string& word : run) arguments.push_back(const_cast<char*>(word.c_str()));
      arguments.push_back(nullptr);
      execvp(arguments[0], arguments.data());
      _exit(127);
    }
    close(in[0]);
    close(out[1]);
    to_ = fdopen(in[1], "w");
    from_ = fdopen(out[0], "r");
  }
  ThinClient(const ThinClient&) = delete;
  ThinClient& operator=(const ThinClient&) = delete;
  ~ThinClient() {
    std::fclose(to_);
    std::fclose(from_);
    std::free(line_);
    waitpid(child_, nullptr, 0);
  }

  Eigen::MatrixXd operator()(const Eigen::MatrixXd& points) {
    std::fprintf(to_, "%ld\n", static_cast<long>(points.cols()));
    for (Eigen::Index j = 0; j < points.cols(); ++j)
      std::fprintf(to_, "%.17g %.17g %.17g\n", points(0, j), points(1, j), points(2, j));
    std::fflush(to_);
    Eigen::MatrixXd values(kOutputs, points.cols());
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      if (getline(&line_, &room_, from_) < 0) throw std::runtime_error("the program gave no answer");
      char* rest = line_;
      for (Eigen::Index m = 0; m < kOutputs; ++m) values(m, j) = std::strtod(rest, &rest);
    }
    return values;
  }

 private:
  pid_t child_ = 0;
  std::FILE* to_ = nullptr;
  std::FILE* from_ = nullptr;
  char* line_ = nullptr;
  std::size_t room_ = 0;
};

Eigen::MatrixXd by_command(std::vector<std::string> run, bool persistent, const Eigen::MatrixXd& points) {
  const pgd::PointsFunction function = codebooks::command_function(
      {.run = std::move(run), .inputs = kInputs, .outputs = kOutputs, .persistent = persistent});
  return in_batches(points, [&](const Eigen::MatrixXd& batch) {
    Eigen::MatrixXd values;
    function(batch, values);
    return values;
  });
}

}  // namespace

void run_persistent_command(const Options& options) {
  const std::string name = "persistent_command";
  if (!options.wants(name)) return;
  const std::string folder = std::string(SAMARA_EXAMPLES_DIR) + "/command";
  const std::vector<std::string> kept = {SAMARA_PYTHON, folder + "/suspension.py"};
  // The same program for one batch.
  const std::vector<std::string> anew = {
      SAMARA_PYTHON, "-c",
      "import sys; sys.path.insert(0, sys.argv[1]); import numpy\n"
      "from suspension import answers\n"
      "for row in answers(numpy.loadtxt(sys.stdin, ndmin=2)).tolist(): print(*row)",
      folder};
  const Eigen::MatrixXd points = random_points(options.quick ? 2'000 : 20'000);
  Eigen::MatrixXd ours, theirs;
  const Pair pair =
      time_both([&] { ours = by_command(kept, true, points); },
                [&] {
                  ThinClient client(kept);
                  theirs = in_batches(points, [&](const Eigen::MatrixXd& batch) { return client(batch); });
                },
                options.quick ? 1 : 5);
  print({kSampling, name, "time", pair.ours, "s", "thin_client", pair.ratio()});
  print({kSampling, name, "difference", (ours - theirs).cwiseAbs().maxCoeff()});
  // Once is enough: it is a hundred times as long as what disturbs it.
  const auto begin = std::chrono::steady_clock::now();
  by_command(anew, false, points);
  const std::chrono::duration<double> anew_seconds = std::chrono::steady_clock::now() - begin;
  print({kSampling, name, "time_started_anew", anew_seconds.count(), "s"});
}

}  // namespace samara::benchmarks
