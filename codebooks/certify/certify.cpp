#include "samara/codebooks/certify/certify.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <vector>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "samara/base/errors.h"
#include "samara/base/parallel.h"
#include "samara/base/require.h"
#include "samara/codebooks/certify/field_answers.h"
#include "samara/codebooks/certify/measure.h"
#include "samara/codebooks/certify/point_errors.h"
#include "samara/codebooks/source/model_measure.h"
#include "samara/models/integrators/integrate.h"
#include "samara/pgd/sampling/error_climb.h"

namespace samara::codebooks {

namespace {

/// @param points of the box, from which to see how much the states move
double integrator_tolerance(const models::ParametricModel& model, const Eigen::MatrixXd& points, double end,
                            const CertifyOptions& options) {
  constexpr double kLoosest = 1e-10;
  constexpr double kTightest = 1e-13;  // CVODES cannot hold less in doubles
  if (!(options.tolerance > 0.0)) return kLoosest;
  const auto& states = model.model().info().states;
  std::vector<pgd::OutputLabel> labels;
  for (const models::StateInfo& state : states) labels.push_back({state.name, state.unit});
  const pgd::OutputMeasure measure{.floors = floors_of(options.absolute, labels),
                                   .sizes = floors_of(options.sizes, labels)};
  const double share = share_for_range(model, points, end, measure);
  return std::clamp(0.01 * share * options.tolerance, kTightest, kLoosest);
}

/// The options with what a model knows.
CertifyOptions completed(CertifyOptions options, const Codebook& book, const models::ParametricModel& model) {
  constexpr int kPoints = 8;
  const auto [lower, upper] = certificate_box(book);
  const Eigen::VectorXd sizes = state_sizes(model, 0.5 * (lower + upper));
  for (Eigen::Index s = 0; s < sizes.size(); ++s)
    options.sizes.emplace(model.model().info().states[static_cast<std::size_t>(s)].name, sizes[s]);
  if (!options.integrator_tolerance) {
    options.integrator_tolerance = integrator_tolerance(
        model, certificate_points(book, kPoints, options.seed), book.coordinates().front().upper, options);
  }
  return options;
}

/// One thread's tools.
struct Worker {
  Worker(const Codebook& book, const models::ParametricModel& model, const std::vector<double>& times,
         const CertifyOptions& options)
      : answers(book, times),
        integrator(model, {.relative_tolerance = *options.integrator_tolerance}, false) {}

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

/// The state of the model that every output of the codebook is.
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

/// The errors at points (parameters x points), in their order; fewer where the comparison ends.
using Comparison = std::function<std::vector<PointErrors>(const Eigen::MatrixXd& q)>;

Eigen::VectorXd largest_errors(const std::vector<PointErrors>& errors, const Eigen::VectorXd& scales) {
  Eigen::VectorXd largest(static_cast<Eigen::Index>(errors.size()));
  for (Eigen::Index i = 0; i < largest.size(); ++i) {
    const PointErrors& point = errors[static_cast<std::size_t>(i)];
    largest[i] = point.usable ? largest_over_scales(point, scales) : 0.0;
  }
  return largest;
}

/// In slices, so that progress is reported, and cancellation noticed, on the calling thread.
std::vector<PointErrors> compared(const Eigen::MatrixXd& q, const Codebook& book,
                                  const CertifyOptions& options, const Comparison& comparison,
                                  Eigen::Index slice, Extent extent) {
  std::vector<PointErrors> errors;
  for (Eigen::Index begin = 0; begin < q.cols(); begin += slice) {
    const double done = static_cast<double>(begin) / static_cast<double>(q.cols());
    if (options.progress && !options.progress({"certificate", done})) break;
    const Eigen::Index count = std::min(slice, q.cols() - begin);
    for (PointErrors& point : comparison(q.middleCols(begin, count))) errors.push_back(std::move(point));
    if (static_cast<Eigen::Index>(errors.size()) < begin + count) break;
    // Where that many fail and none succeeds, the others would only take their time.
    constexpr std::size_t kHopeless = 20;
    const Eigen::VectorXd scales = error_scales(errors, book, options);
    if (scales.size() == 0 && errors.size() >= kHopeless) break;
    // The range of a few points is none to judge errors by.
    constexpr std::size_t kEnoughForRange = 200;
    if (extent == Extent::all_points || errors.size() < kEnoughForRange) continue;
    if (scales.size() > 0 && largest_errors(errors, scales).maxCoeff() > options.tolerance) break;
  }
  return errors;
}

/// Climbs from the worst points, where these stand far above the others.
ComparedPoints climbed(const ComparedPoints& points, const Codebook& book, const CertifyOptions& options,
                       const Comparison& comparison) {
  constexpr double kFarAbove = 4.0;
  constexpr double kNegligible = 1e-3;  // of the tolerance
  ComparedPoints ends{Eigen::MatrixXd(points.q.rows(), 0), {}};
  const Eigen::VectorXd scales = error_scales(points.errors, book, options);
  if (options.climbs == 0 || scales.size() == 0) return ends;
  const Eigen::VectorXd largest = largest_errors(points.errors, scales);
  if (!(largest.maxCoeff() > kNegligible * options.tolerance) || !pgd::has_outliers(largest, kFarAbove))
    return ends;
  const auto [lower, upper] = certificate_box(book);
  bool cancelled = false;
  // Without answers all errors are zero, and the climbs end.
  const pgd::ErrorsAt errors_at = [&](const Eigen::MatrixXd& q) {
    std::vector<PointErrors> errors;
    cancelled = cancelled || (options.progress && !options.progress({"certificate", 1.0}));
    if (!cancelled) errors = comparison(q);
    errors.resize(static_cast<std::size_t>(q.cols()));
    return largest_errors(errors, scales);
  };
  const Eigen::MatrixXd asked = points.q.leftCols(largest.size());
  ends.q = pgd::climb_from_worst(lower, upper, errors_at, asked, largest, options.climbs).points;
  if (!cancelled) ends.errors = comparison(ends.q);
  return ends;
}

/// Those of the points and climbs that err by more than the tolerance, the worst first.
Eigen::MatrixXd wrong_among(const ComparedPoints& points, const ComparedPoints& climbs, const Codebook& book,
                            const CertifyOptions& options) {
  constexpr std::size_t kMost = 20;
  const Eigen::VectorXd scales = error_scales(points.errors, book, options);
  if (scales.size() == 0) return Eigen::MatrixXd(points.q.rows(), 0);
  std::vector<std::pair<double, Eigen::VectorXd>> wrong;
  for (const ComparedPoints* some : {&climbs, &points}) {
    const Eigen::VectorXd largest = largest_errors(some->errors, scales);
    for (Eigen::Index i = 0; i < largest.size(); ++i) {
      if (!(largest[i] <= options.tolerance)) wrong.emplace_back(largest[i], some->q.col(i));
    }
  }
  std::ranges::stable_sort(wrong, std::greater<>(), [](const auto& point) { return point.first; });
  Eigen::MatrixXd result(points.q.rows(), static_cast<Eigen::Index>(std::min(kMost, wrong.size())));
  for (Eigen::Index j = 0; j < result.cols(); ++j) result.col(j) = wrong[static_cast<std::size_t>(j)].second;
  return result;
}

Measured measured(const Codebook& book, const CertifyOptions& options, const std::vector<double>& times,
                  const Comparison& comparison, Eigen::Index slice, Extent extent) {
  ComparedPoints points{certificate_points(book, options.points, options.seed), {}};
  points.errors = compared(points.q, book, options, comparison, slice, extent);
  const bool is_whole = static_cast<Eigen::Index>(points.errors.size()) == points.q.cols();
  const Eigen::MatrixXd wrong = wrong_among(points, {}, book, options);
  // What was cancelled or has failed is not asked again.
  const bool may_climb = is_whole || (extent == Extent::until_wrong && wrong.cols() > 0);
  const ComparedPoints climbs =
      may_climb ? climbed(points, book, options, comparison) : ComparedPoints{points.q.leftCols(0), {}};
  return {certificate_of(points, climbs, book, options, times), wrong_among(points, climbs, book, options)};
}

void check_fits(const Codebook& book, const models::ParametricModel& model) {
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
}

/// More threads than cores would only make TBB print a warning.
int arena_size(const CertifyOptions& options) {
  const int cores = tbb::info::default_concurrency();
  return options.threads > 0 ? std::min(options.threads, cores) : cores;
}

void check_points(const CertifyOptions& options) {
  require(options.points >= 1, "points", options.points, "at least 1", "certify");
  require(options.climbs >= 0, "climbs", options.climbs, "not negative", "certify");
}

}  // namespace

Measured measure(const Codebook& book, const models::ParametricModel& model, const CertifyOptions& asked,
                 Extent extent) {
  check_points(asked);
  check_fits(book, model);
  const CertifyOptions options = completed(asked, book, model);
  const std::vector<int> states = states_of_outputs(book, model);
  const std::vector<double> times = certificate_times(book);
  tbb::task_arena arena(arena_size(options));
  tbb::enumerable_thread_specific<Worker> workers([&] { return Worker(book, model, times, options); });
  const Comparison comparison = [&](const Eigen::MatrixXd& q) {
    std::vector<PointErrors> errors(static_cast<std::size_t>(q.cols()));
    arena.execute([&] {
      parallel_for(q.cols(), [&](Eigen::Index i) {
        errors[static_cast<std::size_t>(i)] = compare_with_trajectory(
            workers.local(), {q.col(i).data(), static_cast<std::size_t>(q.rows())}, times, states);
      });
    });
    return errors;
  };
  Measured result = measured(book, options, times, comparison, std::max(1, options.points / 50), extent);
  result.certificate.integrator = "CVODES, Adams, analytic derivatives";
  result.certificate.integrator_tolerance = *options.integrator_tolerance;
  return result;
}

Measured measure(const Codebook& book, CallMemory& calls, const CertifyOptions& options, Extent extent) {
  check_points(options);
  const std::vector<double> times = certificate_times(book);
  CertifiedAnswers answers(book, times);
  std::string failure;
  const Comparison comparison = [&](const Eigen::MatrixXd& q) {
    std::vector<PointErrors> errors;
    // A program that has failed may be costly to call again.
    if (!failure.empty()) return errors;
    CalledAnswers answered = calls(q, times);
    failure = std::move(answered.failure);
    if (!failure.empty()) return errors;
    const Eigen::MatrixXd& exact = answered.values;
    for (Eigen::Index j = 0; j < q.cols(); ++j) {
      const Eigen::MatrixXd reference =
          exact.col(j).reshaped(book.output_count(), exact.rows() / book.output_count()).transpose();
      errors.push_back(answers.compare({q.col(j).data(), static_cast<std::size_t>(q.rows())}, reference));
    }
    return errors;
  };
  const Eigen::Index slice = std::max(1, std::min(calls.source().batch, (options.points + 9) / 10));
  Measured result = measured(book, options, times, comparison, slice, extent);
  result.certificate.failure = failure;
  result.certificate.met = result.certificate.met && failure.empty();
  result.certificate.integrator = fmt::format("the command itself: {}", book.model().equations);
  return result;
}

Measured measure(const Codebook& book, const FieldReference& reference, const CertifyOptions& options,
                 Extent extent) {
  check_points(options);
  if (book.output_count() != 1)
    throw ArgumentError(fmt::format("a field has {} outputs, expected one to certify", book.output_count()));
  if (!reference.values) throw ArgumentError("a field is certified against an empty reference");
  const std::vector<double> times = certificate_times(book);
  const Eigen::VectorXd places = certificate_places(book);
  tbb::task_arena arena(arena_size(options));
  tbb::enumerable_thread_specific<FieldAnswers> answers([&] { return FieldAnswers(book, times, places); });
  const Comparison comparison = [&](const Eigen::MatrixXd& q) {
    std::vector<PointErrors> errors(static_cast<std::size_t>(q.cols()));
    arena.execute([&] {
      parallel_for(q.cols(), [&](Eigen::Index i) {
        errors[static_cast<std::size_t>(i)] =
            answers.local().compare({q.col(i).data(), static_cast<std::size_t>(q.rows())}, reference);
      });
    });
    return errors;
  };
  Measured result = measured(book, options, times, comparison, std::max(1, options.points / 50), extent);
  result.certificate.places = static_cast<int>(places.size());
  result.certificate.integrator = reference.name;
  result.certificate.integrator_tolerance = reference.tolerance;
  return result;
}

Certificate certify(const Codebook& book, const FieldReference& reference, const CertifyOptions& options) {
  return measure(book, reference, options, Extent::all_points).certificate;
}

Certificate certify(const Codebook& book, const models::ParametricModel& model,
                    const CertifyOptions& options) {
  return measure(book, model, options, Extent::all_points).certificate;
}

}  // namespace samara::codebooks
