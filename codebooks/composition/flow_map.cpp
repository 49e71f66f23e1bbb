#include "samara/codebooks/composition/flow_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/argument_checks.h"
#include "samara/codebooks/composition/window_chart.h"

namespace samara::codebooks {

namespace {

/// A motion of more windows is a mistake in the time.
constexpr double kMostWindows = 1e7;

/// What two codebooks must have alike to be charts of one flow map.
void check_second_chart(const WindowChart& first, const WindowChart& second) {
  const auto differ = [](const std::string& what) {
    throw ArgumentError(fmt::format("the second codebook of a flow map has another {} than the first", what));
  };
  if (first.book().model().name != second.book().model().name) differ("model");
  if (first.window() != second.window()) differ("length of time");
  const auto same_parameter = [](const Coordinate& a, const Coordinate& b) {
    return a.name == b.name && a.lower == b.lower && a.upper == b.upper;
  };
  if (!std::ranges::equal(first.parameters(), second.parameters(), same_parameter))
    differ("box of parameters");
  const auto fixed_parameters = [](const Codebook& book) {
    std::map<std::string, double> fixed = book.model().fixed;
    std::erase_if(fixed, [](const auto& entry) { return entry.first.ends_with("(0)"); });
    return fixed;
  };
  if (fixed_parameters(first.book()) != fixed_parameters(second.book())) differ("set of fixed parameters");
}

}  // namespace

struct FlowMap::Impl {
  std::vector<WindowChart> charts;
  WindowChart* chart = nullptr;  ///< that holds the window which was opened

  const std::vector<std::string>& states() const { return charts.front().states(); }
  const std::vector<Coordinate>& parameters() const { return charts.front().parameters(); }
  double window() const { return charts.front().window(); }

  void check(std::span<const double> start, std::span<const double> q, std::span<const double> times) const;
  bool open(WindowStart& at, bool with_derivatives, double t, FlowMapResult& result);
  void run(const Eigen::VectorXd& start, std::span<const double> times, bool with_derivatives,
           FlowMapResult& result);
};

void FlowMap::Impl::check(std::span<const double> start, std::span<const double> q,
                          std::span<const double> times) const {
  if (start.size() != states().size() || q.size() != parameters().size()) {
    throw ArgumentError(fmt::format("a flow map of {} states and {} parameters was given {} and {}",
                                    states().size(), parameters().size(), start.size(), q.size()));
  }
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (!std::isfinite(start[i])) {
      throw ArgumentError(fmt::format("{}(0) is {}, expected a finite number", states()[i], start[i]));
    }
  }
  require_inside(parameters(), q);
  double before = 0.0;
  for (const double t : times) {
    if (!(std::isfinite(t) && t >= before)) {
      throw ArgumentError(
          fmt::format("the times of a flow map hold {} after {}, expected finite ones that do "
                      "not decrease, from 0 on",
                      t, before));
    }
    before = t;
  }
  if (before > kMostWindows * window()) {
    throw ArgumentError(
        fmt::format("the times of a flow map go to {:.6g} s, expected at most {:.0e} windows of {:.6g} s",
                    before, kMostWindows, window()));
  }
}

/// In the first chart that holds the start. @returns whether one does; else the result says what leaves the box
bool FlowMap::Impl::open(WindowStart& at, bool with_derivatives, double t, FlowMapResult& result) {
  std::optional<LeavingState> leaving;
  const WindowChart* left = nullptr;
  for (WindowChart& candidate : charts) {
    const std::optional<LeavingState> out = candidate.open(at, with_derivatives);
    chart = &candidate;
    if (!out) return true;
    // Where the attitude is inside, it is the other state that matters.
    if (leaving && !(left->is_of_attitude(leaving->state) && !candidate.is_of_attitude(out->state))) continue;
    leaving = out;
    left = &candidate;
  }
  result.status = FlowMapStatus::left_box;
  result.left = states()[leaving->state];
  result.message = fmt::format("the flow map left the box at t = {:.6g}: {}", t, left->words(*leaving));
  return false;
}

void FlowMap::Impl::run(const Eigen::VectorXd& start, std::span<const double> times, bool with_derivatives,
                        FlowMapResult& result) {
  const Eigen::Index n = start.size();
  const auto m = static_cast<Eigen::Index>(parameters().size());
  WindowStart at;
  at.start = start;
  at.shift.resize(states().size());
  Eigen::VectorXd end(n);
  Eigen::MatrixXd by_start(n, n), by_parameters(n, m);
  // d(x at the start of the window)/d(start, parameters)
  Eigen::MatrixXd so_far = Eigen::MatrixXd::Zero(n, n + m);
  so_far.leftCols(n).setIdentity();
  Eigen::MatrixXd* const A = with_derivatives ? &by_start : nullptr;
  Eigen::MatrixXd* const B = with_derivatives ? &by_parameters : nullptr;
  const auto composed = [&] {
    Eigen::MatrixXd all = by_start * so_far;
    all.rightCols(m) += by_parameters;
    return all;
  };
  std::size_t next = 0;
  for (long k = 0; next < times.size(); ++k) {
    const double begin = static_cast<double>(k) * window();
    if (!open(at, with_derivatives, begin, result)) return;
    // The end of the last window serves the times at its border: rounding must not open another one.
    for (; next < times.size() && times[next] - begin <= window() * (1.0 + 1e-12); ++next) {
      chart->answer(at, times[next] - begin, end, A, B);
      result.states.row(static_cast<Eigen::Index>(next)) = end.transpose();
      if (with_derivatives) result.derivatives[next] = composed();
      result.reached = times[next];
    }
    if (next == times.size()) break;
    chart->answer(at, window(), end, A, B);
    if (with_derivatives) so_far = composed();
    at.start = end;
  }
  result.message = fmt::format("{} times up to {:.6g}", times.size(), result.reached);
}

FlowMap::FlowMap(const Codebook& book) : impl_(std::make_unique<Impl>()) {
  impl_->charts.emplace_back(book);
}
FlowMap::FlowMap(const Codebook& book, const Codebook& second) : FlowMap(book) {
  impl_->charts.emplace_back(second);
  check_second_chart(impl_->charts[0], impl_->charts[1]);
}
FlowMap::~FlowMap() = default;
FlowMap::FlowMap(FlowMap&&) noexcept = default;
FlowMap& FlowMap::operator=(FlowMap&&) noexcept = default;

const std::vector<std::string>& FlowMap::states() const {
  return impl_->states();
}
const std::vector<Coordinate>& FlowMap::parameters() const {
  return impl_->parameters();
}
double FlowMap::window() const {
  return impl_->window();
}

FlowMapResult FlowMap::run(std::span<const double> start, std::span<const double> parameters,
                           std::span<const double> times, bool with_derivatives) {
  impl_->check(start, parameters, times);
  const auto states = static_cast<Eigen::Index>(start.size());
  const auto count = static_cast<Eigen::Index>(times.size());
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  FlowMapResult result;
  result.states.setConstant(count, states, kUnknown);
  if (with_derivatives) {
    const auto columns = states + static_cast<Eigen::Index>(parameters.size());
    result.derivatives.assign(times.size(), Eigen::MatrixXd::Constant(states, columns, kUnknown));
  }
  for (WindowChart& chart : impl_->charts) chart.set_parameters(parameters);
  impl_->run(Eigen::Map<const Eigen::VectorXd>(start.data(), states), times, with_derivatives, result);
  return result;
}

}  // namespace samara::codebooks
