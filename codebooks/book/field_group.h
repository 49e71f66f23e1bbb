#pragma once

#include <vector>

#include "samara/pgd/fields/field.h"

namespace samara::codebooks {

/// Several outputs over the axes of a piece: a sum of products or a tensor train.
using FieldGroup = pgd::Field;

/// Kind, outputs and ranks of a field group, without its numbers.
struct GroupOutline {
  std::vector<pgd::OutputLabel> outputs;
  bool is_train = false;
  std::vector<int> ranks;  ///< of a train, between outputs, first axis, second, ..; of a sum its terms
  long entries = 0;        ///< numbers stored, those of the axes aside
};

GroupOutline outline_of(const FieldGroup& group);

}  // namespace samara::codebooks
