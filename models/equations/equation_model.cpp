#include "samara/models/equations/equation_model.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "samara/base/units.h"
#include "samara/models/equations/expression.h"
#include "samara/models/equations/tape.h"

namespace samara::models {

namespace {

constexpr std::size_t kMostStates = 200;
constexpr std::size_t kMostParameters = 200;
/// Of a graph with all derivatives: more would take gigabytes.
constexpr int kMostNodes = 1'000'000;

/// Symbols are numbered: states, then parameters, then t.
struct CompiledEquations {
  ModelInfo info;
  ExpressionGraph graph;
  std::vector<int> rates, outputs;
};

void require_unit(EquationPart part, const std::string& name, const std::string& unit) {
  try {
    if (is_coherent_si(unit)) return;
  } catch (const ArgumentError& error) {
    throw EquationError(part, name, fmt::format("the unit of \"{}\" cannot be read: {}", name, error.what()));
  }
  throw EquationError(part, name,
                      fmt::format("the unit of \"{}\" is \"{}\", expected one of the SI without a factor, "
                                  "such as m/s: numbers go into the equations as they are",
                                  name, unit));
}

void require_finite(EquationPart part, const std::string& name, double value, const char* what) {
  if (!std::isfinite(value))
    throw EquationError(part, name,
                        fmt::format("{} of \"{}\" is {}, expected a finite number", what, name, value));
}

void require_short(const ExpressionGraph& graph) {
  if (graph.size() > kMostNodes)
    throw EquationError(EquationPart::rates, "",
                        "the derivatives of the equations are too long to be stored");
}

class EquationCompiler {
 public:
  explicit EquationCompiler(const Equations& equations) : equations_(equations) {}

  CompiledEquations compile() {
    using enum EquationPart;
    check_counts();
    int number = 0;
    for (const StateInfo& state : equations_.states) {
      require_finite(states, state.name, state.default_initial, "the initial value");
      if (state.scale && !(*state.scale > 0.0 && std::isfinite(*state.scale)))
        throw EquationError(
            states, state.name,
            fmt::format("the scale of \"{}\" is {}, expected a positive number", state.name, *state.scale));
      declare(states, state.name, state.unit, number++);
    }
    for (const ParameterInfo& parameter : equations_.parameters) {
      if (parameter.default_value)
        require_finite(parameters, parameter.name, *parameter.default_value, "the default");
      if (parameter.default_value && !in_meaning(parameter, *parameter.default_value))
        throw EquationError(parameters, parameter.name,
                            fmt::format("the default of \"{}\" is {}, expected {}", parameter.name,
                                        *parameter.default_value, meaning_text(parameter)));
      declare(parameters, parameter.name, parameter.unit, number++);
    }
    compiled_.info.states = equations_.states;
    compiled_.info.parameters = equations_.parameters;
    const UnitPowers time(parse_unit(time_unit(compiled_.info)).dimension);
    names_["t"] = {compiled_.graph.symbol(number), time};
    for (const auto& [name, text] : equations_.abbreviations) {
      require_new(abbreviations, name);
      names_[name] = {-1, {}};
    }
    for (const auto& [name, text] : equations_.abbreviations) names_[name] = read(abbreviations, name, text);
    for (std::size_t i = 0; i < equations_.states.size(); ++i) add_rate(equations_.states[i], i, time);
    for (const auto& [output, text] : equations_.outputs) add_output(output, text);
    describe();
    return std::move(compiled_);
  }

 private:
  void check_counts() const {
    const std::size_t states = equations_.states.size(), rates = equations_.rates.size();
    if (states == 0)
      throw EquationError(EquationPart::states, "", "the equations have no state, expected at least one");
    if (states > kMostStates || equations_.parameters.size() > kMostParameters)
      throw EquationError(EquationPart::states, "",
                          fmt::format("{} states and {} parameters, expected at most {} and {}", states,
                                      equations_.parameters.size(), kMostStates, kMostParameters));
    if (rates != states)
      throw EquationError(EquationPart::rates, "",
                          fmt::format("{} rates for {} states, expected one of each", rates, states));
  }

  void require_new(EquationPart part, const std::string& name) const {
    if (name == "t") throw EquationError(part, name, "\"t\" is the time, expected another name");
    if (names_.contains(name))
      throw EquationError(part, name, fmt::format("the name \"{}\" is given twice", name));
    if (!is_expression_name(name))
      throw EquationError(part, name,
                          fmt::format("\"{}\" is no name: letters, digits and underscores were expected, no "
                                      "digit first, and neither a function nor pi",
                                      name));
  }

  void declare(EquationPart part, const std::string& name, const std::string& unit, int number) {
    require_new(part, name);
    require_unit(part, name, unit);
    names_[name] = {compiled_.graph.symbol(number), UnitPowers(parse_unit(unit).dimension)};
  }

  Term read(EquationPart part, const std::string& name, const std::string& text) {
    try {
      return read_expression(text, names_, compiled_.graph);
    } catch (const ArgumentError& error) {
      throw EquationError(part, name, error.what());
    }
  }

  UnitPowers unit_of_rate(const StateInfo& state, const UnitPowers& time) const {
    try {
      return names_.at(state.name).unit.times(time, -1);
    } catch (const ArgumentError& error) {
      throw EquationError(EquationPart::rates, state.name, error.what());
    }
  }

  void add_rate(const StateInfo& state, std::size_t index, const UnitPowers& time) {
    const Term rate = read(EquationPart::rates, state.name, equations_.rates[index]);
    const UnitPowers expected = unit_of_rate(state, time);
    if (!(rate.unit == expected) && !compiled_.graph.is_constant(rate.node, 0.0))
      throw EquationError(EquationPart::rates, state.name,
                          fmt::format("the rate of \"{}\" is in {}, expected {}: its unit per {}", state.name,
                                      to_string(rate.unit), to_string(expected), to_string(time)));
    compiled_.rates.push_back(rate.node);
  }

  void add_output(const OutputInfo& output, const std::string& text) {
    constexpr EquationPart kPart = EquationPart::outputs;
    require_new(kPart, output.name);
    require_unit(kPart, output.name, output.unit);
    const Term value = read(kPart, output.name, text);
    names_[output.name] = value;
    const UnitPowers expected(parse_unit(output.unit).dimension);
    if (!(value.unit == expected) && !compiled_.graph.is_constant(value.node, 0.0))
      throw EquationError(kPart, output.name,
                          fmt::format("\"{}\" is in {}, expected {}", output.name, to_string(value.unit),
                                      to_string(expected)));
    compiled_.info.outputs.push_back(output);
    compiled_.outputs.push_back(value.node);
  }

  void describe() {
    ModelInfo& info = compiled_.info;
    info.name = equations_.name;
    info.title = equations_.title.empty() ? "equations as text" : equations_.title;
    for (StateInfo& state : info.states) {
      if (state.description.empty()) state.description = "not described";
    }
    for (ParameterInfo& parameter : info.parameters) {
      if (parameter.description.empty()) parameter.description = "not described";
    }
    for (OutputInfo& output : info.outputs) {
      if (output.description.empty()) output.description = "not described";
    }
    info.frames = equations_.frames.empty() ? "as the names of the states say" : equations_.frames;
    info.source = equations_.source.empty() ? "equations as text" : equations_.source;
    info.validity = equations_.validity.empty() ? "not stated" : equations_.validity;
    for (std::size_t i = 0; i < info.states.size(); ++i)
      info.equations +=
          fmt::format("{}{}' = {}", i == 0 ? "" : ",  ", info.states[i].name, equations_.rates[i]);
    for (const auto& [name, text] : equations_.abbreviations)
      info.equations += fmt::format(",  {} = {}", name, text);
    for (const auto& [output, text] : equations_.outputs)
      info.equations += fmt::format(",  {} = {}", output.name, text);
    find_translations();
    find_affine();
  }

  void find_translations() {
    for (std::size_t i = 0; i < equations_.states.size(); ++i) {
      const bool is_free = std::ranges::all_of(compiled_.rates, [&](int rate) {
        return compiled_.graph.standing(rate, static_cast<int>(i)) == Standing::absent;
      });
      if (is_free) compiled_.info.symmetries.push_back("translation of " + equations_.states[i].name);
    }
  }

  bool has_no_slope(int node, int symbol) {
    const int slope = compiled_.graph.derivative(node, symbol);
    require_short(compiled_.graph);
    return compiled_.graph.is_constant(slope, 0.0);
  }

  /// Parameters outside of kinks whose second derivatives with all those before vanish: f is affine in them together.
  void find_affine() {
    const auto states = static_cast<int>(equations_.states.size());
    std::vector<int> affine;
    for (int j = 0; j < static_cast<int>(equations_.parameters.size()); ++j) {
      affine.push_back(states + j);
      const bool holds = std::ranges::all_of(compiled_.rates, [&](int rate) {
        // At a kink derivatives are those of one side, and say nothing of the other.
        if (compiled_.graph.standing(rate, states + j) == Standing::kinked) return false;
        const int slope = compiled_.graph.derivative(rate, states + j);
        return std::ranges::all_of(affine, [&](int other) { return has_no_slope(slope, other); });
      });
      if (!holds) affine.pop_back();
    }
    for (const int symbol : affine)
      compiled_.info.affine_in.push_back(
          equations_.parameters[static_cast<std::size_t>(symbol - states)].name);
  }

  const Equations& equations_;
  CompiledEquations compiled_;
  std::map<std::string, Term> names_;
};

/// An entry of a Jacobian that is not always zero.
struct JacobianEntry {
  int row = 0, column = 0;
};

class EquationModel final : public Model {
 public:
  EquationModel(const Equations& equations, CompiledEquations compiled)
      : equations_(equations),
        info_(std::move(compiled.info)),
        rates_(compiled.graph, compiled.rates, symbols()) {
    std::vector<int> roots = compiled.rates;
    const int states = static_cast<int>(info_.states.size());
    add_columns(compiled, 0, states, roots);
    entries_by_state_ = entries_.size();
    state_jacobian_ = Tape(compiled.graph, roots, symbols());
    add_columns(compiled, states, states + parameters(), roots);
    jacobian_ = Tape(compiled.graph, roots, symbols());
    // Outputs, then their derivatives by all symbols, output by output.
    roots = compiled.outputs;
    for (const int output : compiled.outputs) {
      for (int symbol = 0; symbol < symbols(); ++symbol)
        roots.push_back(compiled.graph.derivative(output, symbol));
      require_short(compiled.graph);
    }
    outputs_ = Tape(compiled.graph, compiled.outputs, symbols());
    output_slopes_ = Tape(compiled.graph, roots, symbols());
  }

  const ModelInfo& info() const override { return info_; }
  const Equations& equations() const { return equations_; }

  void rhs(double t, std::span<const double> x, const ParameterValues& p,
           std::span<double> dxdt) const override {
    Scratch& scratch = scratch_for(rates_, 1);
    gather(t, x, p, scratch.work);
    rates_.evaluate(scratch.work, dxdt.data());
  }

  void rhs_with_derivatives(double t, std::span<const double> x, const ParameterValues& p,
                            std::span<double> dxdt, Eigen::Ref<Eigen::MatrixXd> df_dx,
                            Eigen::Ref<Eigen::MatrixXd> df_dp) const override {
    Scratch& scratch = scratch_for(jacobian_, 1);
    gather(t, x, p, scratch.work);
    jacobian_.evaluate(scratch.work, scratch.results.data());
    const std::size_t states = info_.states.size();
    std::copy_n(scratch.results.begin(), states, dxdt.begin());
    df_dx.setZero();
    df_dp.setZero();
    for (std::size_t k = 0; k < entries_.size(); ++k) {
      const auto [row, column] = entries_[k];
      const int parameter = column - static_cast<int>(states);
      if (parameter < 0) {
        df_dx(row, column) = scratch.results[states + k];
      } else if (p.given[static_cast<std::size_t>(parameter)]) {
        df_dp(row, parameter) = scratch.results[states + k];
      }
    }
  }

  void outputs(double t, std::span<const double> x, const ParameterValues& p,
               std::span<double> y) const override {
    Scratch& scratch = scratch_for(outputs_, 1);
    gather(t, x, p, scratch.work);
    outputs_.evaluate(scratch.work, y.data());
  }

  void outputs_with_derivatives(double t, std::span<const double> x, const ParameterValues& p,
                                std::span<double> y, Eigen::Ref<Eigen::VectorXd> dy_dt,
                                Eigen::Ref<Eigen::MatrixXd> dy_dx,
                                Eigen::Ref<Eigen::MatrixXd> dy_dp) const override {
    Scratch& scratch = scratch_for(output_slopes_, 1);
    gather(t, x, p, scratch.work);
    output_slopes_.evaluate(scratch.work, scratch.results.data());
    std::copy_n(scratch.results.begin(), y.size(), y.begin());
    const double* slope = scratch.results.data() + y.size();
    for (Eigen::Index o = 0; o < dy_dt.size(); ++o) {
      for (Eigen::Index i = 0; i < dy_dx.cols(); ++i) dy_dx(o, i) = *slope++;
      for (Eigen::Index j = 0; j < dy_dp.cols(); ++j, ++slope)
        dy_dp(o, j) = p.given[static_cast<std::size_t>(j)] ? *slope : 0.0;
      dy_dt[o] = *slope++;
    }
  }

  void rhs_at_points(const Eigen::Ref<const Eigen::VectorXd>& t, const Eigen::Ref<const Eigen::MatrixXd>& x,
                     const Eigen::Ref<const Eigen::MatrixXd>& p,
                     Eigen::Ref<Eigen::MatrixXd> dxdt) const override {
    in_lanes(rates_, t, x, p, [&](std::span<const double> work, Eigen::Index first, Eigen::Index count) {
      double* const at = dxdt.col(first).data();
      Eigen::Index row = 0;
      for (; row + 1 < dxdt.rows(); row += 2) {
        const auto k = static_cast<std::size_t>(row);
        lanes_to_points(rates_.root_lanes(work, k), rates_.root_lanes(work, k + 1), dxdt.outerStride(), count,
                        at + row);
      }
      if (row < dxdt.rows())
        lanes_to_points(rates_.root_lanes(work, static_cast<std::size_t>(row)), dxdt.outerStride(), count,
                        at + row);
    });
  }

  void jacobians_at_points(const Eigen::Ref<const Eigen::VectorXd>& t,
                           const Eigen::Ref<const Eigen::MatrixXd>& x,
                           const Eigen::Ref<const Eigen::MatrixXd>& p,
                           Eigen::Ref<Eigen::MatrixXd> jacobians) const override {
    const std::size_t states = info_.states.size();
    jacobians.setZero();
    in_lanes(state_jacobian_, t, x, p,
             [&](std::span<const double> work, Eigen::Index first, Eigen::Index count) {
               double* const at = jacobians.col(first).data();
               for (std::size_t k = 0; k < entries_by_state_; ++k) {
                 const auto [row, column] = entries_[k];
                 lanes_to_points(state_jacobian_.root_lanes(work, states + k), jacobians.outerStride(), count,
                                 at + row + static_cast<Eigen::Index>(states) * column);
               }
             });
  }

  std::vector<double> completed(const ParameterValues& p) const override {
    std::vector<double> all(info_.parameters.size());
    complete_into(p, all);
    return all;
  }

  void complete_into(const ParameterValues& p, std::span<double> all) const override {
    for (std::size_t j = 0; j < all.size(); ++j)
      all[j] = p.given[j] ? p.value[j] : info_.parameters[j].default_value.value_or(0.0);
  }

  Scales scales(const ParameterValues&) const override { return {}; }

 private:
  /// Of one thread, shared by all models: it grows to the largest that was needed.
  struct Scratch {
    std::vector<double> work, results;
  };

  /// Entries of the Jacobian by symbols from `first` to before `end`.
  void add_columns(CompiledEquations& compiled, int first, int end, std::vector<int>& roots) {
    for (int column = first; column < end; ++column) {
      for (int row = 0; row < static_cast<int>(compiled.rates.size()); ++row) {
        const int node = compiled.graph.derivative(compiled.rates[static_cast<std::size_t>(row)], column);
        require_short(compiled.graph);
        if (compiled.graph.is_constant(node, 0.0)) continue;
        entries_.push_back({row, column});
        roots.push_back(node);
      }
    }
  }

  int parameters() const { return static_cast<int>(info_.parameters.size()); }
  /// States, parameters, and t.
  int symbols() const { return static_cast<int>(info_.states.size() + info_.parameters.size()) + 1; }

  Scratch& scratch_for(const Tape& tape, int lanes) const {
    thread_local Scratch scratch;
    const auto grow = [](std::vector<double>& space, std::size_t size) {
      if (space.size() < size) space.resize(size);
    };
    const auto width = static_cast<std::size_t>(lanes);
    grow(scratch.work, tape.work_size(lanes));
    grow(scratch.results, static_cast<std::size_t>(tape.root_count()) * width);
    return scratch;
  }

  void gather(double t, std::span<const double> x, const ParameterValues& p,
              std::vector<double>& symbols) const {
    std::ranges::copy(x, symbols.begin());
    complete_into(p, {symbols.data() + x.size(), info_.parameters.size()});
    symbols[x.size() + info_.parameters.size()] = t;
  }

  /// Points in groups of kLanes; in the last one some lanes hold what nobody asks for.
  template <class TakeAll>
  void in_lanes(const Tape& tape, const Eigen::Ref<const Eigen::VectorXd>& t,
                const Eigen::Ref<const Eigen::MatrixXd>& x, const Eigen::Ref<const Eigen::MatrixXd>& p,
                TakeAll&& take_all) const {
    constexpr Eigen::Index kLanes = Tape::kLanes;
    std::vector<double>& work = scratch_for(tape, Tape::kLanes).work;
    double* const lanes = work.data();
    tape.begin_lanes(work);
    for (Eigen::Index first = 0; first < x.cols(); first += kLanes) {
      const Eigen::Index count = std::min(kLanes, x.cols() - first);
      points_to_lanes(x.col(first).data(), x.outerStride(), x.rows(), count, lanes);
      points_to_lanes(p.col(first).data(), p.outerStride(), p.rows(), count, lanes + x.rows() * kLanes);
      std::copy_n(t.data() + first, count, lanes + (x.rows() + p.rows()) * kLanes);
      tape.evaluate_lanes(work);
      take_all(work, first, count);
    }
  }

  Equations equations_;
  ModelInfo info_;
  Tape rates_;
  Tape state_jacobian_;  ///< rates, then the entries by states
  Tape jacobian_;        ///< rates, then all entries
  Tape outputs_, output_slopes_;
  std::vector<JacobianEntry> entries_;
  std::size_t entries_by_state_ = 0;
};

bool has_time(const std::string& text) {
  const auto is_of_name = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' ||
           static_cast<unsigned char>(c) >= 0x80;
  };
  for (auto begin = text.begin(); begin != text.end();) {
    const auto end = std::find_if_not(begin, text.end(), is_of_name);
    if (end - begin == 1 && *begin == 't') return true;
    begin = end == begin ? begin + 1 : end;
  }
  return false;
}

}  // namespace

std::shared_ptr<const Model> equation_model(const Equations& equations) {
  return std::make_shared<EquationModel>(equations, EquationCompiler(equations).compile());
}

bool mention_time(const Equations& equations) {
  return std::ranges::any_of(equations.rates, has_time) ||
         std::ranges::any_of(equations.abbreviations, [](const auto& one) { return has_time(one.second); });
}

bool outputs_mention_time(const Equations& equations) {
  const auto mentions = [](const auto& one) { return has_time(one.second); };
  return std::ranges::any_of(equations.abbreviations, mentions) ||
         std::ranges::any_of(equations.outputs, mentions);
}

const Equations* equations_of(const Model& model) {
  const auto* of_text = dynamic_cast<const EquationModel*>(&model);
  return of_text == nullptr ? nullptr : &of_text->equations();
}

}  // namespace samara::models
