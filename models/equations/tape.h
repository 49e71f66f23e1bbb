#pragma once

#include <span>
#include <vector>

#include "samara/models/equations/expression_graph.h"

/// Internal to models/.
namespace samara::models {

/// Expressions of a graph as a list of steps, each on many points at a time: where a step of one point would cost as
/// much in finding out what to do as in doing it.
class Tape {
 public:
  /// Points that go together.
  static constexpr int kLanes = 32;

  Tape() = default;
  /// @param roots the nodes that are wanted
  /// @param symbols how many there are
  Tape(const ExpressionGraph& graph, const std::vector<int>& roots, int symbols);

  /// Doubles of scratch space that evaluate() needs for so many lanes (1 or kLanes).
  std::size_t work_size(int lanes) const { return places_ * static_cast<std::size_t>(lanes); }
  int root_count() const { return static_cast<int>(roots_.size()); }

  /// @param work scratch space of work_size(lanes); symbol k stands at lanes k*lanes, .. and stays there
  /// @param results root k likewise
  void evaluate(std::span<double> work, double* results) const;
  void evaluate_lanes(std::span<double> work, double* results) const;

 private:
  /// Of a product that only one sum or difference needs, both together.
  enum class Fused { no, product_plus, product_minus, minus_product };

  struct Step {
    Operation operation;
    Fused fused;
    int a, b, c, to;  ///< places in the scratch space; of fused steps a and b are those of the product
    double value;
  };

  /// The arguments of a node, with those of a product that goes along with it. None of a leaf, of what nobody needs, and
  /// of a product that went along.
  struct Work {
    Fused fused = Fused::no;
    int a = -1, b = -1, c = -1;  ///< nodes
  };
  static std::vector<Work> work_of(const ExpressionGraph& graph, const std::vector<int>& roots);

  template <int lanes>
  void run(double* work, double* results) const;

  std::vector<Step> steps_;
  std::vector<int> roots_;  ///< places
  std::size_t places_ = 0;
};

}  // namespace samara::models
