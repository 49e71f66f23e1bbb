#include "samara/base/version.h"

namespace samara {
const char* version() {
  return SAMARA_VERSION;
}
}  // namespace samara
