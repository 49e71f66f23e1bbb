// samara_eval.h as C++, and as it is compiled where the machine or the compiler is another one (CMakeLists.txt says
// which); under a name of its own, FLAT_EVAL_VARIANT.
#define SAMARA_EVAL_STATIC
#define SAMARA_EVAL_IMPLEMENTATION
#include "flat_eval_variant.h"

extern const FlatEval FLAT_EVAL_VARIANT;
const FlatEval FLAT_EVAL_VARIANT = {&samara_eval_open_memory, &samara_eval_work_size, &samara_eval_point,
                                    &samara_eval_close};
