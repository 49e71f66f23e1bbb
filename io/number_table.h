#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "samara/base/errors.h"
#include "samara/io/delimited_table.h"

namespace samara::io {

/// A table of numbers only, such as a hundred thousand points: what DelimitedTable reads, some ten times faster, on all
/// threads.
class NumberTable {
 public:
  /// Numbers row by row.
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// @throws InputError as DelimitedTable::read() and numbers()
  static NumberTable read(const std::filesystem::path& path);
  /// @param name stands for the file in messages
  static NumberTable parse(std::string text, const std::string& name);

  /// The table without its rows: what it holds may be refused before a number is read.
  /// @throws InputError for a text without a header
  static DelimitedTable head(std::string_view text, const std::string& name);

  const std::vector<std::string>& header() const { return header_; }
  /// One row per row of the table; missing cells are NaN.
  const Rows& values() const { return values_; }

  /// Whether cells() has the text of every number: where no cell is missing or quoted, and decimals have points.
  bool has_cells() const { return !row_begins_.empty(); }
  /// The numbers of a row as they stand in the file, without blanks and plus signs; valid as long as the table.
  /// @param cells one for each column
  void read_cells(Eigen::Index row, std::span<std::string_view> cells) const;

  /// An error located at a row, from 0, for the caller to throw.
  InputError error(Eigen::Index row, const std::string& sentence) const;

 private:
  NumberTable() = default;
  bool read_plain_rows(std::size_t begin);

  std::string text_, name_;
  std::vector<std::string> header_;
  Rows values_;
  char delimiter_ = ',';
  std::vector<std::size_t> row_begins_;  ///< offsets into text_, where all rows are of plain numbers
};

}  // namespace samara::io
