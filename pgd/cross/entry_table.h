#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/cross/cross_interpolation.h"

namespace samara::pgd {

/// Remembers every entry of a function on a grid, so that none is asked for twice.
class EntryTable {
 public:
  /// @throws ArgumentError if the grid has more than 2^63 entries.
  EntryTable(const EntryFunction& function, int outputs, std::vector<int> sizes);

  /// Values at the entries, one column each; missing ones are evaluated in one batch.
  Eigen::MatrixXd fetch(const IndexBatch& entries);
  /// One output of every entry, entry j output `outputs[j % outputs.size()]`, likewise.
  Eigen::VectorXd fetch(const IndexBatch& entries, const Eigen::Ref<const Eigen::VectorXi>& outputs);

  long evaluations() const { return static_cast<long>(columns_.size()); }
  double largest() const { return largest_; }
  /// The first entry whose value was not finite, or empty.
  const std::vector<int>& bad_entry() const { return bad_entry_; }

 private:
  std::uint64_t key(const Eigen::Ref<const Eigen::VectorXi>& entry) const;
  /// Where the entries stand in `values_`, evaluated if they were missing.
  std::vector<std::size_t> positions(const IndexBatch& entries);
  void evaluate(const IndexBatch& missing);

  const EntryFunction& function_;
  int outputs_;
  std::vector<int> sizes_;
  std::unordered_map<std::uint64_t, std::size_t> columns_;
  std::vector<double> values_;
  double largest_ = 0.0;
  std::vector<int> bad_entry_;
};

}  // namespace samara::pgd
