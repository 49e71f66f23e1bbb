#include "inputs/flows.h"

#include <map>

#include <fmt/format.h>

#include "inputs/assignments.h"
#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/flow/books/field_flow.h"
#include "samara/models/bodies/mesh_file.h"
#include "terminal/output.h"

namespace samara::apps {

flow::StoredFlow flow_of_file(const std::string& path, const std::vector<std::string>& set,
                              const std::string& option) {
  if (!codebooks::is_codebook(path)) {
    if (!set.empty())
      throw ArgumentError(fmt::format(
          "{}: {} is one flow, which has nothing to set; a codebook of fields was expected", option, path));
    return flow::load_flow(path);
  }
  const codebooks::Codebook book = codebooks::load(path);
  std::map<std::string, std::string> units;
  for (const codebooks::Coordinate& coordinate : book.coordinates()) {
    if (coordinate.role != pgd::AxisRole::space) units[coordinate.name] = coordinate.unit;
  }
  warn_of_missed_tolerance(book, path);
  return flow::flow_of(book, parse_assignments(set, units, option), path,
                       [](const std::string& file) { return models::read_mesh(file, 1.0); });
}

}  // namespace samara::apps
