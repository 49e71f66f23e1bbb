#pragma once

#include <cstddef>
#include <string>

/// Text that is read by people, in lines that fit.
namespace samara::apps {

/// Columns of lines where nobody says how many, and of files.
inline constexpr std::size_t kUsualWidth = 110;

/// Columns of the terminal, or what COLUMNS says, or the usual ones.
std::size_t screen_width();

/// Words of `text` in lines of at most `width`, all but the first after `indent` spaces. A word
/// that is longer has a line of its own.
/// @param column at which the first begins
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width, std::size_t column);

/// Every line of `text` that is longer than `width` goes on below, further in than it begins. Others stay as they are.
std::string wrapped_lines(const std::string& text, std::size_t width = screen_width());

/// The same of sentences. Rows of a table, which have two blanks side by side, stay whole where they fit. A table of
/// rows with as many cells each that is too wide is parted between columns: each part has the first ones, as many as
/// tell the rows apart. It stays whole where there is no room for these.
std::string wrapped_prose(const std::string& text, std::size_t width = screen_width());

}  // namespace samara::apps
