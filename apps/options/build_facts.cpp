#include "options/build_facts.h"

#include <fmt/format.h>

#include "samara/base/version.h"
#include "samara/codebooks/file/file_format.h"
#include "samara_commit.h"

namespace samara::apps {

namespace {

#ifdef SAMARA_HAS_SUITESPARSE
constexpr const char* kGplParts = "UMFPACK and CHOLMOD of SuiteSparse, also within Ceres Solver";
constexpr const char* kSuiteSparse = "with";
#else
constexpr const char* kGplParts = "SuiteSparse within Ceres Solver, where the distribution has built it so";
constexpr const char* kSuiteSparse = "without";
#endif

}  // namespace

/// The licence of the whole is that of its strictest part.
std::string version_text() {
  const std::string machine = SAMARA_BUILT_FOR;
  return fmt::format(
      "samara {}\ncommit: {}\ncodebook format: {}.{}\nbuild: {}, {} SuiteSparse, instructions {}\n"
      "licence: BSD-3-Clause; linked with parts under the GPL ({}), the program as a whole under the GPL",
      version(), kCommit, codebooks::format::kMajor, codebooks::format::kMinor, SAMARA_BUILD_TYPE,
      kSuiteSparse, machine.empty() ? "of any machine" : machine, kGplParts);
}

}  // namespace samara::apps
