#include "samara/codebooks/book/provenance.h"

#include <array>
#include <ctime>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include "samara/base/version.h"

namespace samara::codebooks {

Provenance made_now(std::string plan, double seconds) {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return {fmt::format("samara {}", version()), std::move(plan),
          fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))), host.data(), seconds};
}

}  // namespace samara::codebooks
