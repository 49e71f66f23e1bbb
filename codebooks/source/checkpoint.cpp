#include "samara/codebooks/source/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/version.h"
#include "samara/codebooks/file/store_piece.h"

namespace samara::codebooks {

namespace {
constexpr const char* kFormat = "samara-checkpoint";
constexpr std::int64_t kVersion = 3;

/// Checkpoints go on to the last bit, which only the program that wrote them does.
std::string generator() {
  return fmt::format("samara {}", version());
}

std::int64_t count(const io::Hdf5Reader& file, const std::string& name, std::int64_t least,
                   std::int64_t most) {
  const std::int64_t value = file.integer_attribute("/", name);
  if (value < least || value > most)
    throw file.error("/", fmt::format("{} is {}, expected {} to {}", name, value, least, most));
  return value;
}

void check_format(const io::Hdf5Reader& file) {
  if (!file.has_attribute("/", "format") || file.text_attribute("/", "format") != kFormat) {
    throw file.error("/", "attribute format is not \"samara-checkpoint\": this is no checkpoint");
  }
  if (!file.has_attribute("/", "format_version") ||
      file.integer_attribute("/", "format_version") != kVersion ||
      file.text_attribute("/", "generator") != generator()) {
    throw file.error("/",
                     fmt::format("the checkpoint was not written by {}, format {}", generator(), kVersion));
  }
}

pgd::SeparatedField read_field(const io::Hdf5Reader& file) {
  const Piece piece = read_piece(file, "/piece");
  const pgd::SeparatedField* field = piece.groups().front().sum();
  if (field == nullptr) throw file.error("/piece/groups/0", "is a train, expected a sum of products");
  return *field;
}

/// The field must lie over the axes of the state: time first, then one per number of nodes.
void check_field(const io::Hdf5Reader& file, const pgd::SolverState& state) {
  if (!state.field) {
    if (state.round > 0) throw file.error("/piece", "is missing, expected the field of the last round");
    return;
  }
  if (static_cast<std::size_t>(state.field->axis_count()) == state.nodes.size() + 1 &&
      static_cast<std::size_t>(state.field->output_count()) == state.scales.size()) {
    return;
  }
  throw file.error("/piece",
                   fmt::format("has {} axes and {} outputs, expected {} and {}", state.field->axis_count(),
                               state.field->output_count(), state.nodes.size() + 1, state.scales.size()));
}

std::vector<int> read_nodes(const io::Hdf5Reader& file) {
  constexpr double kMostNodes = 2000;  // of a plan; the solver chooses fewer
  std::vector<int> nodes;
  for (const double n : file.numbers_attribute("/", "nodes")) {
    if (!(n >= 2.0 && n <= kMostNodes) || n != std::floor(n)) {
      throw file.error(
          "/", fmt::format("nodes has the number {}, expected whole numbers from 2 to {}", n, kMostNodes));
    }
    nodes.push_back(static_cast<int>(n));
  }
  return nodes;
}

std::vector<double> read_scales(const io::Hdf5Reader& file) {
  std::vector<double> scales = file.numbers_attribute("/", "scales");
  for (const double scale : scales) {
    if (!(scale > 0.0) || !std::isfinite(scale))
      throw file.error("/", fmt::format("scales has the number {}, expected positive numbers", scale));
  }
  return scales;
}

void check_belongs(const io::Hdf5Reader& file, const std::string& plan) {
  check_format(file);
  if (file.texts("/plan") == std::vector<std::string>{plan}) return;
  throw file.error("/plan", "the checkpoint belongs to another plan");
}

bool has_state(const io::Hdf5Reader& file) {
  return file.has_attribute("/", "round") || (!file.has("/calls") && !file.has("/march"));
}

pgd::SolverState read_state(const io::Hdf5Reader& file) {
  pgd::SolverState state;
  constexpr std::int64_t kMost = 1'000'000;  // rounds, elements, iterations: more than any build does
  constexpr std::int64_t kMostEvaluations = 1'000'000'000'000'000;
  state.round = static_cast<int>(count(file, "round", 0, kMost));
  state.time_elements = static_cast<int>(count(file, "time_elements", 1, kMost));
  state.nodes = read_nodes(file);
  state.scales = read_scales(file);
  state.coarseness = file.number_attribute("/", "coarseness");
  if (!(state.coarseness >= 0.0) || !std::isfinite(state.coarseness))
    throw file.error("/", fmt::format("coarseness is {}, expected a number of at least 0", state.coarseness));
  state.rhs_evaluations = static_cast<long>(count(file, "rhs_evaluations", 0, kMostEvaluations));
  state.jacobian_evaluations = static_cast<long>(count(file, "jacobian_evaluations", 0, kMostEvaluations));
  state.iterations = static_cast<int>(count(file, "iterations", 0, kMost));
  if (file.has("/piece")) state.field = read_field(file);
  check_field(file, state);
  return state;
}

void write_state(io::Hdf5Writer& file, const pgd::SolverState& state) {
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
}

/// Calls as the file holds them: a row per call.
struct CallTable {
  Eigen::VectorXd times;
  Eigen::MatrixXd points, values;
  double seconds = 0.0;
};

CallSheet sheet_of(const CallTable& table) {
  const Eigen::MatrixXd points = table.points.transpose(), values = table.values.transpose();
  return {{table.times.begin(), table.times.end()},
          {points.data(), points.data() + points.size()},
          {values.data(), values.data() + values.size()},
          table.seconds};
}

CallTable table_of(const CallSheet& sheet, std::size_t coordinates) {
  const auto calls = static_cast<Eigen::Index>(sheet.points.size() / coordinates);
  const auto times = static_cast<Eigen::Index>(sheet.times.size());
  const auto rows = static_cast<Eigen::Index>(sheet.values.size()) / std::max<Eigen::Index>(1, calls);
  using Columns = Eigen::Map<const Eigen::MatrixXd>;
  return {Eigen::Map<const Eigen::VectorXd>(sheet.times.data(), times),
          Columns(sheet.points.data(), static_cast<Eigen::Index>(coordinates), calls).transpose(),
          Columns(sheet.values.data(), rows, calls).transpose(), sheet.seconds};
}

std::vector<CallTable> read_calls(const io::Hdf5Reader& file) {
  std::vector<CallTable> tables;
  if (!file.has("/calls")) return tables;
  const int count = numbered_children(file, "/calls");
  for (int s = 0; s < count; ++s) {
    const std::string path = fmt::format("/calls/{}", s);
    CallTable table;
    if (file.has(path + "/times")) table.times = file.vector(path + "/times");
    table.points = file.matrix(path + "/points");
    if (file.has_attribute(path, "seconds")) table.seconds = file.number_attribute(path, "seconds");
    table.values = file.matrix(path + "/values", {.rows = table.points.rows()});
    tables.push_back(std::move(table));
  }
  return tables;
}

/// The state of the engine: of its rounds, or of its march in slabs.
struct EngineState {
  std::optional<pgd::SolverState> rounds;
  Eigen::VectorXd march;
};

EngineState read_engine(const io::Hdf5Reader& file) {
  EngineState state;
  if (file.has_attribute("/", "round")) state.rounds = read_state(file);
  if (file.has("/march")) state.march = file.vector("/march");
  return state;
}

/// What else is in the file. One that is broken or of another plan gives nothing: it is replaced.
template <class Part, class Read>
Part kept_part(const std::filesystem::path& path, const std::string& plan, const Read& read) {
  if (!is_checkpoint(path)) return {};
  try {
    const io::Hdf5Reader file(path);
    check_belongs(file, plan);
    return read(file);
  } catch (const InputError&) {
    return {};
  }
}

/// What is to be taken up.
template <class Read>
auto taken_up(const std::filesystem::path& path, const std::string& plan, const Read& read) {
  try {
    const io::Hdf5Reader file(path);
    check_belongs(file, plan);
    return read(file);
  } catch (const InputError& error) {
    std::string reason = error.what();
    const std::string name = path.string() + ": ";
    if (reason.starts_with(name)) reason.erase(0, name.size());
    throw bad_checkpoint(path, reason);
  }
}

void write_checkpoint(const std::filesystem::path& path, const std::string& plan, const EngineState& state,
                      const std::vector<CallTable>& calls) {
  io::Hdf5Writer file(path);
  file.write_text_attribute("/", "format", kFormat);
  file.write_integer_attribute("/", "format_version", kVersion);
  file.write_text_attribute("/", "generator", generator());
  file.write_texts("/plan", {plan});
  if (state.rounds) write_state(file, *state.rounds);
  if (state.march.size() > 0) file.write_vector("/march", state.march);
  int s = 0;
  for (const CallTable& table : calls) {
    if (table.points.size() == 0) continue;
    const std::string group = fmt::format("/calls/{}", s++);
    if (table.times.size() > 0) file.write_vector(group + "/times", table.times);
    file.write_matrix(group + "/points", table.points);
    file.write_matrix(group + "/values", table.values);
    file.write_number_attribute(group, "seconds", table.seconds);
  }
  file.commit();
}

}  // namespace

bool is_checkpoint(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

InputError bad_checkpoint(const std::filesystem::path& path, const std::string& reason) {
  return InputError(path.string(), fmt::format("{}; remove the file or build without --resume", reason));
}

void save_checkpoint(const std::filesystem::path& path, const std::string& plan,
                     const pgd::SolverState& state) {
  write_checkpoint(path, plan, {state, {}}, kept_part<std::vector<CallTable>>(path, plan, read_calls));
}

void save_march(const std::filesystem::path& path, const std::string& plan,
                const std::vector<double>& state) {
  const auto size = static_cast<Eigen::Index>(state.size());
  write_checkpoint(path, plan, {std::nullopt, Eigen::Map<const Eigen::VectorXd>(state.data(), size)},
                   kept_part<std::vector<CallTable>>(path, plan, read_calls));
}

void save_calls(const std::filesystem::path& path, const std::string& plan,
                const std::vector<CallSheet>& calls, std::size_t coordinates) {
  const EngineState state = kept_part<EngineState>(path, plan, read_engine);
  std::vector<CallTable> tables;
  for (const CallSheet& sheet : calls) tables.push_back(table_of(sheet, coordinates));
  write_checkpoint(path, plan, state, tables);
}

pgd::SolverState load_checkpoint(const std::filesystem::path& path, const std::string& plan) {
  return taken_up(path, plan, [](const io::Hdf5Reader& file) {
    return has_state(file) ? read_state(file) : pgd::SolverState();
  });
}

std::vector<double> load_march(const std::filesystem::path& path, const std::string& plan) {
  return taken_up(path, plan, [](const io::Hdf5Reader& file) -> std::vector<double> {
    if (!file.has("/march")) return {};
    const Eigen::VectorXd state = file.vector("/march");
    return {state.begin(), state.end()};
  });
}

std::vector<CallSheet> load_calls(const std::filesystem::path& path, const std::string& plan) {
  return taken_up(path, plan, [](const io::Hdf5Reader& file) {
    std::vector<CallSheet> sheets;
    for (const CallTable& table : read_calls(file)) sheets.push_back(sheet_of(table));
    return sheets;
  });
}

}  // namespace samara::codebooks
