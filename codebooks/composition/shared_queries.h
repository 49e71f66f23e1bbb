#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "samara/codebooks/query/trajectory_query.h"

/// Internal to codebooks/composition/.
namespace samara::codebooks {

/// Queries of one codebook that share what is prepared for their times and outputs, for as long as one of them is
/// used: a fit asks for the same frames again for each of its segments, starts, replicates and chains, and preparing
/// costs a hundred answers. Safe to share between threads; who asks while another prepares waits.
class SharedQueries {
 public:
  /// @param book must outlive this and the queries
  explicit SharedQueries(const Codebook& book) : book_(book) {}

  /// A query for one thread, and what keeps the shared part.
  class Query {
   public:
    explicit Query(std::shared_ptr<const TrajectoryQuery> shared)
        : shared_(std::move(shared)), own_(*shared_) {}
    TrajectoryQuery* operator->() { return &own_; }

   private:
    std::shared_ptr<const TrajectoryQuery> shared_;
    TrajectoryQuery own_;
  };

  /// @throws as TrajectoryQuery
  Query at(const std::vector<double>& times, const std::vector<std::string>& outputs) const;

 private:
  using Key = std::pair<std::vector<double>, std::vector<std::string>>;

  const Codebook& book_;
  mutable std::mutex mutex_;
  mutable std::map<Key, std::weak_ptr<const TrajectoryQuery>> prepared_;
};

}  // namespace samara::codebooks
