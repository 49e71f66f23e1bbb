#pragma once

#include <string>
#include <string_view>
#include <vector>

/// Lines and cells of exports; internal to identification/.
namespace samara::identification {

/// Lines without their ends.
std::vector<std::string> lines_of(std::string_view text);

/// The cells of a line, trimmed; a quoted cell may hold the delimiter.
std::vector<std::string> cells_of(std::string_view line, char delimiter);

/// A line of as many cells as there are columns: empty ones are added or taken from its end.
std::string joined(std::vector<std::string> cells, std::size_t columns, char delimiter);

/// "1,5" or "1,5E-3", with nothing else in it.
bool has_decimal_comma(const std::string& cell);

/// Adds a number to every name that occurred before.
std::vector<std::string> made_unique(std::vector<std::string> names);

/// A text of the lines from `header` on; those above become comments, so that line numbers stay.
std::string table_text(const std::vector<std::string>& lines, std::size_t header);

}  // namespace samara::identification
