#include "samara/models/equations/tape.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace samara::models {

namespace {

/// The nodes that the roots need, arguments first.
std::vector<char> needed(const ExpressionGraph& graph, const std::vector<int>& roots) {
  std::vector<char> is_needed(static_cast<std::size_t>(graph.size()));
  for (const int root : roots) is_needed[static_cast<std::size_t>(root)] = 1;
  for (int node = graph.size() - 1; node >= 0; --node) {
    const ExpressionNode& it = graph[node];
    if (!is_needed[static_cast<std::size_t>(node)] || it.operation == Operation::constant ||
        it.operation == Operation::symbol)
      continue;
    is_needed[static_cast<std::size_t>(it.a)] = 1;
    if (it.b >= 0) is_needed[static_cast<std::size_t>(it.b)] = 1;
  }
  return is_needed;
}

template <int lanes, class F>
void each(F&& f) {
  for (int k = 0; k < lanes; ++k) f(k);
}

}  // namespace

Tape::Tape(const ExpressionGraph& graph, const std::vector<int>& roots, int symbols)
    : places_(static_cast<std::size_t>(symbols)) {
  const std::vector<char> is_needed = needed(graph, roots);
  const auto size = static_cast<std::size_t>(graph.size());
  const auto is_leaf = [&](int node) {
    return graph[node].operation == Operation::constant || graph[node].operation == Operation::symbol;
  };
  // A place is free again after the last step that reads it; those of symbols and roots are kept.
  std::vector<int> last(size, -1), place(size, -1);
  for (int node = 0; node < graph.size(); ++node) {
    if (!is_needed[static_cast<std::size_t>(node)] || is_leaf(node)) continue;
    last[static_cast<std::size_t>(graph[node].a)] = node;
    if (graph[node].b >= 0) last[static_cast<std::size_t>(graph[node].b)] = node;
  }
  for (const int root : roots) last[static_cast<std::size_t>(root)] = graph.size();
  std::vector<int> free;
  const auto release = [&](int argument, int node) {
    if (last[static_cast<std::size_t>(argument)] == node && graph[argument].operation != Operation::symbol)
      free.push_back(place[static_cast<std::size_t>(argument)]);
  };
  for (int node = 0; node < graph.size(); ++node) {
    const auto at = static_cast<std::size_t>(node);
    if (!is_needed[at]) continue;
    const ExpressionNode& it = graph[node];
    if (it.operation == Operation::symbol) {
      place[at] = it.a;
      continue;
    }
    Step step{it.operation, 0, 0, 0, it.value};
    if (!is_leaf(node)) {
      step.a = place[static_cast<std::size_t>(it.a)];
      release(it.a, node);
      if (it.b >= 0) step.b = place[static_cast<std::size_t>(it.b)];
      if (it.b >= 0 && it.b != it.a) release(it.b, node);
    }
    if (free.empty()) {
      step.to = static_cast<int>(places_++);
    } else {
      step.to = free.back();
      free.pop_back();
    }
    place[at] = step.to;
    steps_.push_back(step);
  }
  for (const int root : roots) roots_.push_back(place[static_cast<std::size_t>(root)]);
}

template <int lanes>
void Tape::run(double* work, double* results) const {
  for (const Step& step : steps_) {
    double* const to = work + step.to * lanes;
    const double* const a = work + step.a * lanes;
    const double* const b = work + step.b * lanes;
    switch (step.operation) {
      case Operation::constant:
        std::fill_n(to, lanes, step.value);
        break;
      case Operation::add:
        each<lanes>([&](int k) { to[k] = a[k] + b[k]; });
        break;
      case Operation::subtract:
        each<lanes>([&](int k) { to[k] = a[k] - b[k]; });
        break;
      case Operation::multiply:
        each<lanes>([&](int k) { to[k] = a[k] * b[k]; });
        break;
      case Operation::divide:
        each<lanes>([&](int k) { to[k] = a[k] / b[k]; });
        break;
      case Operation::negate:
        each<lanes>([&](int k) { to[k] = -a[k]; });
        break;
      case Operation::square_root:
        each<lanes>([&](int k) { to[k] = std::sqrt(a[k]); });
        break;
      default:
        each<lanes>([&](int k) { to[k] = apply(step.operation, a[k], b[k]); });
        break;
    }
  }
  for (std::size_t k = 0; k < roots_.size(); ++k)
    std::copy_n(work + roots_[k] * lanes, lanes, results + k * static_cast<std::size_t>(lanes));
}

void Tape::evaluate(std::span<double> work, double* results) const {
  run<1>(work.data(), results);
}

void Tape::evaluate_lanes(std::span<double> work, double* results) const {
  run<kLanes>(work.data(), results);
}

}  // namespace samara::models
