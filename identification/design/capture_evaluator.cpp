#include "samara/identification/design/capture_evaluator.h"

#include <utility>

#include "samara/base/parallel.h"

namespace samara::identification {

namespace {

/// Enough for the threads of most machines to be busy; each has scratch space of its own.
constexpr std::size_t kWorkers = 16;

}  // namespace

CaptureEvaluator::CaptureEvaluator(const models::TrajectoryFamily& family, const Experiment& experiment,
                                   const KnownSoFar& known, Eigen::MatrixXd draws)
    : draws_(std::move(draws)) {
  for (std::size_t k = 0; k < kWorkers; ++k)
    workers_.push_back(std::make_unique<NextCapture>(family, experiment, known));
}

template <class Use>
void CaptureEvaluator::for_all(const std::vector<Release>& releases, const Use& use) {
  const auto draws = static_cast<std::size_t>(draws_.cols());
  const std::size_t count = releases.size() * draws;
  parallel_for(workers_.size(), [&](std::size_t worker) {
    CaptureRows rows;
    for (std::size_t task = worker; task < count; task += workers_.size()) {
      const std::size_t release = task / draws, draw = task % draws;
      const bool is_there =
          workers_[worker]->evaluate(draws_.col(static_cast<Eigen::Index>(draw)), releases[release], rows);
      use(release, draw, is_there ? &rows : nullptr);
    }
  });
}

std::vector<Informations> CaptureEvaluator::informations(const std::vector<Release>& releases) {
  const Eigen::Index size = draws_.rows();
  std::vector<Informations> result(releases.size(), Informations(static_cast<std::size_t>(draws_.cols()),
                                                                 Eigen::MatrixXd::Zero(size, size)));
  for_all(releases, [&](std::size_t release, std::size_t draw, const CaptureRows* rows) {
    if (rows != nullptr) result[release][draw] = eliminated(rows->normal(), rows->coefficients);
  });
  return result;
}

RowsOfCaptures CaptureEvaluator::rows(const std::vector<Release>& releases) {
  RowsOfCaptures result(releases.size(), std::vector<CaptureRows>(static_cast<std::size_t>(draws_.cols())));
  for_all(releases, [&](std::size_t release, std::size_t draw, const CaptureRows* rows) {
    if (rows != nullptr) result[release][draw] = *rows;
  });
  return result;
}

long CaptureEvaluator::evaluations() const {
  long sum = 0;
  for (const auto& worker : workers_) sum += worker->evaluations();
  return sum;
}

}  // namespace samara::identification
