#include "samara/base/unit_factors.h"

#include <cctype>
#include <cstdlib>
#include <utility>

#include "samara/base/errors.h"
#include "samara/base/text.h"

namespace samara {

namespace {

using Factors = std::vector<UnitFactor>;

std::string replace_all(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

/// Typographic forms in plain ASCII.
std::string plain_form(std::string_view text) {
  std::string plain(text);
  for (const auto& [typographic, ascii] :
       {std::pair<std::string_view, std::string_view>{"\u207B\u00B9", "^-1"},
        {"\u207B\u00B2", "^-2"},
        {"\u207B\u00B3", "^-3"},
        {"\u207B\u2074", "^-4"},
        {"\u00B2", "^2"},
        {"\u00B3", "^3"},
        {"\u2074", "^4"},
        {"\u00B7", "*"},
        {"\u22C5", "*"},
        {"**", "^"}}) {
    plain = replace_all(std::move(plain), typographic, ascii);
  }
  return plain;
}

/// Recursive descent over
///   expression = factor { ("*" | blank | "/") factor }
///   factor     = ( "1" | symbol | "(" expression ")" ) [ ["^"] integer ]
class UnitParser {
 public:
  UnitParser(std::string_view text, std::string_view what) : text_(plain_form(text)), what_(what) {
    constexpr std::size_t kLongestUnit = 200;  // bounds the recursion
    if (text_.size() > kLongestUnit) fail("the unit is longer than 200 characters");
  }

  Factors parse() {
    skip_blanks();
    if (at_end()) fail("the unit is empty; write 1 for a dimensionless one");
    Factors factors = expression();
    if (!at_end()) fail("unexpected " + in_quotes(std::string_view(text_).substr(at_)) + " in the unit");
    return factors;
  }

 private:
  [[noreturn]] void fail(const std::string& sentence) const { throw ArgumentError(what_ + ": " + sentence); }
  bool at_end() const { return at_ == text_.size(); }
  char next() const { return at_end() ? '\0' : text_[at_]; }
  void skip_blanks() {
    while (next() == ' ' || next() == '\t') ++at_;
  }

  Factors expression() {
    Factors product = factor();
    bool divided = false;
    for (skip_blanks(); !at_end() && next() != ')'; skip_blanks()) {
      const bool divide = next() == '/';
      if (divide || next() == '*') {
        ++at_;
        skip_blanks();
      }
      if (divided && !divide) fail("a product after a slash is ambiguous; write parentheses, as in W/(m K)");
      divided = divided || divide;
      for (UnitFactor& further : to_power(factor(), divide ? -1 : 1)) product.push_back(std::move(further));
    }
    return product;
  }

  Factors factor() {
    skip_blanks();
    if (next() == '(') {
      ++at_;
      Factors inner = expression();
      if (next() != ')') fail("a closing parenthesis is missing in the unit");
      ++at_;
      return to_power(std::move(inner), exponent());
    }
    if (next() == '1') {
      ++at_;
      return {};
    }
    std::string name = symbol();
    return {{std::move(name), exponent()}};
  }

  Factors to_power(Factors factors, int exponent) const {
    constexpr int kLargest = 300;  // nested powers could overflow
    for (UnitFactor& factor : factors) {
      factor.exponent *= exponent;
      if (std::abs(factor.exponent) > kLargest) fail("the unit is beyond any use");
    }
    return factors;
  }

  std::string symbol() {
    const std::size_t begin = at_;
    while (!at_end() && std::string_view(" \t*/^()+-.,0123456789").find(next()) == std::string_view::npos)
      ++at_;
    std::string name = text_.substr(begin, at_ - begin);
    if (name.empty() && at_end()) fail("the unit ends where a symbol was expected");
    if (name.empty()) fail("expected a unit symbol, found " + in_quotes(std::string_view(text_).substr(at_)));
    return name;
  }

  int exponent() {
    const bool caret = next() == '^';
    if (caret) ++at_;
    const bool negative = next() == '-';
    if (negative || next() == '+') ++at_;
    const std::size_t begin = at_;
    int value = 0;
    while (std::isdigit(static_cast<unsigned char>(next())) != 0 && value < 100)
      value = 10 * value + (text_[at_++] - '0');
    if (at_ == begin && !caret && !negative) return 1;
    if (at_ == begin || next() == '.') fail("an exponent in the unit is not a whole number");
    constexpr int kLargest = 12;
    if (value > kLargest) fail("an exponent in the unit is beyond " + std::to_string(kLargest));
    return negative ? -value : value;
  }

  std::string text_;
  std::string what_;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<UnitFactor> unit_factors(std::string_view text, std::string_view what) {
  return UnitParser(text, what).parse();
}

}  // namespace samara
