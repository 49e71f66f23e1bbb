#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "samara/io/delimited_table.h"

/// Cells of PEtab's tables; internal to identification/. What they throw are InputErrors with file and line.
namespace samara::identification {

/// A table parted by tabs, with decimal points, that has these columns.
io::DelimitedTable read_tsv(const std::filesystem::path& path, const std::vector<std::string>& needed);

/// The cells of a column that may be missing: then they are empty.
std::vector<std::string> cells_or_empty(const io::DelimitedTable& table, const std::string& column);

/// Refuses a cell that is neither empty nor one of some words.
void require_word(const io::DelimitedTable& table, std::size_t row, const std::string& column,
                  const std::string& cell, const std::vector<std::string>& words);

/// The number, unless it is too large or too small to calculate with (base/limits.h).
/// @param what it is, for the message
double in_size(const io::DelimitedTable& table, std::size_t row, const std::string& what, double number);

/// "1.5;0.2"
std::vector<double> numbers_in(const io::DelimitedTable& table, std::size_t row, const std::string& text);

}  // namespace samara::identification
