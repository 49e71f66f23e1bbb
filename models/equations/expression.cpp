#include "samara/models/equations/expression.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::models {

namespace {

constexpr std::size_t kLongest = 20'000;
constexpr int kDeepest = 200;

/// What a function makes of the units of its arguments.
enum class UnitRule {
  none,  ///< takes and gives none
  same,  ///< takes equal ones and gives them
  root,
  lost,  ///< takes equal ones, gives none
};

struct Function {
  std::string_view name;
  Operation operation;
  UnitRule rule;
};

constexpr std::array kFunctions = {
    Function{"sqrt", Operation::square_root, UnitRule::root},
    Function{"exp", Operation::exponential, UnitRule::none},
    Function{"log", Operation::logarithm, UnitRule::none},
    Function{"sin", Operation::sine, UnitRule::none},
    Function{"cos", Operation::cosine, UnitRule::none},
    Function{"tan", Operation::tangent, UnitRule::none},
    Function{"asin", Operation::arcsine, UnitRule::none},
    Function{"acos", Operation::arccosine, UnitRule::none},
    Function{"atan", Operation::arctangent, UnitRule::none},
    Function{"atan2", Operation::arctangent2, UnitRule::lost},
    Function{"sinh", Operation::hyperbolic_sine, UnitRule::none},
    Function{"cosh", Operation::hyperbolic_cosine, UnitRule::none},
    Function{"tanh", Operation::hyperbolic_tangent, UnitRule::none},
    Function{"abs", Operation::absolute, UnitRule::same},
    Function{"min", Operation::smaller, UnitRule::same},
    Function{"max", Operation::larger, UnitRule::same},
    Function{"sign", Operation::sign, UnitRule::lost},
    Function{"step", Operation::step, UnitRule::lost},
};

const Function* find_function(std::string_view name) {
  const auto it = std::ranges::find(kFunctions, name, &Function::name);
  return it == kFunctions.end() ? nullptr : &*it;
}

bool begins_name(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}
bool is_of_name(char c) {
  return begins_name(c) || (c >= '0' && c <= '9');
}
bool begins_number(char c) {
  return (c >= '0' && c <= '9') || c == '.';
}

/// Recursive descent.
class ExpressionReader {
 public:
  ExpressionReader(std::string_view text, const std::map<std::string, Term>& names, ExpressionGraph& graph)
      : text_(text), names_(names), graph_(graph) {}

  Term read() {
    if (text_.size() > kLongest)
      throw ArgumentError(
          fmt::format("an expression of {} characters, at most {} were expected", text_.size(), kLongest));
    const Term term = sum();
    skip_blanks();
    if (at_ < text_.size())
      throw error(at_, fmt::format("\"{}\" is left over, expected an operator or the end", rest()));
    return term;
  }

 private:
  /// Counts how deep parts stand in each other.
  class Deeper {
   public:
    explicit Deeper(ExpressionReader& reader) : reader_(reader) {
      if (++reader_.depth_ > kDeepest)
        throw reader_.error(reader_.at_,
                            fmt::format("parts stand in each other more than {} deep", kDeepest));
    }
    ~Deeper() { --reader_.depth_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;

   private:
    ExpressionReader& reader_;
  };

  Term sum() {
    Term left = product();
    for (;;) {
      const std::size_t place = next_place();
      const bool plus = take("+");
      if (!plus && !take("-")) return left;
      const Term right = product();
      const UnitPowers unit = common_unit(place, plus ? "sum" : "difference", left, right);
      left = {make(place, plus ? Operation::add : Operation::subtract, left.node, right.node), unit};
    }
  }

  Term product() {
    Term left = signed_part();
    for (;;) {
      const std::size_t place = next_place();
      const bool times = take("*");
      if (!times && !take("/")) return left;
      const Term right = signed_part();
      if (!times && graph_.is_constant(right.node, 0.0)) throw error(place, "divides by zero");
      const int node = make(place, times ? Operation::multiply : Operation::divide, left.node, right.node);
      try {
        left = {node, left.unit.times(right.unit, times ? 1 : -1)};
      } catch (const ArgumentError& beyond_use) {
        throw error(place, beyond_use.what());
      }
    }
  }

  Term signed_part() {
    const Deeper deeper(*this);
    if (take("-")) {
      const Term part = signed_part();
      return {graph_.make(Operation::negate, part.node), part.unit};
    }
    if (take("+")) return signed_part();
    return power();
  }

  Term power() {
    const Term base = part();
    const std::size_t place = next_place();
    if (!take("^") && !take("**")) return base;
    const Term exponent = signed_part();
    if (!exponent.unit.is_dimensionless())
      throw error(place,
                  fmt::format("the exponent is in {}, expected a plain number", to_string(exponent.unit)));
    const int node = make(place, Operation::power, base.node, exponent.node);
    if (base.unit.is_dimensionless()) return {node, base.unit};
    const ExpressionNode& number = graph_[exponent.node];
    const auto fraction = number.operation == Operation::constant ? fraction_of(number.value) : std::nullopt;
    const auto unit = fraction ? base.unit.raised(*fraction) : std::nullopt;
    if (!unit)
      throw error(place, fmt::format("a power of something in {} must be a whole number or a simple fraction",
                                     to_string(base.unit)));
    return {node, *unit};
  }

  Term part() {
    skip_blanks();
    if (at_ == text_.size())
      throw error(at_, "the expression ends, expected a number, a name or a parenthesis");
    if (take("(")) {
      const Term inside = sum();
      expect(")");
      return inside;
    }
    if (begins_number(text_[at_])) return number();
    if (begins_name(text_[at_])) return named();
    throw error(at_,
                fmt::format("\"{}\" stands where a number, a name or a parenthesis was expected", rest()));
  }

  Term number() {
    const std::size_t place = at_;
    double value = 0.0;
    const char* const begin = text_.data() + at_;
    const auto [end, problem] = std::from_chars(begin, text_.data() + text_.size(), value);
    const std::size_t length = static_cast<std::size_t>(end - begin);
    if (problem == std::errc::result_out_of_range || !std::isfinite(value))
      throw error(place, fmt::format("the number {} is too large or too small", text_.substr(place, length)));
    if (problem != std::errc()) throw error(place, fmt::format("\"{}\" is no number", rest()));
    at_ += length;
    if (at_ < text_.size() && (is_of_name(text_[at_]) || text_[at_] == '.'))
      throw error(at_, fmt::format("\"{}\" follows a number at once, expected an operator", rest()));
    skip_blanks();
    if (at_ == text_.size() || text_[at_] != '[') return {graph_.constant(value), {}};
    return with_unit(value);
  }

  Term with_unit(double value) {
    const std::size_t place = at_;
    const std::size_t end = text_.find(']', at_);
    if (end == std::string_view::npos) throw error(place, "a unit begins with \"[\", and no \"]\" follows");
    Unit unit;
    try {
      unit = parse_unit(text_.substr(at_ + 1, end - at_ - 1));
    } catch (const ArgumentError& problem) {
      throw error(place, problem.what());
    }
    at_ = end + 1;
    const double si = unit.to_si(value);
    if (!std::isfinite(si)) throw error(place, "the number is too large in SI units");
    return {graph_.constant(si), UnitPowers(unit.dimension)};
  }

  Term named() {
    const std::size_t place = at_;
    while (at_ < text_.size() && is_of_name(text_[at_])) ++at_;
    const std::string name(text_.substr(place, at_ - place));
    const bool is_call = take("(");
    if (is_call) return call(name, place);
    if (name == "pi") return {graph_.constant(std::numbers::pi), {}};
    const auto it = names_.find(name);
    if (it != names_.end() && it->second.node < 0)
      throw error(place, fmt::format("\"{}\" is not known here yet, expected one given before", name));
    if (it != names_.end()) return it->second;
    if (find_function(name) != nullptr)
      throw error(place, fmt::format("the function {} stands without its argument in parentheses", name));
    std::vector<std::string> known = {"pi"};
    for (const auto& [other, term] : names_) known.push_back(other);
    throw error(place, fmt::format("there is no \"{}\"{}", name, suggestion(name, known)));
  }

  Term call(const std::string& name, std::size_t place) {
    const Function* function = find_function(name);
    if (function == nullptr) {
      if (names_.contains(name))
        throw error(place, fmt::format("\"{}\" is no function; a product is written with *", name));
      std::vector<std::string> known;
      for (const Function& other : kFunctions) known.emplace_back(other.name);
      const std::string hint = name == "ln" ? "; \"log\" is the natural logarithm" : suggestion(name, known);
      throw error(place, fmt::format("there is no function \"{}\"{}", name, hint));
    }
    const Term first = sum();
    Term second;
    const bool binary = is_binary(function->operation);
    if (binary) {
      expect(",");
      second = sum();
    }
    expect(")");
    return {make(place, function->operation, first.node, binary ? second.node : -1),
            unit_of_call(*function, place, first, binary ? &second : nullptr)};
  }

  UnitPowers unit_of_call(const Function& function, std::size_t place, const Term& first,
                          const Term* second) const {
    if (function.rule == UnitRule::none) {
      if (first.unit.is_dimensionless()) return {};
      throw error(place, fmt::format("{} is taken of something in {}, expected a plain number or an angle",
                                     function.name, to_string(first.unit)));
    }
    if (function.rule == UnitRule::root) {
      if (const auto unit = first.unit.raised({1, 2})) return *unit;
      throw error(place, fmt::format("the root of something in {} has no unit", to_string(first.unit)));
    }
    const UnitPowers unit =
        second != nullptr ? common_unit(place, std::string(function.name), first, *second) : first.unit;
    return function.rule == UnitRule::same ? unit : UnitPowers();
  }

  /// @param what they are put together in, for the message
  UnitPowers common_unit(std::size_t place, const std::string& what, const Term& left,
                         const Term& right) const {
    if (left.unit == right.unit || graph_.is_constant(right.node, 0.0)) return left.unit;
    if (graph_.is_constant(left.node, 0.0)) return right.unit;
    throw error(place, fmt::format("{} of something in {} and something in {}, expected equal units", what,
                                   to_string(left.unit), to_string(right.unit)));
  }

  /// @throws ArgumentError where numbers alone make one that is not finite
  int make(std::size_t place, Operation operation, int a, int b = -1) {
    const int node = graph_.make(operation, a, b);
    const auto value = [&](int of) { return of < 0 ? 0.0 : graph_[of].value; };
    const auto is_number = [&](int of) { return of < 0 || graph_[of].operation == Operation::constant; };
    if (is_number(a) && is_number(b) && !is_number(node))
      throw error(place, fmt::format("the result is {}, expected a finite number",
                                     apply(operation, value(a), value(b))));
    return node;
  }

  void skip_blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }

  std::size_t next_place() {
    skip_blanks();
    return at_;
  }

  bool take(std::string_view sign) {
    skip_blanks();
    if (!text_.substr(at_).starts_with(sign)) return false;
    at_ += sign.size();
    return true;
  }

  void expect(std::string_view sign) {
    if (take(sign)) return;
    throw error(at_, at_ == text_.size()
                         ? fmt::format("the expression ends, expected \"{}\"", sign)
                         : fmt::format("\"{}\" stands where \"{}\" was expected", rest(), sign));
  }

  /// What follows, a little of it.
  std::string rest() const {
    constexpr std::size_t kShown = 12;
    const std::string_view left = text_.substr(at_);
    return printable(left.substr(0, kShown)) + (left.size() > kShown ? ".." : "");
  }

  ArgumentError error(std::size_t place, const std::string& sentence) const {
    return ArgumentError(fmt::format("at column {}: {}", place + 1, sentence));
  }

  std::string_view text_;
  const std::map<std::string, Term>& names_;
  ExpressionGraph& graph_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Term read_expression(std::string_view text, const std::map<std::string, Term>& names,
                     ExpressionGraph& graph) {
  return ExpressionReader(text, names, graph).read();
}

bool is_expression_name(std::string_view text) {
  return !text.empty() && begins_name(text.front()) && std::ranges::all_of(text, is_of_name) &&
         text != "pi" && find_function(text) == nullptr;
}

}  // namespace samara::models
