#pragma once

#include <cstddef>
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

  /// @param work scratch space of work_size(1); symbol k stands at k
  /// @param results root k at k
  void evaluate(std::span<double> work, double* results) const;

  /// Points in groups of kLanes: once begin_lanes(), then for each group the symbols, of which k takes the lanes from
  /// k kLanes on, evaluate_lanes(), and the roots from root_lanes(k) on.
  /// @param work scratch space of work_size(kLanes)
  void begin_lanes(std::span<double> work) const;
  void evaluate_lanes(std::span<double> work) const;
  const double* root_lanes(std::span<const double> work, std::size_t k) const {
    return work.data() + roots_[k] * kLanes;
  }

 private:
  /// Of a product that only one sum or difference needs, both together.
  enum class Fused { no, product_plus, product_minus, minus_product };

  struct Step {
    Operation operation;
    Fused fused;
    int a, b, c, to;  ///< places in the scratch space; of fused steps a and b are those of the product
  };

  /// The arguments of a node, with those of a product that goes along with it. None of a leaf, of what nobody
  /// needs, and of a product that went along.
  struct Work {
    Fused fused = Fused::no;
    int a = -1, b = -1, c = -1;  ///< nodes
  };
  static std::vector<Work> work_of(const ExpressionGraph& graph, const std::vector<int>& roots);

  struct Constant {
    int to;
    double value;
  };

  template <int lanes>
  void run(double* work) const;

  std::vector<Constant> constants_;  ///< in places of their own
  std::vector<Step> steps_;
  std::vector<int> roots_;  ///< places
  std::size_t places_ = 0;
};

/// Points, `stride` doubles from one to the next, into lanes: of entry k of the points those from k kLanes on.
void points_to_lanes(const double* points, std::ptrdiff_t stride, std::ptrdiff_t entries,
                     std::ptrdiff_t count, double* lanes);

/// The same way back, for one entry or for two that follow one another.
void lanes_to_points(const double* lanes, std::ptrdiff_t stride, std::ptrdiff_t count, double* points);
void lanes_to_points(const double* first, const double* second, std::ptrdiff_t stride, std::ptrdiff_t count,
                     double* points);

}  // namespace samara::models
