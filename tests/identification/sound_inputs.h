#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

/// Files of an input that is sound, of which one is mutated at a time.
struct SoundInput {
  std::string kind;                                        ///< plan, csv, sidecar, export, petab
  std::vector<std::pair<std::string, std::string>> files;  ///< name, text
  std::vector<std::size_t> mutated;                        ///< which of them
  std::string opened;                                      ///< the file that is read
};

/// Of every kind.
std::vector<SoundInput> sound_inputs();

/// The plan of a codebook that all captures among them can be fitted with.
std::string sound_source();
