/* The evaluator in C, compiled for the machine as the library's kernels are. */
#define SAMARA_EVAL_IMPLEMENTATION
#include "samara/codebooks/capi/samara_eval.h"
