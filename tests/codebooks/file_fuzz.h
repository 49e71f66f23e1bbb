#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "samara/codebooks/book/codebook.h"

/// Mutated codebook files, read in child processes.
namespace file_fuzz {

struct Report {
  int mutated = 0;
  int repaired = 0;  ///< of them, those whose checksums were made right again
  int refused = 0;   ///< by an InputError
  int same = 0;      ///< the same codebook nevertheless
  int other = 0;     ///< another one, which no checksum can tell, that answers questions
  int failures = 0;  ///< crashed, hung, threw something else, or gave another answer with wrong checksums
  std::string first_failure;
  std::vector<std::string> failed_files;  ///< the bytes of some of them
};

/// Writes the codebook, changes the file in `count` ways, half of them with checksums repaired, and reads
/// each. No child lives longer than ten seconds without an answer.
Report fuzz(const samara::codebooks::Codebook& book, int count, std::uint64_t seed);

}  // namespace file_fuzz
