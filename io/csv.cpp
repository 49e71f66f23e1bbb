#include "samara/io/csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>

#include "samara/base/errors.h"
#include "samara/base/parallel.h"
#include "samara/base/text.h"

namespace samara::io {

namespace {

/// A header cell, quoted where a reader would otherwise take it apart, trim it, or take it for a comment.
std::string header_cell(const std::string& name) {
  const bool plain =
      name.find_first_of(",;\t\"\n\r") == std::string::npos && trimmed(name) == name && name[0] != '#';
  if (plain) return name;
  std::string cell = "\"";
  for (const char c : name) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

void append_rows_of(const Eigen::Ref<const Eigen::MatrixXd>& values, Eigen::Index begin, Eigen::Index end,
                    std::string& text) {
  for (Eigen::Index i = begin; i < end; ++i) {
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      if (j > 0) text += ',';
      append_number(text, values(i, j));
    }
    // A missing value in the only column would read as a blank line.
    if (values.cols() == 1 && std::isnan(values(i, 0))) text += "\"\"";
    text += '\n';
  }
}

void check_values(const std::vector<std::string>& header, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  for (Eigen::Index j = 0; j < values.cols(); ++j) {
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      if (!std::isinf(values(i, j))) continue;
      throw ArgumentError("row " + std::to_string(i) + " of column " +
                          in_quotes(header[static_cast<std::size_t>(j)]) +
                          " is infinite, which a table cannot hold");
    }
  }
}

void check_header(const std::vector<std::string>& header, Eigen::Index columns) {
  if (static_cast<Eigen::Index>(header.size()) != columns || header.empty()) {
    throw ArgumentError("a table with " + std::to_string(columns) +
                        " columns needs as many names, at least one; got " + std::to_string(header.size()));
  }
  std::set<std::string_view> known;
  for (const std::string& name : header) {
    if (name.empty()) throw ArgumentError("the name of a column is empty");
    if (!known.insert(name).second) {
      throw ArgumentError("the column " + in_quotes(name) + " stands twice in the header");
    }
  }
}

void check_comment(const std::string& key, const std::string& value) {
  const bool one_line = (key + value).find_first_of("\n\r") == std::string::npos;
  if (!one_line || trimmed(key).empty() || key.find(':') != std::string::npos) {
    throw ArgumentError("the comment " + in_quotes(key) + ": " + in_quotes(value) +
                        " is not one line with a key free of colons");
  }
}

std::string header_line(const std::vector<std::string>& header) {
  std::string text;
  for (const std::string& name : header) {
    if (&name != &header.front()) text += ',';
    text += header_cell(name);
  }
  return text + "\n";
}

/// Parts are made in two sets by turns: one is taken while the other is filled.
void stream_rows(Eigen::Index rows, const AppendRows& append_rows,
                 const std::function<void(std::string_view)>& take) {
  constexpr Eigen::Index kRows = 1024;  // of a part, which a thread makes
  constexpr Eigen::Index kParts = 8;    // of a set
  std::array<std::string, kParts> made, taken;
  for (Eigen::Index first = 0; first < rows + kParts * kRows; first += kParts * kRows) {
    parallel_for(kParts + 1, [&](Eigen::Index k) {
      if (k == 0) {
        for (std::string& part : taken) {
          if (!part.empty()) take(part);
        }
        return;
      }
      std::string& part = made[static_cast<std::size_t>(k - 1)];
      part.clear();
      const Eigen::Index begin = first + (k - 1) * kRows;
      if (begin < rows) append_rows(begin, std::min(begin + kRows, rows), part);
    });
    std::swap(made, taken);
  }
}

}  // namespace

void append_number(std::string& text, double value) {
  if (std::isnan(value)) return;
  std::array<char, 32> buffer;  // sign, 17 digits, point, exponent
  const auto [end, problem] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  text.append(buffer.data(), end);
}

void stream_csv(const std::vector<std::string>& header, Eigen::Index rows, const AppendRows& append_rows,
                const std::function<void(std::string_view)>& take) {
  check_header(header, std::ssize(header));
  take(header_line(header));
  stream_rows(rows, append_rows, take);
}

std::string format_csv(const std::vector<std::string>& header,
                       const Eigen::Ref<const Eigen::MatrixXd>& values, const CsvComments& comments) {
  check_header(header, values.cols());
  check_values(header, values);
  std::string text;
  for (const auto& [key, value] : comments) {
    check_comment(key, value);
    text += "# " + key + ": " + value + "\n";
  }
  text += header_line(header);
  stream_rows(
      values.rows(),
      [&](Eigen::Index begin, Eigen::Index end, std::string& part) {
        append_rows_of(values, begin, end, part);
      },
      [&](std::string_view part) { text += part; });
  return text;
}

}  // namespace samara::io
