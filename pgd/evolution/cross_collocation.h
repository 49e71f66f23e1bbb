#pragma once

#include "samara/pgd/evolution/slab_solver.h"

namespace samara::pgd {

/// The collocation's solution, a function of the parameters, interpolated by crosses: the equations are solved
/// at the entries that these ask for, and only there.
class CrossCollocation final : public SlabSolver {
 public:
  explicit CrossCollocation(int max_elements) : max_elements_(max_elements) {}

  std::string name() const override { return "collocation at the entries of a cross"; }
  int max_elements() const override { return max_elements_; }
  bool is_exact() const override { return true; }
  Outcome<SolvedSlab> solve(MarchContext& context, SlabCell& cell, Random& random) override;

 private:
  int max_elements_;
};

}  // namespace samara::pgd
