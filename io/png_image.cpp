#include "samara/io/png_image.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <string_view>

#include <zlib.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"

namespace samara::io {

namespace {

/// Rows of five dots from the top, the leftmost in the highest of five bits.
using Glyph = std::array<std::uint8_t, 7>;

const std::map<char, Glyph>& glyphs() {
  static const std::map<char, Glyph> kGlyphs = {
      {'0', {14, 17, 19, 21, 25, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},
      {'2', {14, 17, 1, 2, 4, 8, 31}},     {'3', {31, 2, 4, 2, 1, 17, 14}},
      {'4', {2, 6, 10, 18, 31, 2, 2}},     {'5', {31, 16, 30, 1, 1, 17, 14}},
      {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},
      {'8', {14, 17, 17, 14, 17, 17, 14}}, {'9', {14, 17, 17, 15, 1, 2, 12}},
      {'-', {0, 0, 0, 31, 0, 0, 0}},       {'+', {0, 4, 4, 31, 4, 4, 0}},
      {'.', {0, 0, 0, 0, 0, 12, 12}},      {',', {0, 0, 0, 0, 12, 4, 8}},
      {'/', {1, 1, 2, 4, 8, 16, 16}},      {'^', {4, 10, 17, 0, 0, 0, 0}},
      {'(', {2, 4, 8, 8, 8, 4, 2}},        {')', {8, 4, 2, 2, 2, 4, 8}},
      {'[', {14, 8, 8, 8, 8, 8, 14}},      {']', {14, 2, 2, 2, 2, 2, 14}},
      {'=', {0, 0, 31, 0, 31, 0, 0}},      {':', {0, 12, 12, 0, 12, 12, 0}},
      {'%', {24, 25, 2, 4, 8, 19, 3}},     {'_', {0, 0, 0, 0, 0, 0, 31}},
      {'a', {0, 0, 14, 1, 15, 17, 15}},    {'b', {16, 16, 22, 25, 17, 17, 30}},
      {'c', {0, 0, 14, 16, 16, 17, 14}},   {'d', {1, 1, 13, 19, 17, 17, 15}},
      {'e', {0, 0, 14, 17, 31, 16, 14}},   {'f', {6, 9, 8, 28, 8, 8, 8}},
      {'g', {0, 15, 17, 17, 15, 1, 14}},   {'h', {16, 16, 22, 25, 17, 17, 17}},
      {'i', {4, 0, 12, 4, 4, 4, 14}},      {'j', {2, 0, 6, 2, 2, 18, 12}},
      {'k', {16, 16, 18, 20, 24, 20, 18}}, {'l', {12, 4, 4, 4, 4, 4, 14}},
      {'m', {0, 0, 26, 21, 21, 17, 17}},   {'n', {0, 0, 22, 25, 17, 17, 17}},
      {'o', {0, 0, 14, 17, 17, 17, 14}},   {'p', {0, 0, 30, 17, 30, 16, 16}},
      {'q', {0, 0, 13, 19, 15, 1, 1}},     {'r', {0, 0, 22, 25, 16, 16, 16}},
      {'s', {0, 0, 14, 16, 14, 1, 30}},    {'t', {8, 8, 28, 8, 8, 9, 6}},
      {'u', {0, 0, 17, 17, 17, 19, 13}},   {'v', {0, 0, 17, 17, 17, 10, 4}},
      {'w', {0, 0, 17, 17, 21, 21, 10}},   {'x', {0, 0, 17, 10, 4, 10, 17}},
      {'y', {0, 0, 17, 17, 15, 1, 14}},    {'z', {0, 0, 31, 2, 4, 8, 31}},
      {'U', {17, 17, 17, 17, 17, 17, 14}}, {'R', {30, 17, 17, 30, 20, 18, 17}},
      {'C', {14, 17, 16, 16, 16, 17, 14}}, {'D', {28, 18, 17, 17, 17, 18, 28}},
      {'S', {15, 16, 16, 14, 1, 1, 30}},   {'L', {16, 16, 16, 16, 16, 16, 31}},
      {'M', {17, 27, 21, 21, 17, 17, 17}}, {'A', {14, 17, 17, 31, 17, 17, 17}},
      {'B', {30, 17, 17, 30, 17, 17, 30}}, {'E', {31, 16, 16, 30, 16, 16, 31}},
      {'F', {31, 16, 16, 30, 16, 16, 16}}, {'G', {14, 17, 16, 23, 17, 17, 15}},
      {'H', {17, 17, 17, 31, 17, 17, 17}}, {'I', {14, 4, 4, 4, 4, 4, 14}},
      {'J', {7, 2, 2, 2, 2, 18, 12}},      {'K', {17, 18, 20, 24, 20, 18, 17}},
      {'N', {17, 17, 25, 21, 19, 17, 17}}, {'O', {14, 17, 17, 17, 17, 17, 14}},
      {'P', {30, 17, 17, 30, 16, 16, 16}}, {'Q', {14, 17, 17, 17, 21, 18, 13}},
      {'T', {31, 4, 4, 4, 4, 4, 4}},       {'V', {17, 17, 17, 17, 17, 10, 4}},
      {'W', {17, 17, 17, 21, 21, 21, 10}}, {'X', {17, 17, 10, 4, 10, 17, 17}},
      {'Y', {17, 17, 17, 10, 4, 4, 4}},    {'Z', {31, 1, 2, 4, 8, 16, 31}}};
  return kGlyphs;
}

void append_number(std::string& bytes, std::uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>((number >> shift) & 0xFFu);
}

/// Length, kind, content and checksum of kind and content.
void append_chunk(std::string& bytes, std::string_view kind, std::string_view content) {
  append_number(bytes, static_cast<std::uint32_t>(content.size()));
  const std::size_t start = bytes.size();
  bytes += kind;
  bytes += content;
  const auto* const checked = reinterpret_cast<const Bytef*>(bytes.data() + start);
  append_number(bytes,
                static_cast<std::uint32_t>(crc32(0, checked, static_cast<uInt>(bytes.size() - start))));
}

}  // namespace

Picture::Picture(int width_, int height_, Colour background) : width(width_), height(height_) {
  constexpr int kLargest = 20'000;
  require(width >= 1 && width <= kLargest, "width", width, "1 to 20000 pixels", "Picture");
  require(height >= 1 && height <= kLargest, "height", height, "1 to 20000 pixels", "Picture");
  pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), background);
}

void Picture::set(int x, int y, Colour colour) {
  if (x < 0 || y < 0 || x >= width || y >= height) return;
  pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
      colour;
}

void Picture::draw_line(double x0, double y0, double x1, double y1, Colour colour) {
  const int steps = std::max(1, static_cast<int>(std::ceil(std::max(std::abs(x1 - x0), std::abs(y1 - y0)))));
  for (int s = 0; s <= steps; ++s) {
    const double along = static_cast<double>(s) / steps;
    set(static_cast<int>(std::lround(x0 + along * (x1 - x0))),
        static_cast<int>(std::lround(y0 + along * (y1 - y0))), colour);
  }
}

void Picture::write_text(int x, int y, const std::string& text, Colour colour, int scale) {
  for (const char letter : text) {
    const auto glyph = glyphs().find(letter);
    for (int row = 0; glyph != glyphs().end() && row < 7; ++row) {
      for (int column = 0; column < 5; ++column) {
        if ((glyph->second[static_cast<std::size_t>(row)] >> (4 - column) & 1) == 0) continue;
        for (int dot = 0; dot < scale * scale; ++dot)
          set(x + scale * column + dot % scale, y + scale * row + dot / scale, colour);
      }
    }
    x += 6 * scale;
  }
}

std::string format_png(const Picture& image) {
  std::string header;
  append_number(header, static_cast<std::uint32_t>(image.width));
  append_number(header, static_cast<std::uint32_t>(image.height));
  header += {8, 2, 0, 0, 0};  // 8 bits, colours, deflate, filters by row, not interlaced
  std::string rows;
  rows.reserve(image.pixels.size() * 3 + static_cast<std::size_t>(image.height));
  for (std::size_t p = 0; p < image.pixels.size(); ++p) {
    if (p % static_cast<std::size_t>(image.width) == 0) rows += '\0';  // no filter
    for (const std::uint8_t part : image.pixels[p]) rows += static_cast<char>(part);
  }
  uLongf size = compressBound(static_cast<uLong>(rows.size()));
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
                static_cast<uLong>(rows.size()), 6) != Z_OK)
    throw NoResultError("the picture could not be compressed");
  packed.resize(size);
  std::string bytes = "\x89PNG\r\n\x1a\n";
  append_chunk(bytes, "IHDR", header);
  append_chunk(bytes, "IDAT", packed);
  append_chunk(bytes, "IEND", "");
  return bytes;
}

}  // namespace samara::io
