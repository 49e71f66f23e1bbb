#include "samara/models/equations/expression_graph.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace samara::models {

namespace {

bool has_kink(Operation operation) {
  using enum Operation;
  return operation == absolute || operation == smaller || operation == larger || operation == sign ||
         operation == step;
}

}  // namespace

bool is_binary(Operation operation) {
  using enum Operation;
  switch (operation) {
    case add:
    case subtract:
    case multiply:
    case product:
    case divide:
    case quotient:
    case power:
    case arctangent2:
    case smaller:
    case larger:
      return true;
    default:
      return false;
  }
}

double apply(Operation operation, double a, double b) {
  using enum Operation;
  switch (operation) {
    case constant:
    case symbol:
      return a;
    case add:
      return a + b;
    case subtract:
      return a - b;
    case multiply:
      return a * b;
    case product:
      return a == 0.0 ? 0.0 : a * b;
    case divide:
      return a / b;
    case quotient:
      return a == 0.0 && b == 0.0 ? 0.0 : a / b;
    case negate:
      return -a;
    case power:
      return std::pow(a, b);
    case square_root:
      return std::sqrt(a);
    case exponential:
      return std::exp(a);
    case logarithm:
      return std::log(a);
    case sine:
      return std::sin(a);
    case cosine:
      return std::cos(a);
    case tangent:
      return std::tan(a);
    case arcsine:
      return std::asin(a);
    case arccosine:
      return std::acos(a);
    case arctangent:
      return std::atan(a);
    case arctangent2:
      return std::atan2(a, b);
    case hyperbolic_sine:
      return std::sinh(a);
    case hyperbolic_cosine:
      return std::cosh(a);
    case hyperbolic_tangent:
      return std::tanh(a);
    case absolute:
      return std::abs(a);
    case smaller:
      return std::min(a, b);
    case larger:
      return std::max(a, b);
    case sign:
      return a > 0.0 ? 1.0 : a < 0.0 ? -1.0 : 0.0;
    case step:
      return a >= 0.0 ? 1.0 : 0.0;
  }
  return a;
}

bool ExpressionGraph::is_constant(int node, double value) const {
  const ExpressionNode& it = (*this)[node];
  return it.operation == Operation::constant && it.value == value;
}

int ExpressionGraph::constant(double value) {
  return insert({.value = value + 0.0});
}  // no negative zero

int ExpressionGraph::symbol(int number) {
  return insert({.operation = Operation::symbol, .a = number});
}

int ExpressionGraph::insert(const ExpressionNode& node) {
  const auto [it, is_new] = known_.try_emplace(node, size());
  if (is_new) nodes_.push_back(node);
  return it->second;
}

/// An older node that is worth the same, or -1.
int ExpressionGraph::simplified(Operation operation, int a, int b) const {
  using enum Operation;
  switch (operation) {
    case add:
      if (is_constant(a, 0.0)) return b;
      if (is_constant(b, 0.0)) return a;
      break;
    case subtract:
      if (is_constant(b, 0.0)) return a;
      break;
    case multiply:
    case product:
      if (is_constant(a, 0.0) || is_constant(b, 1.0)) return a;
      if (is_constant(b, 0.0) || is_constant(a, 1.0)) return b;
      break;
    case divide:
    case quotient:
      if (is_constant(b, 1.0)) return a;
      break;
    case negate:
      if ((*this)[a].operation == Operation::negate) return (*this)[a].a;
      break;
    default:
      break;
  }
  return -1;
}

int ExpressionGraph::make(Operation operation, int a, int b) {
  using enum Operation;
  const bool known = (*this)[a].operation == constant && (b < 0 || (*this)[b].operation == constant);
  if (known) {
    const double value = apply(operation, (*this)[a].value, b < 0 ? 0.0 : (*this)[b].value);
    if (std::isfinite(value)) return this->constant(value);
  }
  if (const int same = simplified(operation, a, b); same >= 0) return same;
  if (operation == subtract && is_constant(a, 0.0)) return make(negate, b);
  if (operation == power && is_constant(b, 0.5)) return make(square_root, a);
  if (operation == power && (*this)[b].operation == constant) {
    constexpr double kMostProducts = 16.0;
    const double exponent = (*this)[b].value;
    if (exponent == std::round(exponent) && std::abs(exponent) <= kMostProducts)
      return whole_power(a, static_cast<int>(exponent));
  }
  if ((operation == add || operation == multiply) && b < a) std::swap(a, b);
  return insert({operation, a, b});
}

/// By products, which are cheaper than a power.
int ExpressionGraph::whole_power(int base, int exponent) {
  if (exponent < 0) return make(Operation::divide, constant(1.0), whole_power(base, -exponent));
  if (exponent == 0) return constant(1.0);
  if (exponent == 1) return base;
  const int root = whole_power(base, exponent / 2);
  const int square = make(Operation::multiply, root, root);
  return exponent % 2 == 0 ? square : make(Operation::multiply, square, base);
}

Standing ExpressionGraph::standing(int node, int number) {
  std::vector<Standing>& known = standings_[number];
  while (known.size() <= static_cast<std::size_t>(node)) {
    const auto [operation, a, b, value] = nodes_[known.size()];
    Standing own = Standing::absent;
    if (operation == Operation::symbol) {
      if (a == number) own = Standing::smooth;
    } else if (operation != Operation::constant) {
      own = known[static_cast<std::size_t>(a)];
      if (b >= 0) own = std::max(own, known[static_cast<std::size_t>(b)]);
      if (own == Standing::smooth && has_kink(operation)) own = Standing::kinked;
    }
    known.push_back(own);
  }
  return known[static_cast<std::size_t>(node)];
}

int ExpressionGraph::derivative(int node, int number) {
  const auto is_missing = [&](int of) {
    return standing(of, number) != Standing::absent && !derivatives_.contains({of, number});
  };
  // Arguments are older than what is made of them: without recursion, whose depth a long sum would exhaust.
  std::vector<int> wanted = {node};
  while (!wanted.empty()) {
    const int next = wanted.back();
    const ExpressionNode it = (*this)[next];
    std::vector<int> before;
    if (it.operation != Operation::constant && it.operation != Operation::symbol) {
      for (const int argument : {it.a, it.b}) {
        if (argument >= 0 && is_missing(argument)) before.push_back(argument);
      }
    }
    if (!before.empty()) {
      wanted.insert(wanted.end(), before.begin(), before.end());
      continue;
    }
    wanted.pop_back();
    if (is_missing(next)) derivatives_[{next, number}] = differentiate(next, number);
  }
  return known_derivative(node, number);
}

int ExpressionGraph::known_derivative(int node, int number) {
  return standing(node, number) == Standing::absent ? constant(0.0) : derivatives_.at({node, number});
}

/// With the derivatives of its arguments at hand, of a node in which the symbol stands.
int ExpressionGraph::differentiate(int node, int number) {
  using enum Operation;
  const auto [operation, a, b, value] = (*this)[node];
  if (operation == Operation::symbol) return this->constant(1.0);
  const int da = known_derivative(a, number), db = b >= 0 ? known_derivative(b, number) : -1;
  const auto times = [&](int x, int y) { return make(multiply, x, y); };
  const auto one = [&] { return this->constant(1.0); };
  const auto square = [&](int x) { return times(x, x); };
  const auto from_one = [&](int x) { return make(subtract, one(), x); };
  if (is_constant(da, 0.0) && (b < 0 || is_constant(db, 0.0))) return da;
  switch (operation) {
    case add:
    case subtract:
      return make(operation, da, db);
    case multiply:
      return make(add, times(da, b), times(a, db));
    case product:
      return make(add, make(product, da, b), make(product, a, db));
    case divide:
    case quotient:
      return make(operation, make(subtract, da, times(node, db)), b);
    case negate:
      return make(negate, da);
    case power: {
      int sum = make(product, da, times(b, make(power, a, make(subtract, b, one()))));
      if (!is_constant(db, 0.0)) sum = make(add, sum, times(make(product, node, make(logarithm, a)), db));
      return sum;
    }
    case square_root:
      return make(quotient, da, times(this->constant(2.0), node));
    case exponential:
      return times(node, da);
    case logarithm:
      return make(divide, da, a);
    case sine:
      return times(make(cosine, a), da);
    case cosine:
      return make(negate, times(make(sine, a), da));
    case tangent:
      return times(make(add, one(), square(node)), da);
    case arcsine:
      return make(divide, da, make(square_root, from_one(square(a))));
    case arccosine:
      return make(negate, make(divide, da, make(square_root, from_one(square(a)))));
    case arctangent:
      return make(divide, da, make(add, one(), square(a)));
    case arctangent2:
      return make(quotient, make(subtract, times(b, da), times(a, db)), make(add, square(a), square(b)));
    case hyperbolic_sine:
      return times(make(hyperbolic_cosine, a), da);
    case hyperbolic_cosine:
      return times(make(hyperbolic_sine, a), da);
    case hyperbolic_tangent:
      return times(from_one(square(node)), da);
    case absolute:
      return times(make(sign, a), da);
    case smaller:
    case larger: {
      const bool is_larger = operation == larger;
      const int takes_a = make(step, is_larger ? make(subtract, a, b) : make(subtract, b, a));
      return make(add, times(takes_a, da), times(from_one(takes_a), db));
    }
    default:
      return this->constant(0.0);  // sign and step
  }
}

}  // namespace samara::models
