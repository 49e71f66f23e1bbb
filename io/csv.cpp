#include "samara/io/csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "samara/base/errors.h"
#include "samara/base/parallel.h"
#include "samara/base/text.h"
#include "samara/io/atomic_file.h"

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

void append_number(std::string& text, double value) {
  std::array<char, 32> buffer;  // sign, 17 digits, point, exponent
  const auto [end, problem] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  text.append(buffer.data(), end);
}

std::string rows_text(const std::vector<std::string>& header, const Eigen::Ref<const Eigen::MatrixXd>& values,
                      Eigen::Index begin, Eigen::Index end) {
  std::string text;
  constexpr Eigen::Index kBytes = 20;  // of a number with all its digits, and a comma; few are longer
  text.reserve(static_cast<std::size_t>((end - begin) * (kBytes * values.cols() + 1)));
  for (Eigen::Index i = begin; i < end; ++i) {
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      if (j > 0) text += ',';
      const double value = values(i, j);
      if (std::isnan(value)) continue;
      if (std::isinf(value)) {
        throw ArgumentError("row " + std::to_string(i) + " of column " +
                            in_quotes(header[static_cast<std::size_t>(j)]) +
                            " is infinite, which a table cannot hold");
      }
      append_number(text, value);
    }
    // A missing value in the only column would read as a blank line.
    if (values.cols() == 1 && std::isnan(values(i, 0))) text += "\"\"";
    text += '\n';
  }
  return text;
}

void check_header(const std::vector<std::string>& header, Eigen::Index columns) {
  if (static_cast<Eigen::Index>(header.size()) != columns || header.empty()) {
    throw ArgumentError("a table with " + std::to_string(columns) +
                        " columns needs as many names, at least one; got " + std::to_string(header.size()));
  }
  for (auto name = header.begin(); name != header.end(); ++name) {
    if (name->empty()) throw ArgumentError("the name of a column is empty");
    if (std::find(header.begin(), name, *name) != name) {
      throw ArgumentError("the column " + in_quotes(*name) + " stands twice in the header");
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

}  // namespace

std::string format_csv(const std::vector<std::string>& header,
                       const Eigen::Ref<const Eigen::MatrixXd>& values, const CsvComments& comments) {
  check_header(header, values.cols());
  std::string text;
  for (const auto& [key, value] : comments) {
    check_comment(key, value);
    text += "# " + key + ": " + value + "\n";
  }
  for (const std::string& name : header) {
    if (&name != &header.front()) text += ',';
    text += header_cell(name);
  }
  text += "\n";
  constexpr Eigen::Index kRows = 4096;  // in a part, which a thread writes
  std::vector<std::string> parts(static_cast<std::size_t>((values.rows() + kRows - 1) / kRows));
  parallel_for(parts.size(), [&](std::size_t k) {
    const Eigen::Index begin = static_cast<Eigen::Index>(k) * kRows;
    parts[k] = rows_text(header, values, begin, std::min(begin + kRows, values.rows()));
  });
  std::size_t size = text.size();
  for (const std::string& part : parts) size += part.size();
  text.reserve(size);
  for (const std::string& part : parts) text += part;
  return text;
}

void write_csv(const std::filesystem::path& path, const std::vector<std::string>& header,
               const Eigen::Ref<const Eigen::MatrixXd>& values, const CsvComments& comments) {
  write_text_atomically(path, format_csv(header, values, comments));
}

}  // namespace samara::io
