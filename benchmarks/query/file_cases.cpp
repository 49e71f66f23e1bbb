#include "cases.h"

namespace samara::benchmarks {
void run_files(const Options&) {}
}  // namespace samara::benchmarks
