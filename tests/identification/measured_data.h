#pragma once

#include <cstdlib>
#include <filesystem>

#include <catch2/catch.hpp>

/// Where a set of measurements lies that the project may not contain; empty, with a line in the test's
/// output, where SAMARA_DATA is not set or does not have it.
inline std::filesystem::path measured_data(const std::string& set) {
  const char* const root = std::getenv("SAMARA_DATA");
  const std::filesystem::path path = root ? std::filesystem::path(root) / set : std::filesystem::path();
  if (root && std::filesystem::is_directory(path)) return path;
  WARN("skipped: SAMARA_DATA does not lead to \"" << set << "\"");
  return {};
}
