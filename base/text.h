#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

/// Locale-independent reading and writing of text; internal to Samara.
namespace samara {

enum class NumberProblem {
  none,
  malformed,     ///< no number stands there
  not_finite,    ///< the words nan or inf, which std::from_chars would take
  out_of_range,  ///< too large for a double
};

/// A number at the beginning of a text.
struct NumberPrefix {
  double value = 0.0;
  std::size_t length = 0;  ///< bytes that belong to the number
  NumberProblem problem = NumberProblem::none;
};

/// Reads a decimal number (`1`, `+1.5`, `-2e-3`) from the beginning of `text`.
NumberPrefix read_number(std::string_view text);

/// Without blanks and tabs at both ends.
std::string_view trimmed(std::string_view text);

/// Of ASCII letters only.
std::string lower_case(std::string_view text);

/// What the name of a file ends in, ".csv" or ".h5", also where it is written in capitals; empty if there is none.
std::string ending_of(const std::filesystem::path& file);

/// The text in double quotes for a message: cut when it is long, control characters as \x0a.
std::string in_quotes(std::string_view text);

/// For the texts and attributes of HTML and XML.
std::string escaped_for_markup(std::string_view text);

}  // namespace samara
