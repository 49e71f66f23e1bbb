// samara_eval.h is C++ too.
#define SAMARA_EVAL_IMPLEMENTATION
#define SAMARA_EVAL_PLAIN
#include "samara/codebooks/capi/samara_eval.h"
