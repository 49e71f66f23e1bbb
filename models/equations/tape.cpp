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

Tape::Tape(const ExpressionGraph& graph, const std::vector<int>& roots) {
  const std::vector<char> is_needed = needed(graph, roots);
  const auto size = static_cast<std::size_t>(graph.size());
  // A place is free again after the last step that reads it; roots keep theirs.
  std::vector<int> last(size, -1), place(size, -1);
  for (int node = 0; node < graph.size(); ++node) {
    if (!is_needed[static_cast<std::size_t>(node)]) continue;
    const ExpressionNode& it = graph[node];
    if (it.operation == Operation::constant || it.operation == Operation::symbol) continue;
    last[static_cast<std::size_t>(it.a)] = node;
    if (it.b >= 0) last[static_cast<std::size_t>(it.b)] = node;
  }
  for (const int root : roots) last[static_cast<std::size_t>(root)] = graph.size();
  std::vector<int> free;
  for (int node = 0; node < graph.size(); ++node) {
    const auto at = static_cast<std::size_t>(node);
    if (!is_needed[at]) continue;
    const ExpressionNode& it = graph[node];
    Step step{it.operation, std::max(it.a, 0), 0, 0, it.value};
    if (it.operation != Operation::constant && it.operation != Operation::symbol) {
      step.a = place[static_cast<std::size_t>(it.a)];
      if (it.b >= 0) step.b = place[static_cast<std::size_t>(it.b)];
      if (last[static_cast<std::size_t>(it.a)] == node) free.push_back(step.a);
      if (it.b >= 0 && it.b != it.a && last[static_cast<std::size_t>(it.b)] == node) free.push_back(step.b);
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
void Tape::run(const double* symbols, double* work, double* results) const {
  for (const Step& step : steps_) {
    double* const to = work + step.to * lanes;
    const double* const a = (step.operation == Operation::symbol ? symbols : work) + step.a * lanes;
    const double* const b = work + step.b * lanes;
    switch (step.operation) {
      case Operation::constant:
        std::fill_n(to, lanes, step.value);
        break;
      case Operation::symbol:
        std::copy_n(a, lanes, to);
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

void Tape::evaluate(const double* symbols, std::span<double> work, double* results) const {
  run<1>(symbols, work.data(), results);
}

void Tape::evaluate_lanes(const double* symbols, std::span<double> work, double* results) const {
  run<kLanes>(symbols, work.data(), results);
}

}  // namespace samara::models
