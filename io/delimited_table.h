#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "samara/base/errors.h"

/// Tables in text files: CSV, TSV and their relatives.
///
///     # body: mahogany seed
///     t[s],x[m],note
///     0,1.25,"start, by hand"
///     0.01,,
///
/// The first line that is neither blank nor a comment is the header; it and the rows are UTF-8. Lines that begin with
/// `#` are comments; `# key: value` is collected. Cells may be quoted as in RFC 4180; blanks around an unquoted cell
/// do not count; an empty cell is a missing value, and so are, among numbers, NaN (in any letters) and NA. Lines end
/// in LF or CRLF; a byte order mark is skipped. Numbers have a decimal point whatever the locale, or,
/// in a table whose cells are not parted by commas, a decimal comma: one sign throughout.
namespace samara::io {

struct DelimitedOptions {
  /// 0: whichever of tab, semicolon and comma the header (or the first row, if there is none) has most of.
  char delimiter = 0;
  /// Names of the columns of a file that has no header. Empty: the file has one.
  std::vector<std::string> header = {};
  /// '.' or ','; 0: a comma where cells are parted by something else, some are numbers with a decimal comma and
  /// none is one with a point.
  char decimal = 0;
};

/// An immutable table of texts, read whole.
class DelimitedTable {
 public:
  /// @throws InputError if the file cannot be read, is empty, has a name twice in its header, a quote that is
  /// not closed, a header or row that is not UTF-8, or a row whose number of cells differs from the header's
  /// (with the line). A table without rows is one.
  static DelimitedTable read(const std::filesystem::path& path, const DelimitedOptions& options = {});
  /// The same for a text. @param name stands for the file in messages.
  static DelimitedTable parse(std::string_view text, const std::string& name,
                              const DelimitedOptions& options = {});

  /// The file, as it was given.
  const std::string& file() const { return file_; }
  char delimiter() const { return delimiter_; }
  /// The decimal sign of its numbers.
  char decimal() const { return decimal_; }
  /// Names of the columns.
  const std::vector<std::string>& header() const { return header_; }
  /// Number of rows below the header.
  std::size_t rows() const { return row_lines_.size(); }
  /// Line of the file on which row i (from 0) begins.
  int line_of_row(std::size_t i) const;
  /// 0 if the file has none.
  int line_of_header() const { return header_line_; }

  /// The comments of the form `# key: value`, in order.
  const std::vector<std::pair<std::string, std::string>>& comments() const { return comments_; }
  /// The last comment with this key.
  std::optional<std::string> comment(const std::string& key) const;

  bool has(const std::string& column) const;
  /// The cells of a column; missing ones are empty.
  /// @throws InputError if there is no such column, naming the nearest.
  std::vector<std::string> texts(const std::string& column) const;
  /// Whether a cell holds nothing at all. @param row below rows()
  bool is_empty(std::size_t row, const std::string& column) const;
  /// The cells of a column as numbers; missing ones are NaN.
  /// @throws InputError as texts(), and for a cell that is not a finite number (with the line).
  Eigen::VectorXd numbers(const std::string& column) const;

  /// An error located at a row, for the caller to throw.
  InputError error(std::size_t row, const std::string& sentence) const;

 private:
  DelimitedTable() = default;
  std::size_t index_of(const std::string& column) const;

  std::string file_;
  char delimiter_ = 0;
  char decimal_ = '.';
  int header_line_ = 0;
  std::vector<std::string> header_;
  std::vector<std::pair<std::string, std::string>> comments_;
  std::vector<std::string> cells_;  // row by row
  std::vector<int> row_lines_;
};

}  // namespace samara::io
