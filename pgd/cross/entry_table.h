#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/cross/cross_interpolation.h"

namespace samara::pgd {

/// Remembers the entries of a function on a grid, so that none is asked for twice, as many as fit. Those that came
/// later are evaluated again where they are asked for again.
class EntryTable {
 public:
  /// @param most_numbers that are remembered: half a gigabyte of them
  /// @throws ArgumentError if the grid has more than 2^63 entries.
  EntryTable(const EntryFunction& function, int outputs, std::vector<int> sizes,
             std::size_t most_numbers = std::size_t{1} << 26);

  /// Values at the entries, one column each; missing ones are evaluated in batches, each entry once.
  Eigen::MatrixXd fetch(const IndexBatch& entries);
  /// Calls take(j, values) once for every entry j, in any order, with a pointer to its outputs; likewise.
  void visit(const IndexBatch& entries, const std::function<void(Eigen::Index, const double*)>& take);

  /// All values; evaluations stay counted.
  void forget();

  long evaluations() const { return evaluations_; }
  double largest() const { return largest_; }
  /// The first entry whose value was not finite, or empty.
  const std::vector<int>& bad_entry() const { return bad_entry_; }

 private:
  std::uint64_t key(const Eigen::Ref<const Eigen::VectorXi>& entry) const;
  Eigen::MatrixXd evaluate(const IndexBatch& missing);
  void remember(const IndexBatch& entries, Eigen::MatrixXd values);

  const EntryFunction& function_;
  int outputs_;
  std::vector<int> sizes_;
  std::size_t most_numbers_;
  std::unordered_map<std::uint64_t, const double*> columns_;  ///< into the batches
  std::vector<Eigen::MatrixXd> batches_;
  std::size_t numbers_ = 0;  ///< in the batches
  long evaluations_ = 0;
  double largest_ = 0.0;
  std::vector<int> bad_entry_;
};

}  // namespace samara::pgd
