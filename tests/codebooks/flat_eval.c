/* The code of samara_eval.h, as a program in C has it. */
#define SAMARA_EVAL_IMPLEMENTATION
#include "samara/codebooks/capi/samara_eval.h"
