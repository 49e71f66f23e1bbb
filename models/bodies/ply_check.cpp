#include "samara/models/bodies/ply_check.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::models {

namespace {

struct PlyElement {
  std::string name;
  std::uintmax_t count = 0;
  std::vector<bool> is_list = {};  ///< per property
};

struct PlyHeader {
  bool is_text = false;
  std::vector<PlyElement> elements;
};

/// Reads up to the header's end.
PlyHeader read_header(std::istream& file, const std::string& path) {
  const std::uintmax_t bytes = std::filesystem::file_size(path);
  PlyHeader header;
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string word, next;
    words >> word >> next;
    if (word == "end_header") return header;
    if (word == "format") header.is_text = next == "ascii";
    if (word == "property" && !header.elements.empty())
      header.elements.back().is_list.push_back(next == "list");
    if (word != "element") continue;
    PlyElement& element = header.elements.emplace_back();
    element.name = next;
    if (words >> element.count && element.count <= bytes) continue;
    throw InputError(path, fmt::format("the header claims {} {} elements; the file has {} bytes",
                                       words ? std::to_string(element.count) : "unknown", next, bytes));
  }
  throw InputError(path, "the header has no end, the line \"end_header\"");
}

/// A number as from_chars reads it, but with a plus in front too, and zero where it is too small for a
/// double.
bool skip_number(std::istream& file, double* value = nullptr) {
  std::string word;
  if (!(file >> word)) return false;
  const char* const end = word.data() + word.size();
  const bool plus = word.starts_with('+') && !word.starts_with("+-");
  long double number = 0.0L;
  const auto [rest, problem] = std::from_chars(word.data() + (plus ? 1 : 0), end, number);
  if (value != nullptr) *value = static_cast<double>(number);
  return problem == std::errc() && rest == end && std::abs(number) <= std::numeric_limits<double>::max();
}

bool skip_instance(std::istream& file, const PlyElement& element) {
  for (const bool is_list : element.is_list) {
    double length = 1.0;
    if (is_list && !(skip_number(file, &length) && length >= 0.0)) return false;
    for (double k = 0.0; k < length; ++k) {
      if (!skip_number(file)) return false;
    }
  }
  return true;
}

}  // namespace

void require_complete_ply(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const PlyHeader header = read_header(file, path);
  if (!header.is_text) return;
  for (const PlyElement& element : header.elements) {
    for (std::uintmax_t i = 0; i < element.count; ++i) {
      if (skip_instance(file, element)) continue;
      throw InputError(path, fmt::format("its {} {} of {} is cut short or no row of numbers", element.name, i,
                                         element.count));
    }
  }
}

}  // namespace samara::models
