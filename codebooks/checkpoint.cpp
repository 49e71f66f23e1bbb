#include "samara/codebooks/checkpoint.h"

#include <utility>
#include <vector>

#include "samara/codebooks/store_piece.h"

namespace samara::codebooks {

namespace {
constexpr const char* kFormat = "samara-checkpoint";
}

void save_checkpoint(const std::filesystem::path& path, const std::string& plan,
                     const pgd::SolverState& state) {
  io::Hdf5Writer file(path);
  file.write_text_attribute("/", "format", kFormat);
  file.write_texts("/plan", {plan});
  file.write_integer_attribute("/", "round", state.round);
  file.write_integer_attribute("/", "time_elements", state.time_elements);
  const std::vector<double> nodes(state.nodes.begin(), state.nodes.end());
  file.write_numbers_attribute("/", "nodes", nodes);
  file.write_numbers_attribute("/", "scales", state.scales);
  file.write_number_attribute("/", "coarseness", state.coarseness);
  file.write_integer_attribute("/", "rhs_evaluations", state.rhs_evaluations);
  file.write_integer_attribute("/", "jacobian_evaluations", state.jacobian_evaluations);
  file.write_integer_attribute("/", "iterations", state.iterations);
  if (state.field) write_piece(file, "/piece", Piece{{*state.field}});
  file.commit();
}

pgd::SolverState load_checkpoint(const std::filesystem::path& path, const std::string& plan) {
  const io::Hdf5Reader file(path);
  if (!file.has_attribute("/", "format") || file.text_attribute("/", "format") != kFormat) {
    throw file.error("/", "attribute format is not \"samara-checkpoint\": this is no checkpoint");
  }
  if (file.texts("/plan") != std::vector<std::string>{plan}) {
    throw file.error("/plan", "the checkpoint belongs to another plan; remove it or build without --resume");
  }
  pgd::SolverState state;
  state.round = static_cast<int>(file.integer_attribute("/", "round"));
  state.time_elements = static_cast<int>(file.integer_attribute("/", "time_elements"));
  for (const double n : file.numbers_attribute("/", "nodes")) state.nodes.push_back(static_cast<int>(n));
  state.scales = file.numbers_attribute("/", "scales");
  state.coarseness = file.number_attribute("/", "coarseness");
  state.rhs_evaluations = static_cast<long>(file.integer_attribute("/", "rhs_evaluations"));
  state.jacobian_evaluations = static_cast<long>(file.integer_attribute("/", "jacobian_evaluations"));
  state.iterations = static_cast<int>(file.integer_attribute("/", "iterations"));
  if (file.has("/piece")) state.field = read_piece(file, "/piece").groups.front();
  return state;
}

}  // namespace samara::codebooks
