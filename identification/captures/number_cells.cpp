#include "samara/identification/captures/number_cells.h"

#include "samara/base/text.h"

namespace samara::identification {

std::optional<double> number_in(std::string_view text) {
  const NumberPrefix number = read_number(text);
  if (number.problem != NumberProblem::none || number.length != text.size()) return {};
  return number.value;
}

}  // namespace samara::identification
