#include "samara/codebooks/certify.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "samara/base/errors.h"
#include "samara/codebooks/certify_calls.h"
#include "samara/codebooks/point_errors.h"
#include "samara/models/integrate.h"

namespace samara::codebooks {

namespace {

double integrator_tolerance(const CertifyOptions& options) {
  constexpr double kLoosest = 1e-10;
  constexpr double kTightest = 1e-13;  // CVODES cannot hold less in doubles
  if (options.integrator_tolerance) return *options.integrator_tolerance;
  return options.tolerance > 0.0 ? std::clamp(0.01 * options.tolerance, kTightest, kLoosest) : kLoosest;
}

/// One thread's tools.
struct Worker {
  Worker(const Codebook& book, const models::ParametricModel& model, const std::vector<double>& times,
         const CertifyOptions& options)
      : answers(book, times),
        integrator(model, {.relative_tolerance = integrator_tolerance(options)}, false) {}

  CertifiedAnswers answers;
  models::Integrator integrator;
};

PointErrors compare_with_trajectory(Worker& worker, std::span<const double> q,
                                    const std::vector<double>& times,
                                    const std::vector<int>& state_of_output) {
  const models::Trajectory exact = worker.integrator(q, times);
  if (!exact.is_usable()) {
    PointErrors errors;
    errors.failure = exact.message;
    return errors;
  }
  return worker.answers.compare(q, exact.states(Eigen::all, state_of_output));
}

/// The state of the model behind every output of the codebook.
std::vector<int> states_of_outputs(const Codebook& book, const models::ParametricModel& model) {
  std::vector<int> states;
  for (const pgd::OutputLabel& output : book.outputs()) {
    const auto& known = model.model().info().states;
    const auto it =
        std::find_if(known.begin(), known.end(), [&](const auto& s) { return s.name == output.name; });
    if (it == known.end()) {
      throw ArgumentError(fmt::format("output \"{}\" of the codebook is not a state of the model \"{}\"",
                                      output.name, model.model().info().name));
    }
    states.push_back(static_cast<int>(it - known.begin()));
  }
  return states;
}

}  // namespace

Certificate certify(const Codebook& book, const models::ParametricModel& model,
                    const CertifyOptions& options) {
  if (options.points < 1)
    throw ArgumentError(fmt::format("certificate points are {}, expected at least 1", options.points));
  if (model.free_count() + 1 != book.coordinate_count()) {
    throw ArgumentError(fmt::format("the model has {} free coordinates, the codebook {} besides time",
                                    model.free_count(), book.coordinate_count() - 1));
  }
  for (std::size_t k = 0; k < model.free().size(); ++k) {
    const std::string& name = book.coordinates()[k + 1].name;
    if (model.free()[k].name != name) {
      throw ArgumentError(
          fmt::format("free coordinate {} of the model is \"{}\", that of the codebook \"{}\"", k,
                      model.free()[k].name, name));
    }
  }
  const std::vector<int> states = states_of_outputs(book, model);
  const std::vector<double> times = certificate_times(book);
  const Eigen::MatrixXd q = certificate_points(book, options.points, options.seed);
  std::vector<PointErrors> errors(static_cast<std::size_t>(options.points));
  // More threads than cores would only make TBB print a warning.
  const int cores = tbb::info::default_concurrency();
  tbb::task_arena arena(options.threads > 0 ? std::min(options.threads, cores) : cores);
  tbb::enumerable_thread_specific<Worker> workers([&] { return Worker(book, model, times, options); });
  // In slices, so that progress is reported, and cancellation heard, on the calling thread.
  const int slice = std::max(1, options.points / 50);
  for (int begin = 0; begin < options.points; begin += slice) {
    if (options.progress && !options.progress({"certificate", static_cast<double>(begin) / options.points}))
      break;
    const int end = std::min(begin + slice, options.points);
    arena.execute([&] {
      tbb::parallel_for(begin, end, [&](int i) {
        errors[static_cast<std::size_t>(i)] = compare_with_trajectory(
            workers.local(), {q.col(i).data(), static_cast<std::size_t>(q.rows())}, times, states);
      });
    });
    // Where that many integrations fail and none succeeds, the others would only take their time.
    constexpr int kHopeless = 20;
    if (end >= kHopeless &&
        std::none_of(errors.begin(), errors.begin() + end, [](const PointErrors& e) { return e.usable; })) {
      break;
    }
  }

  Certificate certificate = certificate_of(errors, book, options, q, times);
  certificate.integrator = "CVODES, Adams, analytic derivatives";
  certificate.integrator_tolerance = integrator_tolerance(options);
  return certificate;
}

Certificate certify(const Codebook& book, CallMemory& calls, const CertifyOptions& options) {
  const std::vector<double> times = certificate_times(book);
  const Eigen::MatrixXd q = certificate_points(book, options.points, options.seed);
  CertifiedAnswers answers(book, times);
  std::vector<PointErrors> errors(static_cast<std::size_t>(options.points));
  const Eigen::Index slice = std::max(1, std::min(calls.source().batch, (options.points + 9) / 10));
  try {
    for (Eigen::Index begin = 0; begin < q.cols(); begin += slice) {
      const double done = static_cast<double>(begin) / options.points;
      if (options.progress && !options.progress({"certificate", done})) break;
      const Eigen::Index count = std::min(slice, q.cols() - begin);
      const Eigen::MatrixXd exact = calls(q.middleCols(begin, count), times);
      for (Eigen::Index j = 0; j < count; ++j) {
        const Eigen::MatrixXd reference =
            exact.col(j).reshaped(book.output_count(), exact.rows() / book.output_count()).transpose();
        errors[static_cast<std::size_t>(begin + j)] =
            answers.compare({q.col(begin + j).data(), static_cast<std::size_t>(q.rows())}, reference);
      }
    }
  } catch (const CallFailed& failed) {
    // A program that fails once may be dear to ask again: the points behind are not asked.
    errors.back().failure = failed.what();
  }
  Certificate certificate = certificate_of(errors, book, options, q, times);
  certificate.integrator = fmt::format("the command itself: {}", book.model().equations);
  return certificate;
}

models::ParametricModel model_of(const Codebook& book) {
  if (book.is_of_command()) {
    throw ArgumentError(
        fmt::format("the codebook was sampled from a command ({}), there is no model behind it to integrate",
                    book.model().equations));
  }
  if (book.build().builder == "fit") {
    throw ArgumentError(fmt::format(
        "the codebook holds a series, the {}: it has no equations that could be integrated, and cannot "
        "be certified again",
        book.model().name));
  }
  std::vector<std::string> free;
  for (std::size_t k = 1; k < book.coordinates().size(); ++k) free.push_back(book.coordinates()[k].name);
  return models::ParametricModel(models::find_model(book.model().name), book.model().fixed, free);
}

}  // namespace samara::codebooks
