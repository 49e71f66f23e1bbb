#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/query/query.h"

namespace samara::codebooks {

/// Answers of a codebook, and of what its model derives from the states (derived_outputs(), the [outputs] of a model as
/// text): a DerivedQuery takes their names where a Query takes those of stored outputs. Exact derivatives, by the chain
/// rule; the certificate is of the stored outputs alone. One per thread; the codebook must outlive it.
class DerivedQuery {
 public:
  /// @param options without names: all stored outputs, then all derived ones
  /// @throws as Query; ArgumentError for a derived output where a state is not stored
  explicit DerivedQuery(const Codebook& book, const QueryOptions& options = {});
  ~DerivedQuery();
  DerivedQuery(DerivedQuery&&) noexcept;
  DerivedQuery& operator=(DerivedQuery&&) noexcept;

  /// Those that are free, in the order of Codebook::coordinates().
  const std::vector<Coordinate>& coordinates() const;
  /// In the order wanted.
  const std::vector<pgd::OutputLabel>& outputs() const;
  /// In use for what is stored.
  Precision precision() const;

  /// @param x coordinates() in order, SI @throws as Query::values()
  void values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values);
  /// The same with gradient(output, coordinate).
  void values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
              Eigen::Ref<Eigen::MatrixXd> gradient);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::codebooks
