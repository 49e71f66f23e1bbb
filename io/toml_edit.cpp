#include "samara/io/toml_edit.h"

#include <algorithm>
#include <cctype>
#include <optional>

#include <toml++/toml.h>

#include "samara/base/errors.h"
#include "samara/base/text.h"

namespace samara::io {

namespace {

/// Offsets of bytes.
struct Span {
  std::size_t begin = 0, end = 0;
};

/// Columns of the parser are characters, not bytes.
std::size_t offset_of(const std::string& text, const toml::source_position& position) {
  std::size_t at = 0;
  for (toml::source_index line = 1; line < position.line; ++line)
    at = std::min(text.find('\n', at), text.size() - 1) + 1;
  for (toml::source_index column = 1; column < position.column && at < text.size(); ++column) {
    ++at;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U) ++at;
  }
  return at;
}

std::size_t line_begin(const std::string& text, std::size_t at) {
  const std::size_t before = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
  return before == std::string::npos ? 0 : before + 1;
}

std::size_t line_end(const std::string& text, std::size_t at) {
  const std::size_t end = text.find('\n', at);
  return end == std::string::npos ? text.size() : end + 1;
}

[[noreturn]] void refuse(const TomlChange& change) {
  throw ArgumentError(
      in_quotes(change.key) + " in [" + change.table +
      "] does not stand on a line of its own, where it could be changed: the file itself is to be edited");
}

/// The lines of `key = value`, nothing else on them but a comment.
Span lines_of(const std::string& text, const toml::key& key, const toml::node& value,
              const TomlChange& change) {
  const std::size_t key_at = offset_of(text, key.source().begin),
                    value_end = offset_of(text, value.source().end);
  const Span lines{line_begin(text, key_at), line_end(text, value_end)};
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  const std::string_view all = text;
  if (!std::ranges::all_of(all.substr(lines.begin, key_at - lines.begin), is_blank)) refuse(change);
  const std::string_view rest = trimmed(all.substr(value_end, lines.end - value_end));
  if (!rest.empty() && rest.front() != '#' && rest.front() != '\n' && rest.front() != '\r') refuse(change);
  return lines;
}

/// Whether the line is the head of the table itself, and not of one in it, as [box.C_D] is of [box].
bool is_head_of(const std::string& line, const std::string& table) {
  const toml::table root = toml::parse(line);
  const toml::table* own = root[table].as_table();
  return own != nullptr && own->empty();
}

std::string changed_once(const std::string& text, const std::string& name, const TomlChange& change) {
  toml::table root;
  try {
    root = toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    throw InputError(name, static_cast<int>(error.source().begin.line), std::string(error.description()));
  }
  const std::string line = toml_key(change.key) + " = " + change.value + "\n";
  const toml::node* node = root.get(change.table);
  if (node == nullptr) {
    if (change.value.empty()) return text;
    const std::string gap = text.empty() || text.ends_with('\n') ? "\n" : "\n\n";
    return text + gap + "[" + toml_key(change.table) + "]\n" + line;
  }
  const toml::table* table = node->as_table();
  if (table == nullptr || table->is_inline()) refuse(change);
  for (auto&& [key, value] : *table) {
    if (key.str() != change.key) continue;
    const Span lines = lines_of(text, key, value, change);
    if (change.value.empty()) return text.substr(0, lines.begin) + text.substr(lines.end);
    const Span old{offset_of(text, value.source().begin), offset_of(text, value.source().end)};
    return text.substr(0, old.begin) + change.value + text.substr(old.end);
  }
  if (change.value.empty()) return text;
  // Behind the head of the table, which is where its source begins.
  const std::size_t head = offset_of(text, table->source().begin);
  if (head >= text.size() || text[head] != '[') refuse(change);
  const std::size_t behind = line_end(text, head);
  if (!is_head_of(text.substr(head, behind - head), change.table)) {
    const std::size_t before = line_begin(text, head);
    return text.substr(0, before) + "[" + toml_key(change.table) + "]\n" + line + "\n" + text.substr(before);
  }
  const std::string gap = text[behind - 1] == '\n' ? "" : "\n";
  return text.substr(0, behind) + gap + line + text.substr(behind);
}

}  // namespace

std::string toml_key(const std::string& key) {
  const auto is_bare = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  };
  return !key.empty() && std::ranges::all_of(key, is_bare) ? key : "\"" + key + "\"";
}

std::string changed_toml(const std::string& text, const std::string& name,
                         const std::vector<TomlChange>& changes) {
  std::string changed = text;
  for (const TomlChange& change : changes) changed = changed_once(changed, name, change);
  return changed;
}

}  // namespace samara::io
