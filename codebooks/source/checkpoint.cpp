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
#include "samara/codebooks/file/piece_format.h"

namespace samara::codebooks {

namespace {
constexpr const char* kFormat = "samara-checkpoint";
constexpr std::int64_t kVersion = 4;

/// Checkpoints go on to the last bit, which only the program that wrote them does.
std::string generator() {
  return fmt::format("samara {}", version());
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

void check_belongs(const io::Hdf5Reader& file, const std::string& plan) {
  check_format(file);
  if (file.texts("/plan") == std::vector<std::string>{plan}) return;
  throw file.error("/plan", "the checkpoint belongs to another plan");
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

Eigen::VectorXd read_march(const io::Hdf5Reader& file) {
  return file.has("/march") ? file.vector("/march") : Eigen::VectorXd();
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

void write_checkpoint(const std::filesystem::path& path, const std::string& plan,
                      const Eigen::VectorXd& march, const std::vector<CallTable>& calls) {
  io::Hdf5Writer file(path);
  file.write_text_attribute("/", "format", kFormat);
  file.write_integer_attribute("/", "format_version", kVersion);
  file.write_text_attribute("/", "generator", generator());
  file.write_texts("/plan", {plan});
  if (march.size() > 0) file.write_vector("/march", march);
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
  return InputError(path.string(), fmt::format("{}; --fresh begins anew, and removes it", reason));
}

void save_march(const std::filesystem::path& path, const std::string& plan,
                const std::vector<double>& state) {
  const auto size = static_cast<Eigen::Index>(state.size());
  write_checkpoint(path, plan, Eigen::Map<const Eigen::VectorXd>(state.data(), size),
                   kept_part<std::vector<CallTable>>(path, plan, read_calls));
}

void save_calls(const std::filesystem::path& path, const std::string& plan,
                const std::vector<CallSheet>& calls, std::size_t coordinates) {
  const auto march = kept_part<Eigen::VectorXd>(path, plan, read_march);
  std::vector<CallTable> tables;
  for (const CallSheet& sheet : calls) tables.push_back(table_of(sheet, coordinates));
  write_checkpoint(path, plan, march, tables);
}

std::vector<double> load_march(const std::filesystem::path& path, const std::string& plan) {
  return taken_up(path, plan, [](const io::Hdf5Reader& file) -> std::vector<double> {
    const Eigen::VectorXd state = read_march(file);
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
