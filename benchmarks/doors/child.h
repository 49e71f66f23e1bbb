#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace samara::benchmarks::doors {

/// Starts the command of this build with these arguments, its words sent nowhere.
pid_t start_samara(const std::vector<std::string>& arguments);
/// Its exit code; -1 where it was killed.
int wait_for(pid_t child);

}  // namespace samara::benchmarks::doors
