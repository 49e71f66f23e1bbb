#pragma once

#include <optional>

#include "samara/pgd/evolution/slab_evolution.h"
#include "samara/pgd/evolution/slab_solver.h"
#include "samara/pgd/nonlinear/strategy.h"

namespace samara::pgd {

/// Slabs of one element, each solved by the iteration of a strategy.
class IteratedSlab final : public SlabSolver {
 public:
  /// The strategy must outlive it.
  explicit IteratedSlab(Strategy& strategy) : strategy_(strategy) {}

  /// Before the march. @returns why there is none, or nothing @throws ArgumentError as Strategy::prepare()
  std::optional<Ending> prepare(const AdaptiveProblem& problem, const SlabOptions& options);

  std::string name() const override { return strategy_.name(); }
  int max_elements() const override { return 1; }
  bool is_exact() const override { return strategy_.is_exact(); }
  Outcome<SolvedSlab> solve(MarchContext& context, SlabCell& cell, Random& random) override;

 private:
  Strategy& strategy_;
};

}  // namespace samara::pgd
