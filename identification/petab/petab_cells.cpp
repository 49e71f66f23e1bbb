#include "samara/identification/petab/petab_cells.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/limits.h"
#include "samara/base/text.h"
#include "samara/identification/captures/number_cells.h"

namespace samara::identification {

using io::DelimitedTable;

DelimitedTable read_tsv(const std::filesystem::path& path, const std::vector<std::string>& needed) {
  DelimitedTable table = DelimitedTable::read(path, {.delimiter = '\t', .decimal = '.'});
  for (const std::string& column : needed) table.texts(column);  // refuses what is missing
  return table;
}

std::vector<std::string> cells_or_empty(const DelimitedTable& table, const std::string& column) {
  return table.has(column) ? table.texts(column) : std::vector<std::string>(table.rows());
}

void require_word(const DelimitedTable& table, std::size_t row, const std::string& column,
                  const std::string& cell, const std::vector<std::string>& words) {
  if (cell.empty() || std::ranges::count(words, cell) > 0) return;
  throw table.error(
      row, fmt::format("{} is {}; {} was expected", column, in_quotes(cell), fmt::join(words, " or ")));
}

double in_size(const DelimitedTable& table, std::size_t row, const std::string& what, double number) {
  const double size = std::abs(number);
  if (size == 0.0 || (size >= kSmallestInput && size <= kLargestInput)) return number;
  throw table.error(row, fmt::format("{} is {}; a number of {} to {} in size, or 0, was expected", what,
                                     number, kSmallestInput, kLargestInput));
}

std::vector<double> numbers_in(const DelimitedTable& table, std::size_t row, const std::string& text) {
  std::vector<double> numbers;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    const auto number = number_in(trimmed(rest.substr(0, end)));
    if (!number)
      throw table.error(row, fmt::format("{} are no numbers parted by semicolons", in_quotes(text)));
    numbers.push_back(*number);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return numbers;
}

}  // namespace samara::identification
