#include "samara/io/delimited_table.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/io/text_file.h"

namespace samara::io {

namespace {

/// What programs write where there is no value: NaN in any letters, and R's NA.
bool is_missing(std::string_view cell) {
  return cell.empty() || cell == "NA" || (cell.size() == 3 && lower_case(cell) == "nan");
}

/// The first byte that begins no character of UTF-8; npos if there is none.
std::size_t first_foreign_byte(std::string_view text) {
  for (std::size_t at = 0; at < text.size(); ++at) {
    const auto begin = static_cast<unsigned char>(text[at]);
    if (begin < 0x80) continue;
    const std::size_t more = begin < 0xC2 ? 0 : begin < 0xE0 ? 1 : begin < 0xF0 ? 2 : begin < 0xF5 ? 3 : 0;
    const std::string_view rest = text.substr(at + 1, more);
    const auto goes_on = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; };
    if (more == 0 || rest.size() < more || !std::ranges::all_of(rest, goes_on)) return at;
    at += more;
  }
  return std::string_view::npos;
}

std::string delimiter_name(char delimiter) {
  return delimiter == '\t' ? std::string("tab") : "\"" + std::string(1, delimiter) + "\"";
}

/// Reads records from a text, and counts its lines.
class RecordReader {
 public:
  RecordReader(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {
    if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
    if (text_.find('\0') != std::string_view::npos) {
      throw InputError(file_, "holds a zero byte, expected text in UTF-8");
    }
  }

  bool at_end() const { return at_ == text_.size(); }
  /// The line that comes next, from 1.
  int line() const { return line_; }

  /// What is left of the current line, without its end.
  std::string_view peek_line() {
    std::string_view rest = text_.substr(at_, line_end() - at_);
    if (rest.ends_with('\r')) rest.remove_suffix(1);
    return rest;
  }

  void skip_line() {
    at_ = std::min(line_end() + 1, text_.size());
    ++line_;
  }

  /// The cells of one record are appended to `cells`; returns their number.
  std::size_t read_record(char delimiter, std::vector<std::string>& cells) {
    const std::size_t begin = at_;
    const int first_line = line_;
    for (std::size_t count = 1;; ++count) {
      skip_blanks(delimiter);
      cells.push_back(next_is('"') ? quoted_cell(delimiter) : plain_cell(delimiter));
      if (next_is(delimiter)) {
        ++at_;
        continue;
      }
      skip_line();
      require_utf8(text_.substr(begin, at_ - begin), first_line);
      return count;
    }
  }

 private:
  /// Where the current line ends. It is looked for once a line, not once a cell: a line may be long.
  std::size_t line_end() {
    if (!end_ || *end_ < at_) end_ = std::min(text_.find('\n', at_), text_.size());
    return *end_;
  }

  void require_utf8(std::string_view record, int first_line) const {
    const std::size_t foreign = first_foreign_byte(record);
    if (foreign == std::string_view::npos) return;
    const std::string_view before = record.substr(0, foreign);
    const auto line = first_line + static_cast<int>(std::ranges::count(before, '\n'));
    throw InputError(file_, line,
                     fmt::format("the byte 0x{:02x} behind {} is not UTF-8; save the table as UTF-8",
                                 static_cast<unsigned char>(record[foreign]),
                                 in_quotes(before.substr(before.find_last_of("\n\t;,") + 1))));
  }

  bool next_is(char c) const { return !at_end() && text_[at_] == c; }

  void skip_blanks(char delimiter) {
    while ((next_is(' ') || next_is('\t')) && !next_is(delimiter)) ++at_;
  }

  std::string plain_cell(char delimiter) {
    const std::string_view line = peek_line();
    const std::string_view cell = trimmed(line.substr(0, line.find(delimiter)));
    if (cell.find('\r') != std::string_view::npos) {
      throw InputError(file_, line_, "a carriage return inside the line; lines end in LF or CRLF");
    }
    if (cell.find('"') != std::string_view::npos) {
      throw InputError(file_, line_, "a quote inside the unquoted cell " + in_quotes(cell));
    }
    at_ += std::min(line.find(delimiter), line.size());
    return std::string(cell);
  }

  std::string quoted_cell(char delimiter) {
    const int first_line = line_;
    std::string cell;
    for (++at_;; ++at_) {
      if (at_end()) throw InputError(file_, first_line, "a quoted cell begins here and is never closed");
      if (next_is('"')) {
        ++at_;
        if (!next_is('"')) break;
      }
      if (next_is('\n')) ++line_;
      cell += text_[at_];
    }
    skip_blanks(delimiter);
    if (!peek_line().empty() && !next_is(delimiter)) {
      throw InputError(file_, line_, "text follows the quoted cell " + in_quotes(cell));
    }
    if (!next_is(delimiter)) at_ += peek_line().size();
    return cell;
  }

  std::string_view text_;
  std::string file_;
  std::size_t at_ = 0;
  std::optional<std::size_t> end_;
  int line_ = 1;
};

char detected_delimiter(std::string_view header) {
  char best = ',';
  std::ptrdiff_t most = 0;
  for (const char candidate : {'\t', ';', ','}) {
    std::ptrdiff_t count = 0;
    bool inside_quotes = false;
    for (const char c : header) {
      if (c == '"') inside_quotes = !inside_quotes;
      if (c == candidate && !inside_quotes) ++count;
    }
    if (count > most) {
      best = candidate;
      most = count;
    }
  }
  return best;
}

void check_header(const std::vector<std::string>& header, const std::string& file, int line) {
  std::set<std::string_view> known;
  for (auto name = header.begin(); name != header.end(); ++name) {
    if (name->empty()) {
      throw InputError(file, line, "column " + std::to_string(name - header.begin() + 1) + " has no name");
    }
    if (!known.insert(*name).second) {
      throw InputError(file, line, "the column " + in_quotes(*name) + " stands twice in the header");
    }
  }
}

/// A `key: value` of a comment line.
std::optional<std::pair<std::string, std::string>> key_and_value(std::string_view comment_line) {
  const std::string_view body =
      comment_line.substr(comment_line.find_first_not_of("# \t") == std::string_view::npos
                              ? comment_line.size()
                              : comment_line.find_first_not_of("# \t"));
  const std::size_t colon = body.find(':');
  if (colon == std::string_view::npos || trimmed(body.substr(0, colon)).empty()) return std::nullopt;
  return std::pair(std::string(trimmed(body.substr(0, colon))), std::string(trimmed(body.substr(colon + 1))));
}

/// Whether a cell is a number with this decimal sign between digits: "1,5", "-2,5E-1".
bool has_decimals(std::string_view cell, char sign) {
  const std::size_t at = cell.find(sign);
  if (at == std::string_view::npos || at + 1 == cell.size()) return false;
  std::string with_point(cell);
  with_point[at] = '.';
  const NumberPrefix number = read_number(with_point);
  return number.problem == NumberProblem::none && number.length == cell.size();
}

/// The decimal sign of a table where nobody names one.
char detected_decimal(const std::vector<std::string>& cells, char delimiter) {
  const auto some_have = [&](char sign) {
    return std::any_of(cells.begin(), cells.end(),
                       [&](const std::string& cell) { return has_decimals(cell, sign); });
  };
  return delimiter != ',' && some_have(',') && !some_have('.') ? ',' : '.';
}

/// Why a cell is not a number; empty if it is one.
std::string number_complaint(std::string_view cell, const NumberPrefix& number, char decimal) {
  if (number.problem == NumberProblem::malformed || number.length != cell.size()) {
    const char other = decimal == '.' ? ',' : '.';
    const bool is_other = cell.find(other) != std::string_view::npos;
    return "expected a number, found " + in_quotes(cell) +
           (!is_other        ? ""
            : decimal == '.' ? "; the decimal sign is a point"
                             : "; the decimal sign is a comma");
  }
  if (number.problem == NumberProblem::none) return "";
  return "expected a finite number, found " + in_quotes(cell) +
         "; a missing value is an empty cell, NaN or NA";
}

}  // namespace

DelimitedTable DelimitedTable::read(const std::filesystem::path& path, const DelimitedOptions& options) {
  return parse(read_text_file(path, {.expected = "a table"}), path.string(), options);
}

DelimitedTable DelimitedTable::parse(std::string_view text, const std::string& name,
                                     const DelimitedOptions& options) {
  DelimitedTable table;
  table.file_ = name;
  table.header_ = options.header;
  check_header(table.header_, name, 0);
  RecordReader reader(text, name);
  while (!reader.at_end()) {
    const std::string_view line = reader.peek_line();
    const bool is_comment = line.starts_with('#');
    if (is_comment) {
      if (auto entry = key_and_value(line)) table.comments_.push_back(std::move(*entry));
    }
    // A line of delimiters alone is a row of missing values, not a blank line.
    const bool is_blank = trimmed(line).empty() && (table.delimiter_ != '\t' || line.find('\t') == line.npos);
    if (is_comment || is_blank) {
      reader.skip_line();
      continue;
    }
    const int first_line = reader.line();
    if (table.delimiter_ == 0)
      table.delimiter_ = options.delimiter != 0 ? options.delimiter : detected_delimiter(line);
    if (table.header_.empty()) {
      reader.read_record(table.delimiter_, table.header_);
      table.header_line_ = first_line;
      check_header(table.header_, name, first_line);
      continue;
    }
    const std::size_t count = reader.read_record(table.delimiter_, table.cells_);
    if (count != table.header_.size()) {
      throw InputError(name, first_line,
                       "the row has " + std::to_string(count) + " cells, expected " +
                           std::to_string(table.header_.size()) + " as in the header (the delimiter is " +
                           delimiter_name(table.delimiter_) + ")");
    }
    table.row_lines_.push_back(first_line);
  }
  if (table.header_.empty()) throw InputError(name, "is empty, expected a header with the names of columns");
  table.decimal_ = options.decimal != 0 ? options.decimal : detected_decimal(table.cells_, table.delimiter_);
  return table;
}

int DelimitedTable::line_of_row(std::size_t i) const {
  if (i >= rows()) {
    throw ArgumentError("row " + std::to_string(i) + " of " + file_ + " does not exist; it has " +
                        std::to_string(rows()) + " rows");
  }
  return row_lines_[i];
}

std::optional<std::string> DelimitedTable::comment(const std::string& key) const {
  const auto entry =
      std::find_if(comments_.rbegin(), comments_.rend(), [&](const auto& c) { return c.first == key; });
  if (entry == comments_.rend()) return std::nullopt;
  return entry->second;
}

bool DelimitedTable::has(const std::string& column) const {
  return std::find(header_.begin(), header_.end(), column) != header_.end();
}

std::size_t DelimitedTable::index_of(const std::string& column) const {
  if (!has(column))
    throw InputError(file_, header_line_, "no column " + in_quotes(column) + suggestion(column, header_));
  return static_cast<std::size_t>(std::find(header_.begin(), header_.end(), column) - header_.begin());
}

std::vector<std::string> DelimitedTable::texts(const std::string& column) const {
  std::vector<std::string> texts;
  texts.reserve(rows());
  for (std::size_t cell = index_of(column); cell < cells_.size(); cell += header_.size()) {
    texts.push_back(cells_[cell]);
  }
  return texts;
}

bool DelimitedTable::is_empty(std::size_t row, const std::string& column) const {
  return cells_[row * header_.size() + index_of(column)].empty();
}

Eigen::VectorXd DelimitedTable::numbers(const std::string& column) const {
  const std::size_t index = index_of(column);
  Eigen::VectorXd values =
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(rows()), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t row = 0; row < rows(); ++row) {
    const std::string& cell = cells_[row * header_.size() + index];
    if (is_missing(cell)) continue;
    std::string text = cell;
    const std::size_t sign = decimal_ == '.' ? std::string::npos : text.find(decimal_);
    // A point would be that of thousands, or of another program.
    if (decimal_ != '.' && text.find('.') != std::string::npos) text.clear();
    if (sign != std::string::npos && !text.empty()) text[sign] = '.';
    const NumberPrefix number = read_number(text);
    const std::string complaint = number_complaint(cell, number, decimal_);
    if (!complaint.empty()) throw error(row, "column " + in_quotes(column) + ": " + complaint);
    values[static_cast<Eigen::Index>(row)] = number.value;
  }
  return values;
}

InputError DelimitedTable::error(std::size_t row, const std::string& sentence) const {
  return InputError(file_, line_of_row(row), sentence);
}

}  // namespace samara::io
