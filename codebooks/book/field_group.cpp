#include "samara/codebooks/book/field_group.h"

namespace samara::codebooks {

GroupOutline outline_of(const FieldGroup& group) {
  const bool is_train = group.train() != nullptr;
  return {group.outputs(), is_train,
          is_train ? group.train()->train().ranks() : std::vector{group.sum()->rank()}, group.entries()};
}

}  // namespace samara::codebooks
