// What eigen_decompositions.h declares, here defined.
#define SAMARA_EIGEN_TEMPLATE template
#include "eigen_decompositions.h"
