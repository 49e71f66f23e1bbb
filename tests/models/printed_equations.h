#pragma once

#include <cctype>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "printed_quantity.h"

/// Reads the equations that models print, and computes with them.
///
/// A text is a list of clauses, separated by a comma or a semicolon and two blanks. `name = ..`, `(a, b) =
/// ..` and `f(q) = ..` define; a clause with x' or dx/dt on its left is an equation of motion. Products are
/// written side by side; in texts with semicolons, whose quantities are vectors, " x " is the cross product.
/// M^T is the transposed, (a, b, c) a column, v_x the component of a vector v.
namespace printed {

class Equations;
/// Something that the text says in words only.
using Supplied = std::function<Quantity(Equations&)>;

class Equations {
 public:
  /// @param prose clauses in words, exactly as they stand; what they mean must be supplied
  Equations(std::string text, const std::set<std::string>& prose = {})
      : spatial_(text.find(";  ") != text.npos) {
    for (const std::string& clause : clauses(join_words(std::move(text)))) {
      if (prose.contains(clause)) {
        ++prose_met_;
      } else {
        take(clause);
      }
    }
    if (prose_met_ != prose.size()) throw std::runtime_error("a clause in words is not in the text");
  }

  void set(const std::string& name, Quantity quantity) {
    known_[name] = std::move(quantity);
    found_.clear();
  }
  void supply(const std::string& name, Supplied supplied) { supplied_[name] = std::move(supplied); }

  /// Left and right sides of the equations of motion.
  std::vector<std::pair<Quantity, Quantity>> motion() {
    std::vector<std::pair<Quantity, Quantity>> sides;
    for (const auto& [left, right] : motion_) sides.emplace_back(evaluate(left), evaluate(right));
    return sides;
  }

  Quantity evaluate(const std::string& text) { return evaluate(text, {}); }

  Quantity lookup(const std::string& name, const std::map<std::string, Quantity>& local = {}) {
    for (const auto& [argument, quantity] : local) {
      if (name == argument) return quantity;
      for (const char* joint : {"", "_"}) {
        for (int k = 0; k < 3; ++k) {
          if (name == argument + joint + "xyz"[k]) return {quantity.value(k), quantity.rate(k)};
        }
      }
    }
    if (const auto q = found_.find(name); q != found_.end()) return q->second;
    if (!looking_for_.insert(name).second) throw std::runtime_error(name + " is defined by itself");
    Quantity result = resolved(name);
    looking_for_.erase(name);
    return found_[name] = result;
  }

 private:
  struct Function {
    std::vector<std::string> arguments;
    std::string body;
  };

  static std::vector<std::string> clauses(const std::string& text) {
    std::vector<std::string> list(1);
    for (std::size_t i = 0; i < text.size(); ++i) {
      if ((text[i] == ',' || text[i] == ';') && text.compare(i + 1, 2, "  ") == 0) {
        list.emplace_back();
        i += 2;
      } else {
        list.back() += text[i];
      }
    }
    return list;
  }

  /// Names of two words become one word.
  static std::string join_words(std::string text) {
    for (const std::string name : {"translational lift", "rotational lift"}) {
      for (std::size_t at = text.find(name); at != text.npos; at = text.find(name))
        text[text.find(' ', at)] = '_';
    }
    return text;
  }

  void take(const std::string& clause) {
    const std::size_t equals = clause.find(" = ");
    if (equals == clause.npos) throw std::runtime_error("no equation: " + clause);
    const std::string left = clause.substr(0, equals), right = clause.substr(equals + 3);
    if (left.find('\'') != left.npos || left.find("/dt") != left.npos) {
      motion_.emplace_back(left, right);
      return;
    }
    const std::size_t bracket = left.find('(');
    std::vector<std::string> names;
    std::string name;
    for (const char c : left.substr(bracket == left.npos ? 0 : bracket)) {
      if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_') {
        name += c;
      } else if (!name.empty()) {
        names.push_back(std::exchange(name, {}));
      }
    }
    if (!name.empty()) names.push_back(name);
    if (bracket != left.npos && bracket > 0) {
      functions_[left.substr(0, bracket)] = {names, right};
    } else {
      for (std::size_t k = 0; k < names.size(); ++k) definitions_[names[k]] = {right, k, names.size()};
    }
  }

  struct Definition {
    std::string right;
    std::size_t part = 0, parts = 1;
  };

  Quantity resolved(const std::string& name) {
    if (const auto d = definitions_.find(name); d != definitions_.end()) {
      const Quantity all = evaluate(d->second.right);
      if (d->second.parts == 1) return all;
      const Eigen::Index rows = all.value.rows() / static_cast<Eigen::Index>(d->second.parts);
      const Eigen::Index first = rows * static_cast<Eigen::Index>(d->second.part);
      return {all.value.middleRows(first, rows), all.rate.middleRows(first, rows)};
    }
    if (const auto s = supplied_.find(name); s != supplied_.end()) return s->second(*this);
    if (const auto q = known_.find(name); q != known_.end()) return q->second;
    if (name == "pi") return std::numbers::pi;
    for (const char* joint : {"", "_"}) {
      if (known_.contains(name + joint + "x") && known_.contains(name + joint + "z")) {
        std::vector<Quantity> parts = {lookup(name + joint + "x"), lookup(name + joint + "y"),
                                       lookup(name + joint + "z")};
        if (known_.contains(name + joint + "w")) parts.insert(parts.begin(), lookup(name + joint + "w"));
        return column(parts);
      }
    }
    if (name.size() > 1 && name.back() >= 'x' && name.back() <= 'z') {
      std::string vector = name.substr(0, name.size() - 1);
      if (vector.back() == '_') vector.pop_back();
      const Quantity whole = lookup(vector);
      const int k = name.back() - 'x';
      if (whole.value.size() == 3) return {whole.value(k), whole.rate(k)};
    }
    throw std::runtime_error("the equations do not say what " + name + " is");
  }

  /// Computes while it reads.
  class Reader {
   public:
    Reader(Equations& equations, std::string_view text, const std::map<std::string, Quantity>& local)
        : equations_(equations), text_(text), local_(local) {}

    Quantity whole() {
      const Quantity result = expression();
      if (peek() != 0) throw std::runtime_error("cannot read on at: " + std::string(text_.substr(at_)));
      return result;
    }

   private:
    char peek() {
      while (at_ < text_.size() && text_[at_] == ' ') ++at_;
      return at_ < text_.size() ? text_[at_] : '\0';
    }
    bool take(char c) {
      if (peek() != c) return false;
      ++at_;
      return true;
    }
    bool take(std::string_view word) {
      peek();
      if (text_.substr(at_, word.size()) != word) return false;
      at_ += word.size();
      return true;
    }
    void expect(char c) {
      if (!take(c))
        throw std::runtime_error(std::string("expected ") + c + " at: " + std::string(text_.substr(at_)));
    }

    Quantity expression() {
      const bool negative = take('-');
      Quantity total = crossed();
      if (negative) total = times(-1.0, total);
      while (true) {
        if (take('+')) {
          total = sum(total, crossed(), 1.0);
        } else if (take('-')) {
          total = sum(total, crossed(), -1.0);
        } else {
          return total;
        }
      }
    }

    Quantity crossed() {
      Quantity result = product();
      while (at_cross()) {
        take('x');
        result = cross(result, product());
      }
      return result;
    }

    bool at_cross() {
      return equations_.spatial_ && peek() == 'x' && at_ + 1 < text_.size() && text_[at_ + 1] == ' ';
    }

    Quantity product() {
      Quantity result = factor();
      while (true) {
        const char next = peek();
        if (take('/')) {
          result = times(result, power(factor(), -1.0));
        } else if (next == '(' || next == '[' || (next == '|' && !inside_bars_) ||
                   (std::isalnum(static_cast<unsigned char>(next)) != 0 && !at_cross())) {
          result = times(result, factor());
        } else {
          return result;
        }
      }
    }

    Quantity factor() {
      Quantity result = primary();
      while (true) {
        if (take('\'')) {
          result = {result.rate, Eigen::MatrixXd::Zero(result.rate.rows(), result.rate.cols())};
        } else if (take("^T")) {
          result = {result.value.transpose(), result.rate.transpose()};
        } else if (take('^')) {
          result = power(result, primary().number());
        } else {
          return result;
        }
      }
    }

    Quantity primary() {
      if (take('|')) {
        const bool outside = std::exchange(inside_bars_, true);
        const Quantity inside = expression();
        expect('|');
        inside_bars_ = outside;
        return length(inside);
      }
      for (const auto& [open, close] : {std::pair{'(', ')'}, std::pair{'[', ']'}}) {
        if (take(open)) return list(close);
      }
      if (std::isdigit(static_cast<unsigned char>(peek())) != 0) return number();
      return named();
    }

    /// What stands in brackets: a number, or a column.
    Quantity list(char close) {
      const bool outside = std::exchange(inside_bars_, false);
      std::vector<Quantity> parts = {expression()};
      while (take(',')) parts.push_back(expression());
      expect(close);
      inside_bars_ = outside;
      return parts.size() == 1 ? parts.front() : column(parts);
    }

    Quantity number() {
      std::size_t used = 0;
      const double value = std::stod(std::string(text_.substr(at_)), &used);
      at_ += used;
      return value;
    }

    Quantity named() {
      peek();
      std::string name;
      while (at_ < text_.size() &&
             (std::isalnum(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '_'))
        name += text_[at_++];
      if (name.empty()) throw std::runtime_error("cannot read: " + std::string(text_.substr(at_)));
      if (name == "d" && take('(')) {
        const Quantity inside = list(')');
        if (!take("/dt")) throw std::runtime_error("expected /dt");
        return {inside.rate, Eigen::MatrixXd::Zero(inside.rate.rows(), inside.rate.cols())};
      }
      if (name[0] == 'd' && take("/dt")) {
        const Quantity of = equations_.lookup(name.substr(1), local_);
        return {of.rate, Eigen::MatrixXd::Zero(of.rate.rows(), of.rate.cols())};
      }
      if (name[0] == 'D' && take("/Dt")) return equations_.lookup(name + "/Dt", local_);
      const auto f = equations_.functions_.find(name);
      const bool is_known = f != equations_.functions_.end() || kFunctions.contains(name);
      if (!is_known || !take('(')) return equations_.lookup(name, local_);
      const bool outside = std::exchange(inside_bars_, false);
      std::vector<Quantity> arguments = {expression()};
      while (take(',')) arguments.push_back(expression());
      expect(')');
      inside_bars_ = outside;
      if (f == equations_.functions_.end()) return of_library(name, arguments);
      std::map<std::string, Quantity> local;
      for (std::size_t k = 0; k < f->second.arguments.size(); ++k)
        local[f->second.arguments[k]] = arguments.at(k);
      return equations_.evaluate(f->second.body, local);
    }

    static Quantity of_library(const std::string& name, const std::vector<Quantity>& arguments) {
      const Quantity& a = arguments.at(0);
      if (name == "diag") {
        const Eigen::VectorXd entries = column(arguments).value;
        return {entries.asDiagonal(), Eigen::MatrixXd::Zero(entries.size(), entries.size())};
      }
      const double x = a.number();
      if (name == "sqrt") return power(a, 0.5);
      if (name == "sin") return of_number(a, std::sin(x), std::cos(x));
      if (name == "cos") return of_number(a, std::cos(x), -std::sin(x));
      const Quantity& b = arguments.at(1);  // atan2
      const double square = x * x + b.number() * b.number();
      return {std::atan2(x, b.number()), (b.number() * a.number_rate() - x * b.number_rate()) / square};
    }

    static inline const std::set<std::string> kFunctions = {"sqrt", "sin", "cos", "atan2", "diag"};

    Equations& equations_;
    std::string_view text_;
    const std::map<std::string, Quantity>& local_;
    std::size_t at_ = 0;
    bool inside_bars_ = false;
  };

  Quantity evaluate(const std::string& text, const std::map<std::string, Quantity>& local) {
    try {
      return Reader(*this, text, local).whole();
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(std::string(error.what()) + ", in: " + text);
    }
  }

  const bool spatial_;
  std::size_t prose_met_ = 0;
  std::vector<std::pair<std::string, std::string>> motion_;
  std::map<std::string, Definition> definitions_;
  std::map<std::string, Function> functions_;
  std::map<std::string, Supplied> supplied_;
  std::map<std::string, Quantity> known_;
  std::map<std::string, Quantity> found_;  ///< evaluated since the last set()
  std::set<std::string> looking_for_;
};

}  // namespace printed
