#include "samara/io/csv.h"

#include <algorithm>
#include <cmath>

#include "samara/base/errors.h"
#include "samara/base/number_text.h"
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

std::string number_cell(double value, Eigen::Index row, const std::string& column) {
  if (std::isnan(value)) return "";
  if (std::isinf(value)) {
    throw ArgumentError("row " + std::to_string(row) + " of column " + in_quotes(column) +
                        " is infinite, which a table cannot hold");
  }
  return number_text(value);
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
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      if (j > 0) text += ',';
      text += number_cell(values(i, j), i, header[static_cast<std::size_t>(j)]);
    }
    // A missing value in the only column would read as a blank line.
    if (values.cols() == 1 && std::isnan(values(i, 0))) text += "\"\"";
    text += '\n';
  }
  return text;
}

void write_csv(const std::filesystem::path& path, const std::vector<std::string>& header,
               const Eigen::Ref<const Eigen::MatrixXd>& values, const CsvComments& comments) {
  write_text_atomically(path, format_csv(header, values, comments));
}

}  // namespace samara::io
