#include "samara/codebooks/book/book_model.h"

#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/models/fields/field_model.h"
#include "samara/models/laws/registry.h"

namespace samara::codebooks {

models::ParametricModel model_of(const Codebook& book) {
  if (book.is_of_command()) {
    throw ArgumentError(
        fmt::format("the codebook was sampled from a command ({}), which has no model to integrate",
                    book.model().equations));
  }
  if (book.build().builder == "fit" || book.build().builder == "plan") {
    throw ArgumentError(fmt::format(
        "the codebook holds a series, the {}: it has no equations that could be integrated, and cannot "
        "be certified again",
        book.model().name));
  }
  if (book.space() || models::find_field_model(book.model().name) != nullptr) {
    throw ArgumentError(fmt::format(
        "the codebook holds a field of space, the {}: it has no trajectories of a few states to integrate",
        book.model().name));
  }
  std::vector<std::string> free;
  for (std::size_t k = 1; k < book.coordinates().size(); ++k) free.push_back(book.coordinates()[k].name);
  auto model = known_model(book.model());
  if (!model)
    throw ArgumentError(
        fmt::format("there is no model \"{}\" here, which the codebook is of{}; the library of a model of "
                    "one's own must be loaded (--model-library)",
                    book.model().name, suggestion(book.model().name, models::model_names())));
  return models::ParametricModel(std::move(model), book.model().fixed, free);
}

}  // namespace samara::codebooks
