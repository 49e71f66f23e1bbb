#include "mutator.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

namespace {

const std::vector<std::string>& words() {
  static const std::vector<std::string> all = {"nan",
                                               "inf",
                                               "-1",
                                               "0",
                                               "1e308",
                                               "1e999",
                                               "1,5",
                                               "1.5.2",
                                               "\"",
                                               "'",
                                               "[",
                                               "]",
                                               "{",
                                               "}",
                                               "=",
                                               "#",
                                               ";",
                                               ",",
                                               "\t",
                                               "\n",
                                               "\n\n",
                                               "\r\n",
                                               ":",
                                               "- ",
                                               "/",
                                               "..",
                                               "*",
                                               "px",
                                               "m",
                                               "deg",
                                               "furlong",
                                               "t",
                                               "x",
                                               "\\",
                                               "\xff",
                                               "é",
                                               "0:00:00:00",
                                               "true",
                                               "=\"\"",
                                               std::string(1, '\0'),
                                               std::string(300, '9'),
                                               "[[",
                                               "a.b"};
  return all;
}

bool is_separator(char c) {
  return std::string(" \t\n,;=[]\":{}").find(c) != std::string::npos;
}

std::pair<std::size_t, std::size_t> token_at(const std::string& text, std::size_t at) {
  std::size_t begin = std::min(at, text.size()), end = begin;
  while (begin > 0 && !is_separator(text[begin - 1])) --begin;
  while (end < text.size() && !is_separator(text[end])) ++end;
  return {begin, end - begin};
}
std::string token(const std::string& text, std::size_t at) {
  const auto [begin, size] = token_at(text, at);
  return text.substr(begin, size);
}
std::string replace_token(std::string text, std::size_t at, const std::string& other) {
  const auto [begin, size] = token_at(text, at);
  return text.replace(begin, size, other);
}

template <class Change>
std::string with_lines(const std::string& text, const Change& change) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    lines.push_back(text.substr(begin, end - begin));
    begin = end;
  }
  if (!lines.empty()) change(lines);
  std::string joined;
  for (const std::string& line : lines) joined += line;
  return joined;
}

}  // namespace

std::string Mutator::operator()(std::string text) {
  for (std::size_t change = 1 + below(3); change > 0; --change) text = once(std::move(text));
  return text;
}

std::string Mutator::once(std::string text) {
  const std::size_t at = below(text.size() + 1);
  switch (below(9)) {
    case 0:
      return text.substr(0, at);
    case 1:
      if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
      return text;
    case 2:
      return text.insert(at, words()[below(words().size())]);
    case 3:
      return text.erase(at, 1 + below(12));
    case 4:
      return replace_token(text, at, words()[below(words().size())]);
    case 5:
      return replace_token(text, at, token(text, below(text.size() + 1)));
    case 6:
      return with_lines(text, [&](std::vector<std::string>& lines) {
        lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(below(lines.size())));
      });
    case 7:
      return with_lines(text, [&](std::vector<std::string>& lines) {
        const std::string line = lines[below(lines.size())];
        lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(below(lines.size() + 1)), line);
      });
    default:
      return with_lines(text, [&](std::vector<std::string>& lines) {
        std::swap(lines[below(lines.size())], lines[below(lines.size())]);
      });
  }
}
