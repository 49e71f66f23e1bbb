#include "samara/identification/capture_file.h"

#include "samara/identification/capture_table.h"
#include "samara/identification/sidecar.h"

namespace samara::identification {

namespace {

Sidecar find_sidecar(const std::filesystem::path& path) {
  if (path.extension() == ".toml") return read_sidecar(path);
  const std::filesystem::path beside = std::filesystem::path(path).replace_extension(".toml");
  if (std::filesystem::is_regular_file(beside)) return read_sidecar(beside, path);
  return {.table = path};
}

}  // namespace

std::vector<Capture> read_captures(const std::filesystem::path& path) {
  const Sidecar sidecar = find_sidecar(path);
  return captures_from_table(io::DelimitedTable::read(sidecar.table, {.delimiter = sidecar.delimiter}),
                             sidecar);
}

}  // namespace samara::identification
