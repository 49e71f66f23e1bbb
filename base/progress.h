#pragma once

#include <functional>
#include <string>

namespace samara {

/// One report of long work.
struct Progress {
  std::string stage;      ///< what is being done, in a few words
  double fraction = 0.0;  ///< of this stage, 0 to 1
};

/// Called now and then by long work, from the calling thread; returning false asks for it to be cancelled,
/// which ends the work with a status. An empty callback is allowed.
using ProgressCallback = std::function<bool(const Progress&)>;

}  // namespace samara
