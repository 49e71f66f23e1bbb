#pragma once

#include <cstddef>
#include <cstdint>
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
  /// One output of every entry, entry j output `outputs[j % outputs.size()]`, likewise.
  Eigen::VectorXd fetch(const IndexBatch& entries, const Eigen::Ref<const Eigen::VectorXi>& outputs);

  long evaluations() const { return evaluations_; }
  double largest() const { return largest_; }
  /// The first entry whose value was not finite, or empty.
  const std::vector<int>& bad_entry() const { return bad_entry_; }

 private:
  std::uint64_t key(const Eigen::Ref<const Eigen::VectorXi>& entry) const;
  /// Calls take(j, values) for every entry j with a pointer to its outputs.
  template <class Take>
  void visit(const IndexBatch& entries, const Take& take);
  Eigen::MatrixXd evaluate(const IndexBatch& missing);
  void remember(const IndexBatch& entries, const Eigen::MatrixXd& values);

  const EntryFunction& function_;
  int outputs_;
  std::vector<int> sizes_;
  std::size_t most_numbers_;
  std::unordered_map<std::uint64_t, std::size_t> columns_;
  std::vector<double> values_;
  long evaluations_ = 0;
  double largest_ = 0.0;
  std::vector<int> bad_entry_;
};

}  // namespace samara::pgd
