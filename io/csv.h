#pragma once

#include <filesystem>
#include <string>
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

/// The same into a file, atomically. @throws ArgumentError also if the file cannot be written.
void write_csv(const std::filesystem::path& path, const std::vector<std::string>& header,
               const Eigen::Ref<const Eigen::MatrixXd>& values, const CsvComments& comments = {});

}  // namespace samara::io
