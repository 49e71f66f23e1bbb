#include "samara/models/equations/tape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

namespace samara::models {

namespace {

bool is_leaf(const ExpressionNode& node) {
  return node.operation == Operation::constant || node.operation == Operation::symbol;
}

/// How often each node is needed, by roots or as an argument of what they need.
std::vector<int> count_uses(const ExpressionGraph& graph, const std::vector<int>& roots) {
  std::vector<int> uses(static_cast<std::size_t>(graph.size()));
  for (const int root : roots) ++uses[static_cast<std::size_t>(root)];
  for (int node = graph.size() - 1; node >= 0; --node) {
    const ExpressionNode& it = graph[node];
    if (uses[static_cast<std::size_t>(node)] == 0 || is_leaf(it)) continue;
    ++uses[static_cast<std::size_t>(it.a)];
    if (it.b >= 0) ++uses[static_cast<std::size_t>(it.b)];
  }
  return uses;
}

/// Two doubles at a time, from and to anywhere.
using Pair = double __attribute__((vector_size(16)));

Pair pair_at(const double* from) {
  Pair pair;
  std::memcpy(&pair, from, sizeof pair);
  return pair;
}

void put_pair(Pair pair, double* to) {
  std::memcpy(to, &pair, sizeof pair);
}

template <int lanes, class F>
void each(F&& f) {
  for (int k = 0; k < lanes; ++k) f(k);
}

}  // namespace

std::vector<Tape::Work> Tape::work_of(const ExpressionGraph& graph, const std::vector<int>& roots) {
  const std::vector<int> uses = count_uses(graph, roots);
  std::vector<char> is_root(uses.size());
  for (const int root : roots) is_root[static_cast<std::size_t>(root)] = 1;
  const auto may_go_along = [&](int node) {
    const auto at = static_cast<std::size_t>(node);
    return graph[node].operation == Operation::multiply && uses[at] == 1 && !is_root[at];
  };
  std::vector<Work> work(uses.size());
  std::vector<char> went_along(uses.size());
  for (int node = graph.size() - 1; node >= 0; --node) {
    const ExpressionNode& it = graph[node];
    const auto at = static_cast<std::size_t>(node);
    if (uses[at] == 0 || is_leaf(it) || went_along[at]) continue;
    work[at] = {Fused::no, it.a, it.b, -1};
    const bool is_sum = it.operation == Operation::add;
    if (!is_sum && it.operation != Operation::subtract) continue;
    const bool is_second = may_go_along(it.b);
    if (!is_second && !may_go_along(it.a)) continue;
    const int product = is_second ? it.b : it.a;
    work[at] = {is_sum      ? Fused::product_plus
                : is_second ? Fused::minus_product
                            : Fused::product_minus,
                graph[product].a, graph[product].b, is_second ? it.a : it.b};
    went_along[static_cast<std::size_t>(product)] = 1;
  }
  return work;
}

Tape::Tape(const ExpressionGraph& graph, const std::vector<int>& roots, int symbols)
    : places_(static_cast<std::size_t>(symbols)) {
  const std::vector<Work> work = work_of(graph, roots);
  const std::vector<int> uses = count_uses(graph, roots);
  const auto size = static_cast<std::size_t>(graph.size());
  // A place is free again after the last step that reads it; those of symbols and roots are kept.
  std::vector<int> last(size, -1), place(size, -1);
  for (int node = 0; node < graph.size(); ++node) {
    const Work& own = work[static_cast<std::size_t>(node)];
    for (const int argument : {own.a, own.b, own.c})
      if (argument >= 0) last[static_cast<std::size_t>(argument)] = node;
  }
  for (const int root : roots) last[static_cast<std::size_t>(root)] = graph.size();
  std::vector<int> free;
  for (int node = 0; node < graph.size(); ++node) {
    const auto at = static_cast<std::size_t>(node);
    const ExpressionNode& it = graph[node];
    if (it.operation == Operation::symbol) {
      place[at] = it.a;
      continue;
    }
    if (it.operation == Operation::constant && uses[at] > 0) {
      place[at] = static_cast<int>(places_++);
      constants_.push_back({place[at], it.value});
      continue;
    }
    const Work& own = work[at];
    if (own.a < 0) continue;
    Step step{it.operation, own.fused, 0, 0, 0, 0};
    const std::array<int, 3> arguments = {own.a, own.b, own.c};
    const std::array<int*, 3> places = {&step.a, &step.b, &step.c};
    for (std::size_t k = 0; k < arguments.size(); ++k) {
      const int argument = arguments[k];
      if (argument < 0) continue;
      *places[k] = place[static_cast<std::size_t>(argument)];
      const bool is_first =
          std::find(arguments.begin(), arguments.begin() + k, argument) == arguments.begin() + k;
      if (is_first && last[static_cast<std::size_t>(argument)] == node && !is_leaf(graph[argument]))
        free.push_back(place[static_cast<std::size_t>(argument)]);
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
void Tape::run(double* work) const {
  for (const Step& step : steps_) {
    double* const to = work + step.to * lanes;
    const double* const a = work + step.a * lanes;
    const double* const b = work + step.b * lanes;
    const double* const c = work + step.c * lanes;
    switch (step.fused) {
      case Fused::no:
        break;
      case Fused::product_plus:
        each<lanes>([&](int k) { to[k] = a[k] * b[k] + c[k]; });
        continue;
      case Fused::product_minus:
        each<lanes>([&](int k) { to[k] = a[k] * b[k] - c[k]; });
        continue;
      case Fused::minus_product:
        each<lanes>([&](int k) { to[k] = c[k] - a[k] * b[k]; });
        continue;
    }
    switch (step.operation) {
      case Operation::add:
        each<lanes>([&](int k) { to[k] = a[k] + b[k]; });
        break;
      case Operation::subtract:
        each<lanes>([&](int k) { to[k] = a[k] - b[k]; });
        break;
      case Operation::multiply:
        each<lanes>([&](int k) { to[k] = a[k] * b[k]; });
        break;
      case Operation::product:
        each<lanes>([&](int k) {
          const double plain = a[k] * b[k];
          to[k] = a[k] == 0.0 ? 0.0 : plain;
        });
        break;
      case Operation::divide:
        each<lanes>([&](int k) { to[k] = a[k] / b[k]; });
        break;
      case Operation::quotient:
        each<lanes>([&](int k) {
          const double plain = a[k] / b[k];
          to[k] = a[k] == 0.0 && b[k] == 0.0 ? 0.0 : plain;
        });
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
}

void Tape::evaluate(std::span<double> work, double* results) const {
  for (const Constant& constant : constants_) work[static_cast<std::size_t>(constant.to)] = constant.value;
  run<1>(work.data());
  for (std::size_t k = 0; k < roots_.size(); ++k) results[k] = work[static_cast<std::size_t>(roots_[k])];
}

void Tape::begin_lanes(std::span<double> work) const {
  for (const Constant& constant : constants_)
    std::fill_n(work.data() + constant.to * kLanes, kLanes, constant.value);
}

void Tape::evaluate_lanes(std::span<double> work) const {
  run<kLanes>(work.data());
}

void points_to_lanes(const double* points, std::ptrdiff_t stride, std::ptrdiff_t entries,
                     std::ptrdiff_t count, double* lanes) {
  std::ptrdiff_t k = 0;
  for (; k + 1 < entries; k += 2) {
    double* const first = lanes + k * Tape::kLanes;
    double* const second = first + Tape::kLanes;
    const double* from = points + k;
    std::ptrdiff_t lane = 0;
    for (; lane + 1 < count; lane += 2, from += 2 * stride) {
      const Pair one = pair_at(from), other = pair_at(from + stride);
      put_pair(__builtin_shufflevector(one, other, 0, 2), first + lane);
      put_pair(__builtin_shufflevector(one, other, 1, 3), second + lane);
    }
    if (lane < count) {
      first[lane] = from[0];
      second[lane] = from[1];
    }
  }
  for (; k < entries; ++k) {
    for (std::ptrdiff_t lane = 0; lane < count; ++lane)
      lanes[k * Tape::kLanes + lane] = points[lane * stride + k];
  }
}

void lanes_to_points(const double* lanes, std::ptrdiff_t stride, std::ptrdiff_t count, double* points) {
  for (std::ptrdiff_t lane = 0; lane < count; ++lane) points[lane * stride] = lanes[lane];
}

void lanes_to_points(const double* first, const double* second, std::ptrdiff_t stride, std::ptrdiff_t count,
                     double* points) {
  std::ptrdiff_t lane = 0;
  for (; lane + 1 < count; lane += 2, points += 2 * stride) {
    const Pair one = pair_at(first + lane), other = pair_at(second + lane);
    put_pair(__builtin_shufflevector(one, other, 0, 2), points);
    put_pair(__builtin_shufflevector(one, other, 1, 3), points + stride);
  }
  if (lane < count) {
    points[0] = first[lane];
    points[1] = second[lane];
  }
}

}  // namespace samara::models
