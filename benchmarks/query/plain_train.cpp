#include <algorithm>

#include "cases.h"

namespace samara::benchmarks {
#define PLAIN_NAME plain_value
#include "plain_train.inc"
}  // namespace samara::benchmarks
