// The law as a library for the command: samara --model-library libpredator_prey.so build ..
#include "predator_prey.h"
#include "samara/models/laws/model_library.h"

SAMARA_MODEL_LIBRARY(PredatorPrey)
