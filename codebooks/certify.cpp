#include "samara/codebooks/certify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "samara/base/errors.h"
#include "samara/codebooks/query.h"
#include "samara/codebooks/sobol_points.h"
#include "samara/models/integrate.h"

namespace samara::codebooks {

namespace {

/// Per output, what one parameter point contributes.
struct PointErrors {
  bool usable = false;
  std::string failure;  ///< of the integrator
  Eigen::VectorXd max_error, sum_error2, sum_value2, smallest, largest;
  std::vector<int> worst_time;
};

/// Times between the builder's nodes and at its borders: twice as many in every time element as it has nodes.
std::vector<double> certificate_times(const Codebook& book) {
  std::vector<double> times;
  for (const Piece& piece : book.pieces()) {
    const pgd::Axis& time = piece.groups.front().axes().front();
    const int per_element = 2 * time.degree() + 1;
    for (int e = 0; e < time.elements(); ++e) {
      for (int i = 0; i < per_element; ++i) {
        const double fraction = static_cast<double>(i) / per_element;
        const double left = time.borders()[e];
        const double width = transformed_distance(time.transform(), left, time.borders()[e + 1]);
        times.push_back(transformed_advance(time.transform(), left, fraction * width));
      }
    }
    times.push_back(time.upper());
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

double integrator_tolerance(const CertifyOptions& options) {
  constexpr double kLoosest = 1e-10;
  constexpr double kTightest = 1e-13;  // CVODES cannot hold less in doubles
  if (options.integrator_tolerance) return *options.integrator_tolerance;
  return options.tolerance > 0.0 ? std::clamp(0.01 * options.tolerance, kTightest, kLoosest) : kLoosest;
}

/// The values of a coordinate that is a list in some piece, ascending; empty for an interval.
std::vector<double> listed_values(const Codebook& book, std::size_t coordinate) {
  std::set<double> values;
  for (const Piece& piece : book.pieces()) {
    const pgd::Axis& axis = piece.groups.front().axes()[coordinate];
    if (axis.basis() == pgd::Basis::discrete || axis.basis() == pgd::Basis::imported)
      values.insert(axis.nodes().begin(), axis.nodes().end());
  }
  return {values.begin(), values.end()};
}

/// Points of the box: parameters x count. Of lists, each value as often as the others.
Eigen::MatrixXd certificate_points(const Codebook& book, int count, std::uint64_t seed) {
  Eigen::MatrixXd q = sobol_points(book.coordinate_count() - 1, count, seed);
  for (Eigen::Index k = 0; k < q.rows(); ++k) {
    const auto coordinate = static_cast<std::size_t>(k) + 1;
    const Coordinate& c = book.coordinates()[coordinate];
    const std::vector<double> values = listed_values(book, coordinate);
    for (double& u : q.row(k)) {
      u = values.empty() ? c.lower + u * (c.upper - c.lower)
                         : values[static_cast<std::size_t>(u * static_cast<double>(values.size()))];
    }
  }
  return q;
}

/// One thread's tools.
struct Worker {
  Worker(const Codebook& book, const models::ParametricModel& model, const std::vector<double>& times,
         const CertifyOptions& options)
      : query(book, times),
        integrator(model, {.relative_tolerance = integrator_tolerance(options)}, false),
        values(static_cast<Eigen::Index>(times.size()), book.output_count()) {}

  TrajectoryQuery query;
  models::Integrator integrator;
  Eigen::MatrixXd values;
};

PointErrors compare(Worker& worker, std::span<const double> q, const std::vector<double>& times,
                    const std::vector<int>& state_of_output) {
  PointErrors errors;
  const models::Trajectory exact = worker.integrator(q, times);
  if (!exact.is_usable()) {
    errors.failure = exact.message;
    return errors;
  }
  worker.query.values(q, worker.values);
  const auto outputs = static_cast<Eigen::Index>(state_of_output.size());
  errors.usable = true;
  errors.max_error.resize(outputs);
  errors.worst_time.resize(state_of_output.size());
  errors.sum_error2.resize(outputs);
  errors.sum_value2.resize(outputs);
  errors.smallest.resize(outputs);
  errors.largest.resize(outputs);
  for (Eigen::Index o = 0; o < outputs; ++o) {
    const auto reference = exact.states.col(state_of_output[static_cast<std::size_t>(o)]);
    // NaN from a broken codebook must not hide: it counts as infinite.
    const Eigen::VectorXd difference = (worker.values.col(o) - reference).unaryExpr([](double e) {
      return std::isnan(e) ? std::numeric_limits<double>::infinity() : std::abs(e);
    });
    Eigen::Index worst = 0;
    errors.max_error[o] = difference.maxCoeff(&worst);
    errors.worst_time[static_cast<std::size_t>(o)] = static_cast<int>(worst);
    errors.sum_error2[o] = difference.squaredNorm();
    errors.sum_value2[o] = reference.squaredNorm();
    errors.smallest[o] = reference.minCoeff();
    errors.largest[o] = reference.maxCoeff();
  }
  return errors;
}

/// Puts the points' errors of one output together, in the order of the points.
OutputError summarise(const std::vector<PointErrors>& all, int output, const Codebook& book, double floor,
                      const Eigen::MatrixXd& q, const std::vector<double>& times) {
  const pgd::OutputLabel& label = book.outputs()[static_cast<std::size_t>(output)];
  OutputError result;
  result.name = label.name;
  result.unit = label.unit;
  double smallest = std::numeric_limits<double>::infinity();
  double largest = -smallest;
  double error2 = 0.0;
  double value2 = 0.0;
  std::vector<double> errors;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].usable) continue;
    smallest = std::min(smallest, all[i].smallest[output]);
    largest = std::max(largest, all[i].largest[output]);
    error2 += all[i].sum_error2[output];
    value2 += all[i].sum_value2[output];
    errors.push_back(all[i].max_error[output]);
    if (result.worst.empty() || errors.back() > result.max_si) {
      result.max_si = errors.back();
      result.worst = {times[static_cast<std::size_t>(all[i].worst_time[static_cast<std::size_t>(output)])]};
      for (Eigen::Index k = 0; k < q.rows(); ++k) result.worst.push_back(q(k, static_cast<Eigen::Index>(i)));
    }
  }
  if (errors.empty()) {
    result.range = result.max = result.p95 = result.mean = result.rms = result.max_si =
        std::numeric_limits<double>::quiet_NaN();
    return result;
  }
  result.range = std::max(largest - smallest, floor);
  const double scale = result.range > 0.0 ? result.range : 1.0;
  result.max = result.max_si / scale;
  std::sort(errors.begin(), errors.end());
  double sum = 0.0;
  for (const double e : errors) sum += e;
  result.mean = sum / static_cast<double>(errors.size()) / scale;
  result.p95 =
      errors[static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(errors.size()))) - 1] / scale;
  result.rms = value2 > 0.0 ? std::sqrt(error2 / value2) : std::sqrt(error2);
  return result;
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
        errors[static_cast<std::size_t>(i)] =
            compare(workers.local(), {q.col(i).data(), static_cast<std::size_t>(q.rows())}, times, states);
      });
    });
    // Where that many integrations fail and none succeeds, the others would only take their time.
    constexpr int kHopeless = 20;
    if (end >= kHopeless &&
        std::none_of(errors.begin(), errors.begin() + end, [](const PointErrors& e) { return e.usable; })) {
      break;
    }
  }

  Certificate certificate;
  certificate.tolerance = options.tolerance;
  certificate.points = options.points;
  certificate.times = static_cast<int>(times.size());
  certificate.seed = options.seed;
  certificate.integrator = "CVODES, Adams, analytic derivatives";
  certificate.integrator_tolerance = integrator_tolerance(options);
  certificate.failed_points = static_cast<int>(
      std::count_if(errors.begin(), errors.end(), [](const PointErrors& e) { return !e.usable; }));
  const auto first_failure =
      std::find_if(errors.begin(), errors.end(), [](const PointErrors& e) { return !e.failure.empty(); });
  if (first_failure != errors.end()) certificate.failure = first_failure->failure;
  certificate.met = certificate.failed_points == 0;
  if (certificate.failed_points == options.points)
    certificate.max_error = std::numeric_limits<double>::quiet_NaN();
  for (int o = 0; o < book.output_count(); ++o) {
    const auto floor = options.absolute.find(book.outputs()[static_cast<std::size_t>(o)].name);
    certificate.outputs.push_back(
        summarise(errors, o, book, floor == options.absolute.end() ? 0.0 : floor->second, q, times));
    const double error = certificate.outputs.back().max;
    if (error > certificate.max_error) certificate.max_error = error;
    certificate.met = certificate.met && error <= options.tolerance;
  }
  return certificate;
}

models::ParametricModel model_of(const Codebook& book) {
  std::vector<std::string> free;
  for (std::size_t k = 1; k < book.coordinates().size(); ++k) free.push_back(book.coordinates()[k].name);
  return models::ParametricModel(models::find_model(book.model().name), book.model().fixed, free);
}

}  // namespace samara::codebooks
