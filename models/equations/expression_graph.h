#pragma once

#include <compare>
#include <map>
#include <utility>
#include <vector>

/// Internal to models/.
namespace samara::models {

/// What a node of an expression computes of its arguments a and b.
enum class Operation {
  constant,
  symbol,
  add,
  subtract,
  multiply,
  product,  ///< a*b, but 0 where a is, whatever b
  divide,
  quotient,  ///< a/b, but 0 for 0/0
  negate,
  power,
  square_root,
  exponential,
  logarithm,
  sine,
  cosine,
  tangent,
  arcsine,
  arccosine,
  arctangent,
  arctangent2,
  hyperbolic_sine,
  hyperbolic_cosine,
  hyperbolic_tangent,
  absolute,
  smaller,
  larger,
  sign,  ///< -1, 0, 1
  step,  ///< 1 where a >= 0, else 0
};

struct ExpressionNode {
  Operation operation = Operation::constant;
  int a = -1, b = -1;  ///< nodes; of a symbol, a is its number
  double value = 0.0;  ///< of a constant
  auto operator<=>(const ExpressionNode&) const = default;
};

/// Whether the operation has a second argument.
bool is_binary(Operation operation);

/// How a symbol stands in an expression.
enum class Standing : char {
  absent,
  smooth,
  kinked,  ///< within abs, min, max, sign or step
};

/// f(a, b), as evaluation has it.
double apply(Operation operation, double a, double b);

/// Expressions that share their parts: equal ones are one node, and what is known beforehand (constants, sums with
/// zero, products with one) is worked out as they are made.
class ExpressionGraph {
 public:
  int constant(double value);
  /// A variable, by its number.
  int symbol(int number);
  int make(Operation operation, int a, int b = -1);

  const ExpressionNode& operator[](int node) const { return nodes_[static_cast<std::size_t>(node)]; }
  int size() const { return static_cast<int>(nodes_.size()); }
  bool is_constant(int node, double value) const;

  /// How symbol `number` stands in a node.
  Standing standing(int node, int number);

  /// The exact derivative of a node by symbol `number`. Where min, max, abs, sign or step have none it is that of one
  /// side; where the chain rule gives 0/0 or 0 times infinity, such as of sqrt(u^2 + v^2) at rest, roots, powers and
  /// atan2 have 0.
  int derivative(int node, int number);

 private:
  int insert(const ExpressionNode& node);
  int simplified(Operation operation, int a, int b) const;
  int whole_power(int base, int exponent);
  int differentiate(int node, int number);
  int known_derivative(int node, int number);

  std::vector<ExpressionNode> nodes_;
  std::map<ExpressionNode, int> known_;
  std::map<std::pair<int, int>, int> derivatives_;  ///< by node and symbol, where the symbol is not absent
  std::map<int, std::vector<Standing>> standings_;  ///< by symbol, of the nodes from the first on
};

}  // namespace samara::models
