#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/captures/sidecar.h"
#include "samara/io/delimited_table.h"

/// The columns of a table as quantities in SI; internal to identification/.
namespace samara::identification {

/// One column over all rows of the table.
struct Column {
  std::string name;  ///< in the header
  std::string quantity;
  std::string unit;        ///< of SI symbols, or "px"
  Eigen::VectorXd values;  ///< NaN where the cell is empty, or says so
};

struct Columns {
  std::optional<Column> time;  ///< s; none: rows of a capture are frames at the sidecar's frame rate
  std::vector<Column> measured;
  std::vector<Column> euler;  ///< none or three, rad
};

/// Takes the meanings from the sidecar, or where it has none from the canonical header.
/// @throws InputError as read_captures()
Columns read_columns(const io::DelimitedTable& table, const Sidecar& sidecar);

}  // namespace samara::identification
