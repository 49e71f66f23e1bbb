/// The whole way on the coin: how good the codebook is, what the fit gives, and what an answer costs beside
/// CVODES at the codebook's accuracy, in the same process.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <vector>

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "report.h"
#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/problem/fit_config.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/trajectories/reference_trajectories.h"
#include "samara/pgd/tensors/random.h"

namespace {

using namespace samara;
using benchmarks::Measurement;
using benchmarks::print;
using benchmarks::time_of;

constexpr const char* kBench = "first_walk";
constexpr const char* kCase = "coin";
constexpr double kWindow = 0.4;
constexpr int kPoints = 256;  ///< queries cycle through so many points, so that the cache does not lie

const std::filesystem::path kExample = std::filesystem::path(SAMARA_EXAMPLES_DIR) / "coin";

std::vector<std::vector<double>> random_points(const codebooks::Codebook& book, std::uint64_t seed) {
  pgd::Random random(seed);
  std::vector<std::vector<double>> points;
  for (int i = 0; i < kPoints; ++i) {
    std::vector<double> q;
    for (std::size_t k = 1; k < book.coordinates().size(); ++k) {
      const codebooks::Coordinate& c = book.coordinates()[k];
      q.push_back(c.lower + random.uniform() * (c.upper - c.lower));
    }
    points.push_back(std::move(q));
  }
  return points;
}

/// Largest error of the integrator at a tolerance, in the certificate's measure.
double integrator_error(const codebooks::Codebook& book, const models::ParametricModel& model,
                        double tolerance, std::span<const double> times) {
  models::Integrator coarse(model, {.relative_tolerance = tolerance}, false);
  models::Integrator fine(model, {.relative_tolerance = 1e-11}, false);
  double error = 0.0;
  for (const std::vector<double>& q : random_points(book, 7)) {
    const Eigen::MatrixXd difference = coarse(q, times).states - fine(q, times).states;
    for (int o = 0; o < book.output_count(); ++o) {
      const double range = book.certificate()->outputs[static_cast<std::size_t>(o)].range;
      error = std::max(error, difference.col(o).cwiseAbs().maxCoeff() / range);
    }
  }
  return error;
}

/// The loosest of a ladder of tolerances at which CVODES is as accurate as the codebook.
double fair_tolerance(const codebooks::Codebook& book, const models::ParametricModel& model,
                      std::span<const double> times) {
  double tolerance = 1e-2;
  while (tolerance > 1e-10 &&
         integrator_error(book, model, tolerance, times) > book.certificate()->max_error) {
    tolerance /= std::sqrt(10.0);
  }
  return tolerance;
}

/// The options of the example, over the window of this benchmark.
identification::FitOptions coin_fit(const codebooks::Codebook& book) {
  identification::FitOptions options =
      identification::read_fit_config(kExample / "fit.toml", identification::config_names(book));
  options.compared.span = kWindow;
  return options;
}

void print_time(const char* metric, double ours, double baseline) {
  print({kBench, kCase, metric, ours, "s", "cvodes", baseline / ours});
}

void measure_queries(const codebooks::Codebook& book, const benchmarks::Options& options) {
  const models::ParametricModel model = codebooks::model_of(book);
  std::vector<double> frames;
  for (int i = 0; i * (1.0 / 60.0) <= kWindow; ++i) frames.push_back(i / 60.0);
  const double tolerance = fair_tolerance(book, model, frames);
  const std::vector<std::vector<double>> points = random_points(book, 3);
  const int repeats = options.quick ? 5 : 15;
  std::size_t next = 0;
  const auto point = [&]() -> const std::vector<double>& { return points[next++ % points.size()]; };

  codebooks::Query query(book);
  Eigen::VectorXd values(book.output_count());
  std::vector<double> x(static_cast<std::size_t>(book.coordinate_count()), kWindow);
  const double query_time = time_of(
      [&] {
        std::ranges::copy(point(), x.begin() + 1);
        query.values(x, values);
      },
      repeats);
  models::Integrator integrator(model, {.relative_tolerance = tolerance}, false);
  const double integrate_time = time_of([&] { integrator(point(), std::span(&kWindow, 1)); }, repeats);
  print_time("query_time", query_time, integrate_time);

  codebooks::TrajectoryQuery residual(book, frames, {"x"});
  Eigen::MatrixXd depth(residual.time_count(), 1);
  Eigen::MatrixXd slopes(residual.time_count(), residual.parameter_count());
  const double residual_time = time_of([&] { residual.values(point(), depth, slopes); }, repeats);
  models::Integrator sensitivities(model, {.relative_tolerance = tolerance}, true);
  const double sensitivity_time = time_of([&] { sensitivities(point(), frames); }, repeats);
  print_time("residual_gradient_time", residual_time, sensitivity_time);

  const auto captures = identification::read_captures(kExample / "coin.toml");
  const identification::FitOptions fit_options = coin_fit(book);
  const auto from_book = codebooks::codebook_trajectories(book);
  const auto from_integrator = codebooks::reference_trajectories(book, {.relative_tolerance = tolerance});
  const int fits = options.quick ? 3 : 7;
  print_time("fit_time", time_of([&] { identification::fit(*from_book, captures, fit_options); }, fits, 0.0),
             time_of([&] { identification::fit(*from_integrator, captures, fit_options); }, fits, 0.0));
}

void measure_fit(const codebooks::Codebook& book) {
  const auto captures = identification::read_captures(kExample / "coin.toml");
  const identification::FitOptions options = coin_fit(book);
  const auto drag = [&](const models::TrajectoryFamily& family) {
    return identification::fit(family, captures, options).coefficients.front();
  };
  const auto ours = drag(*codebooks::codebook_trajectories(book));
  const auto reference = drag(*codebooks::reference_trajectories(book));
  print({kBench, kCase, "CD", ours.value});
  print({kBench, kCase, "CD_stderr", ours.standard_error.value_or(std::nan(""))});
  print({kBench, kCase, "CD_reference", reference.value});
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Time of a child process from its start to its end, median. @throws Error if it does not end with 0.
double time_of_process(const std::vector<std::string>& command, int repeats) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    const pid_t child = fork();
    if (child == 0) {
      std::vector<char*> arguments;
      for (const std::string& part : command) arguments.push_back(const_cast<char*>(part.c_str()));
      arguments.push_back(nullptr);
      if (std::freopen("/dev/null", "w", stdout) == nullptr) _exit(126);
      execv(arguments[0], arguments.data());
      _exit(127);
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
      throw Error("a child process failed: " + command.front());
    times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return median(std::move(times));
}

/// In a process of its own (--open FILE), because HDF5 and the page tables are warm after the first file:
/// opening and one answer. Prints the seconds.
int open_once(const char* path) {
  const auto begin = std::chrono::steady_clock::now();
  const codebooks::Codebook book = codebooks::load(path);
  codebooks::Query query(book);
  Eigen::VectorXd values(book.output_count());
  std::vector<double> x;
  for (const codebooks::Coordinate& c : book.coordinates()) x.push_back(0.5 * (c.lower + c.upper));
  query.values(x, values);
  std::cout << std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() << std::endl;
  return 0;
}

double time_to_open(const std::filesystem::path& self, const std::filesystem::path& file, int repeats) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const std::string command = fmt::format("'{}' --open '{}'", self.string(), file.string());
    FILE* pipe = popen(command.c_str(), "r");
    double value = 0.0;
    if (pipe == nullptr || std::fscanf(pipe, "%lf", &value) != 1 || pclose(pipe) != 0)
      throw Error("cannot run " + command);
    times.push_back(value);
  }
  return median(std::move(times));
}

void run(const benchmarks::Options& options) {
  if (!options.wants(kCase)) return;
  const codebooks::BuildResult built = codebooks::build(codebooks::read_plan(kExample / "plan.toml"));
  const codebooks::Codebook& book = built.book;
  print({kBench, kCase, "certificate_max", book.certificate()->max_error});
  measure_fit(book);
  measure_queries(book, options);

  const std::filesystem::path self = std::filesystem::canonical("/proc/self/exe");
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("samara_first_walk_{}.h5", getpid());
  codebooks::save(book, file);
  print({kBench, kCase, "open_and_query_time", time_to_open(self, file, options.quick ? 5 : 15), "s"});
  const std::filesystem::path command = self.parent_path().parent_path() / "apps" / "samara";
  print({kBench, kCase, "command_time",
         time_of_process({command.string(), "query", file.string(), "--set", "C_D=1.15", "--set", "v(0)=0.1",
                          "--at", "0.3"},
                         options.quick ? 9 : 31),
         "s"});
  std::filesystem::remove(file);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 3 && std::string(argv[1]) == "--open") return open_once(argv[2]);
    run(benchmarks::options(argc, argv));
  } catch (const std::exception& error) {
    std::cerr << "first_walk: " << error.what() << std::endl;
    return 1;
  }
  return 0;
}
