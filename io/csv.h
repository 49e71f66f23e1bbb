#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

/// Writing of tables as CSV that DelimitedTable reads back with the same bits.
namespace samara::io {

/// `key: value` pairs, written as `# key: value` above the header.
using CsvComments = std::vector<std::pair<std::string, std::string>>;

/// The table as text: commas, LF, each number in the shortest form that reads back exactly, NaN as an empty
/// cell.
/// @param values one row per line, one column per name in `header`
/// @throws ArgumentError if the sizes do not match, a name is empty or stands twice, a value is infinite, or
/// a comment is not one line with a key free of colons.
std::string format_csv(const std::vector<std::string>& header,
                       const Eigen::Ref<const Eigen::MatrixXd>& values, const CsvComments& comments = {});

/// A number as a cell: the shortest form that reads back exactly, nothing for NaN.
void append_number(std::string& text, double value);

/// Appends rows [begin, end) of a table, each with its line end.
using AppendRows = std::function<void(Eigen::Index begin, Eigen::Index end, std::string& text)>;

/// A table of any length by parts of its text, in their order: on the threads of the arena parts are made while
/// those before them are taken, and few stand in memory at a time.
/// @param append_rows is called side by side for different rows
/// @throws ArgumentError for a header that format_csv() refuses, and what the two functions throw
void stream_csv(const std::vector<std::string>& header, Eigen::Index rows, const AppendRows& append_rows,
                const std::function<void(std::string_view)>& take);

}  // namespace samara::io
