// The law as a library for the command.
#include "growth.h"

#include <samara/models/laws/model_library.h>

SAMARA_MODEL_LIBRARY(Growth)
