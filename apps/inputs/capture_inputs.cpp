#include "inputs/capture_inputs.h"

#include <filesystem>

#include "samara/identification/captures/capture_file.h"

namespace samara::apps {

std::vector<std::string> files_of_captures(std::span<const std::string> captures,
                                           const std::string& sidecar) {
  std::vector<std::string> files;
  if (!sidecar.empty()) files.push_back(sidecar);
  for (const std::string& capture : captures) {
    for (const std::filesystem::path& file : identification::capture_files(capture, sidecar))
      files.push_back(file.string());
  }
  return files;
}

}  // namespace samara::apps
