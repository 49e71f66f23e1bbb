#include "samara/identification/problem/warnings.h"

#include <algorithm>
#include <array>
#include <utility>

namespace samara::identification {

std::string to_string(WarningKind kind) {
  static constexpr std::array kNames = {"source", "captures", "model",    "bounds", "undetermined", "errors",
                                        "noise",  "optima",   "segments", "steps",  "predictions",  "series"};
  static_assert(kNames.size() == static_cast<std::size_t>(WarningKind::series) + 1);
  return kNames.at(static_cast<std::size_t>(kind));
}

bool Warnings::add(WarningKind kind, std::string sentence) {
  if (std::ranges::find(list_, sentence, &Warning::sentence) != list_.end()) return false;
  list_.push_back({kind, std::move(sentence)});
  return true;
}

void Warnings::add_all(WarningKind kind, std::vector<std::string> sentences) {
  for (std::string& sentence : sentences) add(kind, std::move(sentence));
}

void Warnings::add_all(const Warnings& others) {
  for (const Warning& other : others) add(other.kind, other.sentence);
}

std::vector<std::string> Warnings::sentences() const {
  std::vector<std::string> all;
  for (const Warning& warning : list_) all.push_back(warning.sentence);
  return all;
}

bool Warnings::has(WarningKind kind, std::string_view text) const {
  return std::ranges::any_of(list_, [&](const Warning& warning) {
    return warning.kind == kind && warning.sentence.find(text) != std::string::npos;
  });
}

}  // namespace samara::identification
