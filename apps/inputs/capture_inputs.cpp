#include "inputs/capture_inputs.h"

#include <filesystem>

#include "samara/base/text.h"
#include "samara/identification/captures/capture_file.h"

namespace samara::apps {

std::vector<std::string> files_of_captures(std::span<const std::string> captures,
                                           const std::string& sidecar) {
  std::vector<std::string> files;
  if (!sidecar.empty()) files.push_back(sidecar);
  for (const std::string& capture : captures) {
    const bool is_table = ending_of(capture) != ".toml";
    for (const std::filesystem::path& file : sidecar.empty() || !is_table
                                                 ? identification::capture_files(capture)
                                                 : identification::capture_files(capture, sidecar))
      files.push_back(file.string());
  }
  return files;
}

}  // namespace samara::apps
