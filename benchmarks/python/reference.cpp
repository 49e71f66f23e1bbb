#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>
#include <vector>

#include "samara/codebooks/file/load.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"

/// The baseline of benchmarks/python.py, which loads it into its own process: what the package calls, called from C++
/// on one thread, with memory that is there. Seconds, the least of `repeats`.
namespace {

namespace cb = samara::codebooks;

template <class Run>
double least_seconds(int repeats, const Run& run) {
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < repeats; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    run();
    const auto end = std::chrono::steady_clock::now();
    least = std::min(least, std::chrono::duration<double>(end - begin).count());
  }
  return least;
}

using Points = Eigen::Map<const Eigen::MatrixXd>;

}  // namespace

extern "C" {

/// @param points coordinates running fastest
double samara_seconds_of_points(const char* path, const double* points, long count, int repeats) {
  const cb::Codebook book = cb::load(path);
  cb::Query query(book);
  const Points x(points, book.coordinate_count(), count);
  Eigen::MatrixXd values(book.output_count(), count);
  return least_seconds(repeats, [&] { query.batch(x, values); });
}

/// One point after the other, as often as `count`.
double samara_seconds_of_single_points(const char* path, const double* point, long count, int repeats) {
  const cb::Codebook book = cb::load(path);
  cb::Query query(book);
  Eigen::VectorXd values(book.output_count());
  const std::span<const double> x(point, static_cast<std::size_t>(book.coordinate_count()));
  return least_seconds(repeats, [&] {
    for (long k = 0; k < count; ++k) query.values(x, values);
  });
}

/// @param parameters running fastest  @param derivatives whether they are wanted, too
double samara_seconds_of_trajectories(const char* path, const double* parameters, long count,
                                      const double* times, long time_count, int derivatives, int repeats) {
  const cb::Codebook book = cb::load(path);
  cb::TrajectoryQuery query(book, std::vector<double>(times, times + time_count));
  const Points q(parameters, query.parameter_count(), count);
  const Eigen::Index rows = query.time_count() * query.output_count();
  Eigen::MatrixXd values(rows, count), slopes(derivatives != 0 ? rows * query.parameter_count() : 0, count);
  return least_seconds(repeats, [&] {
    if (derivatives != 0) {
      query.batch(q, values, slopes);
    } else {
      query.batch(q, values);
    }
  });
}
}
