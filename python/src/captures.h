#pragma once

#include <pybind11/pybind11.h>

#include "samara/identification/captures/capture.h"

namespace samara::python {

/// One capture in memory: id, labels, times (frames), and channels of name, unit and values (frames).
identification::Capture capture_of(const pybind11::dict& given);

}  // namespace samara::python
