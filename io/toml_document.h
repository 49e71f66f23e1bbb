#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "samara/base/errors.h"

/// Reading of TOML files, strictly: each value is asked for by its key and its kind, and whatever does not
/// fit is an InputError with file, line, table and key, as in `plan.toml:7: [time] end: expected a number,
/// found the string "soon"`.
///
///     const TomlTable plan = TomlTable::read("plan.toml");
///     plan.expect_keys({"model", "fixed"});
///     const TomlTable fixed = plan.table("fixed");
///     const double thickness = fixed.quantity("thickness", "m");  // 1.5e-3, or "1.5 mm"
namespace samara::io {

/// One table of a document, which all its tables share. A small value; copies are cheap, and safe between
/// threads.
///
/// Every getter throws InputError if its value is missing or of another kind; those named optional_... return
/// nothing if it is missing. Keys are single keys, never dotted paths: "theta(0)" and "a.b" are looked up as
/// they stand.
class TomlTable {
 public:
  /// The root table of a file. @param expected what the file should be, in messages: "a plan"
  /// @throws InputError if it cannot be read or is not TOML.
  static TomlTable read(const std::filesystem::path& path, const std::string& expected = "TOML");
  /// The root table of a text. @param name stands for the file in messages.
  static TomlTable parse(std::string_view text, const std::string& name,
                         const std::string& expected = "TOML");

  /// The file, as it was given.
  const std::string& file() const;
  /// "[box]", "[box.A]", "[command.inputs[0]]"; empty for the root.
  const std::string& path() const;
  /// Line of the key, or of the table where there is no such key; 0 for the root.
  int line(const std::string& key) const;

  bool has(const std::string& key) const;
  /// The name under which a value stands that was called `former` once: `key`, unless there is only `former`.
  /// @throws InputError if both are there.
  std::string renamed(const std::string& key, const std::string& former) const;
  /// In the order of the file.
  std::vector<std::string> keys() const;
  /// @throws InputError for the first key that is not in `known`, naming the nearest. Of a root table whose key is
  /// one of another kind of file, it says of which.
  void expect_keys(const std::vector<std::string>& known) const;

  bool is_string(const std::string& key) const;
  bool is_boolean(const std::string& key) const;
  bool is_integer(const std::string& key) const;
  /// An integer or a float.
  bool is_number(const std::string& key) const;
  bool is_array(const std::string& key) const;
  bool is_table(const std::string& key) const;

  std::string string(const std::string& key) const;
  bool boolean(const std::string& key) const;
  /// Floats are refused, also whole ones.
  std::int64_t integer(const std::string& key) const;
  /// Finite, and 0 or of a size to calculate with (base/limits.h), as all that follow: others are refused.
  double number(const std::string& key) const;
  /// A number, taken to be in SI, or a string with a unit of the dimension of `unit`; the value in SI.
  double quantity(const std::string& key, std::string_view unit) const;
  /// The same of an error, a deviation, a tolerance: see difference_to_si().
  double difference(const std::string& key, std::string_view unit) const;
  /// A quantity, or a difference, that is more than 0. @throws InputError for another
  double positive(const std::string& key, std::string_view unit) const;
  double positive_difference(const std::string& key, std::string_view unit) const;
  std::vector<std::string> strings(const std::string& key) const;
  /// An array of arrays of strings.
  std::vector<std::vector<std::string>> string_lists(const std::string& key) const;
  std::vector<double> numbers(const std::string& key) const;
  std::vector<double> quantities(const std::string& key, std::string_view unit) const;
  TomlTable table(const std::string& key) const;
  /// An array of tables, `[[...]]` or inline.
  std::vector<TomlTable> tables(const std::string& key) const;

  std::optional<std::string> optional_string(const std::string& key) const;
  /// One of `known`, the first where the key is missing. @throws InputError for another, naming the nearest
  std::string choice(const std::string& key, const std::vector<std::string>& known) const;
  std::optional<bool> optional_boolean(const std::string& key) const;
  std::optional<std::int64_t> optional_integer(const std::string& key) const;
  std::optional<double> optional_number(const std::string& key) const;
  std::optional<double> optional_quantity(const std::string& key, std::string_view unit) const;
  std::optional<double> optional_positive(const std::string& key, std::string_view unit) const;
  std::optional<std::vector<std::string>> optional_strings(const std::string& key) const;
  std::optional<std::vector<double>> optional_numbers(const std::string& key) const;
  std::optional<std::vector<double>> optional_quantities(const std::string& key, std::string_view unit) const;
  std::optional<TomlTable> optional_table(const std::string& key) const;
  std::optional<std::vector<TomlTable>> optional_tables(const std::string& key) const;

  /// An error located at the key, for the caller to throw. The key need not exist: then the table is named.
  InputError error(const std::string& key, const std::string& sentence) const;

 private:
  struct Node;
  explicit TomlTable(std::shared_ptr<const Node> node) : node_(std::move(node)) {}

  std::shared_ptr<const Node> node_;
};

}  // namespace samara::io
