#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "options/arguments.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/io/number_table.h"

namespace samara::apps {

/// Points to ask a codebook for, one row each, and what was moved to get them into the box.
struct QueryPoints {
  /// Of the codebook; with the directions of its mesh in place of its nodes where a place is asked for.
  std::vector<codebooks::Coordinate> coordinates;
  bool of_places = false;
  io::NumberTable::Rows x;  ///< rows x coordinates, SI
  std::vector<std::string> clamped;
  /// Of --points: every coordinate may differ from row to row; else only time does.
  std::optional<io::NumberTable> table;
  Eigen::Index times = 1;  ///< points that follow from a row of the table
  /// By coordinate: its column, where that is in SI and was not clamped; else -1.
  std::vector<Eigen::Index> columns;

  /// The coordinates of a point as cells, with commas between: as they stand in the table where they do.
  /// @param cells scratch space, kept from point to point
  void append_cells(Eigen::Index point, std::vector<std::string_view>& cells, std::string& text) const;
};

/// Those of --set, --at, --frames and --points; with --clamp inside the box.
/// @throws ArgumentError, InputError for what is missing, unknown or said twice; OutsideBoxError naming the line of a
/// table
QueryPoints points_of(const codebooks::Codebook& book, const QueryArguments& arguments);

}  // namespace samara::apps
