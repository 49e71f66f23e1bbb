#include "samara/codebooks/composition/shared_queries.h"

namespace samara::codebooks {

SharedQueries::Query SharedQueries::at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs) const {
  std::shared_ptr<const TrajectoryQuery> shared;
  {
    const std::lock_guard lock(mutex_);
    std::weak_ptr<const TrajectoryQuery>& known = prepared_[{times, outputs}];
    shared = known.lock();
    if (!shared) {
      // What nobody uses any more goes, or the list would grow with every fit.
      std::erase_if(prepared_,
                    [&](const auto& entry) { return &entry.second != &known && entry.second.expired(); });
      shared = std::make_shared<const TrajectoryQuery>(book_, times, outputs);
      known = shared;
    }
  }
  return Query(std::move(shared));
}

}  // namespace samara::codebooks
