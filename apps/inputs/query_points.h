#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "options/arguments.h"
#include "samara/codebooks/book/codebook.h"

namespace samara::apps {

/// Points to ask a codebook for, one row each, and what was moved to get them into the box.
struct QueryPoints {
  Eigen::MatrixXd x;  ///< rows x coordinates, SI
  std::vector<std::string> clamped;
  bool from_table = false;  ///< every coordinate may differ from row to row; else only time does
};

/// Those of --set, --at, --frames and --points; with --clamp inside the box.
/// @param coordinates of the codebook, or with the directions of a mesh in place of its nodes
/// @throws ArgumentError, InputError for what is missing, unknown or said twice; OutsideBoxError naming the line of a table
QueryPoints points_of(const codebooks::Codebook& book, const std::vector<codebooks::Coordinate>& coordinates,
                      const QueryArguments& arguments);

}  // namespace samara::apps
