#include "samara/codebooks/chain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/box.h"
#include "samara/codebooks/certify.h"
#include "samara/codebooks/query.h"
#include "samara/models/parametric_model.h"

namespace samara::codebooks {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// How a state goes from window to window.
struct Carried {
  int output = 0;                 ///< place in the codebook's outputs
  std::optional<int> coordinate;  ///< of "s(0)"; none: the state is only displaced
  double origin = 0.0;            ///< initial value in the codebook, of a state that is only displaced
  double lower = 0.0, upper = 0.0;
  bool wraps = false;  ///< an angle whose axis is a full turn wide
};

std::optional<int> find_name(const auto& list, const std::string& name) {
  const auto found = std::ranges::find_if(list, [&](const auto& item) { return item.name == name; });
  if (found == list.end()) return std::nullopt;
  return static_cast<int>(found - list.begin());
}

/// f at the middle of the box, with one state moved and at some time.
std::vector<double> rate(const models::ParametricModel& model, std::span<const double> middle, double t,
                         std::size_t moved, double by) {
  models::ParametricModel::Workspace workspace = model.make_workspace();
  std::vector<double> x(static_cast<std::size_t>(model.state_count()));
  std::vector<double> f(x.size());
  model.initial(middle, x);
  x[moved] += by;
  model.rhs(t, x, middle, f, workspace);
  return f;
}

/// To round-off of the larger rates.
bool nearly_equal(const std::vector<double>& a, const std::vector<double>& b) {
  double size = 0.0, difference = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    size = std::max({size, std::abs(a[i]), std::abs(b[i])});
    difference = std::max(difference, std::abs(a[i] - b[i]));
  }
  return difference <= 1e-10 * size;
}

}  // namespace

struct Chain::Impl {
  const Codebook& book;
  Query query;
  std::vector<std::string> states;
  std::vector<std::string> units;
  std::vector<Carried> carried;
  std::vector<Coordinate> parameters;
  std::vector<int> parameter_places;  ///< coordinates of the codebook
  double window = 0.0;

  std::vector<double> point;
  Eigen::VectorXd values;
  Eigen::MatrixXd gradient;

  explicit Impl(const Codebook& codebook);
  Carried carry(const models::ModelInfo& info, std::size_t state, bool is_angle) const;
  void check(std::span<const double> start, std::span<const double> q, std::span<const double> times) const;
  /// Loads the start of a window. @returns the state that is outside the box, if one is
  std::optional<std::size_t> load(const Eigen::VectorXd& x, std::vector<double>& shift);
  /// States at a time of the window, and their derivatives by the states at its start and the parameters.
  void answer(double t, const std::vector<double>& shift, Eigen::VectorXd& x, Eigen::MatrixXd* by_start,
              Eigen::MatrixXd* by_parameters);
  void run(const Eigen::VectorXd& start, std::span<const double> times, bool with_derivatives,
           ChainResult& result);
};

Carried Chain::Impl::carry(const models::ModelInfo& info, std::size_t state, bool is_angle) const {
  const std::string& name = info.states[state].name;
  Carried result;
  const std::optional<int> output = find_name(book.outputs(), name);
  if (!output) throw ArgumentError(fmt::format("a chain needs the state \"{}\" among the outputs", name));
  result.output = *output;
  result.coordinate = find_name(book.coordinates(), name + "(0)");
  if (result.coordinate) {
    const Coordinate& axis = book.coordinates()[static_cast<std::size_t>(*result.coordinate)];
    result.lower = axis.lower;
    result.upper = axis.upper;
    result.wraps = is_angle && axis.upper - axis.lower >= kTurn * (1.0 - 1e-9);
    return result;
  }
  if (std::ranges::count(info.symmetries, "translation of " + name) == 0) {
    throw ArgumentError(fmt::format(
        "a chain needs an axis \"{}(0)\": the model \"{}\" notices where {} starts", name, info.name, name));
  }
  const auto fixed = book.model().fixed.find(name + "(0)");
  result.origin = fixed == book.model().fixed.end() ? info.states[state].default_initial : fixed->second;
  return result;
}

Chain::Impl::Impl(const Codebook& codebook) : book(codebook), query(codebook) {
  const models::ParametricModel model = model_of(book);
  const models::ModelInfo& info = model.model().info();
  std::vector<double> middle;
  for (std::size_t k = 1; k < book.coordinates().size(); ++k) {
    const Coordinate& c = book.coordinates()[k];
    middle.push_back(0.5 * (c.lower + c.upper));
    if (c.role == pgd::AxisRole::initial) continue;
    parameters.push_back(c);
    parameter_places.push_back(static_cast<int>(k));
  }
  const Coordinate& time = book.time("a chain");
  window = time.upper;
  if (time.lower != 0.0) {
    throw ArgumentError(
        fmt::format("a chain needs a codebook from t = 0 on; this one begins at {}", time.lower));
  }
  const std::vector<double> f = rate(model, middle, 0.0, 0, 0.0);
  if (!nearly_equal(f, rate(model, middle, 0.37 * window, 0, 0.0))) {
    throw ArgumentError(fmt::format("a chain needs an autonomous model; \"{}\" depends on time", info.name));
  }
  for (std::size_t i = 0; i < info.states.size(); ++i) {
    states.push_back(info.states[i].name);
    units.push_back(info.states[i].unit);
    // The unit does not tell: of dimensionless models it is 1.
    const auto notices = [&](double turn) { return !nearly_equal(f, rate(model, middle, 0.0, i, turn)); };
    carried.push_back(carry(info, i, notices(1.0) && !notices(kTurn)));
  }
  point.resize(book.coordinates().size());
  values.resize(book.output_count());
  gradient.resize(book.output_count(), book.coordinate_count());
}

void Chain::Impl::check(std::span<const double> start, std::span<const double> q,
                        std::span<const double> times) const {
  if (start.size() != states.size() || q.size() != parameters.size()) {
    throw ArgumentError(fmt::format("a chain of {} states and {} parameters was given {} and {}",
                                    states.size(), parameters.size(), start.size(), q.size()));
  }
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (!std::isfinite(start[i])) {
      throw ArgumentError(fmt::format("{}(0) is {}, expected a finite number", states[i], start[i]));
    }
  }
  require_inside(parameters, q);
  double before = 0.0;
  for (const double t : times) {
    if (!(std::isfinite(t) && t >= before)) {
      throw ArgumentError(
          fmt::format("the times of a chain hold {} after {}, expected finite ones that do "
                      "not decrease, from 0 on",
                      t, before));
    }
    before = t;
  }
}

std::optional<std::size_t> Chain::Impl::load(const Eigen::VectorXd& x, std::vector<double>& shift) {
  for (std::size_t i = 0; i < carried.size(); ++i) {
    const Carried& state = carried[i];
    double value = x[static_cast<Eigen::Index>(i)];
    if (!state.coordinate) {
      shift[i] = value - state.origin;
      continue;
    }
    shift[i] = state.wraps ? kTurn * std::floor((value - state.lower) / kTurn) : 0.0;
    value -= shift[i];
    // Rounding of the wrap may step over the border by its last digits.
    if (state.wraps) value = std::clamp(value, state.lower, state.upper);
    if (!(value >= state.lower && value <= state.upper)) return i;
    point[static_cast<std::size_t>(*state.coordinate)] = value;
  }
  return std::nullopt;
}

void Chain::Impl::answer(double t, const std::vector<double>& shift, Eigen::VectorXd& x,
                         Eigen::MatrixXd* by_start, Eigen::MatrixXd* by_parameters) {
  point[0] = std::min(t, window);
  if (by_start == nullptr) {
    query.values(point, values);
  } else {
    query.values(point, values, gradient);
    by_start->setZero();
  }
  for (std::size_t i = 0; i < carried.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    x[row] = values[carried[i].output] + shift[i];
    if (by_start == nullptr) continue;
    for (std::size_t j = 0; j < carried.size(); ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      if (carried[j].coordinate)
        (*by_start)(row, column) = gradient(carried[i].output, *carried[j].coordinate);
    }
    if (!carried[i].coordinate) (*by_start)(row, row) = 1.0;
    for (std::size_t k = 0; k < parameter_places.size(); ++k) {
      (*by_parameters)(row, static_cast<Eigen::Index>(k)) = gradient(carried[i].output, parameter_places[k]);
    }
  }
}

void Chain::Impl::run(const Eigen::VectorXd& start, std::span<const double> times, bool with_derivatives,
                      ChainResult& result) {
  const Eigen::Index n = start.size();
  const auto m = static_cast<Eigen::Index>(parameters.size());
  Eigen::VectorXd x = start, end(n);
  std::vector<double> shift(states.size());
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
    const double begin = static_cast<double>(k) * window;
    if (const std::optional<std::size_t> out = load(x, shift)) {
      result.status = ChainStatus::left_box;
      result.left = states[*out];
      result.message = fmt::format("the chain left the box at t = {:.6g}: {} = {:.6g} {} is outside [{}, {}]",
                                   begin, states[*out], x[static_cast<Eigen::Index>(*out)], units[*out],
                                   carried[*out].lower, carried[*out].upper);
      return;
    }
    // The end of the last window serves the times at its border: rounding must not open another one.
    for (; next < times.size() && times[next] - begin <= window * (1.0 + 1e-12); ++next) {
      answer(times[next] - begin, shift, end, A, B);
      result.states.row(static_cast<Eigen::Index>(next)) = end.transpose();
      if (with_derivatives) result.derivatives[next] = composed();
      result.reached = times[next];
    }
    if (next == times.size()) break;
    answer(window, shift, end, A, B);
    if (with_derivatives) so_far = composed();
    x = end;
  }
  result.message = fmt::format("{} times up to {:.6g}", times.size(), result.reached);
}

Chain::Chain(const Codebook& book) : impl_(std::make_unique<Impl>(book)) {}
Chain::~Chain() = default;
Chain::Chain(Chain&&) noexcept = default;
Chain& Chain::operator=(Chain&&) noexcept = default;

const std::vector<std::string>& Chain::states() const {
  return impl_->states;
}
const std::vector<Coordinate>& Chain::parameters() const {
  return impl_->parameters;
}
double Chain::window() const {
  return impl_->window;
}

ChainResult Chain::run(std::span<const double> start, std::span<const double> parameters,
                       std::span<const double> times, bool with_derivatives) {
  impl_->check(start, parameters, times);
  const auto states = static_cast<Eigen::Index>(start.size());
  const auto count = static_cast<Eigen::Index>(times.size());
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  ChainResult result;
  result.states.setConstant(count, states, kUnknown);
  if (with_derivatives) {
    const auto columns = states + static_cast<Eigen::Index>(parameters.size());
    result.derivatives.assign(times.size(), Eigen::MatrixXd::Constant(states, columns, kUnknown));
  }
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    impl_->point[static_cast<std::size_t>(impl_->parameter_places[k])] = parameters[k];
  }
  impl_->run(Eigen::Map<const Eigen::VectorXd>(start.data(), states), times, with_derivatives, result);
  return result;
}

}  // namespace samara::codebooks
