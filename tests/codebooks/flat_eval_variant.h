#pragma once

#include "samara/codebooks/capi/samara_eval.h"

/// What asks a flat file for answers, of samara_eval.h compiled in one of several ways.
struct FlatEval {
  decltype(&samara_eval_open_memory) open_memory;
  decltype(&samara_eval_work_size) work_size;
  decltype(&samara_eval_point) point;
  decltype(&samara_eval_close) close;
};
