#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

/// Pictures as PNG files (ISO/IEC 15948): 8 bits of red, green and blue, deflated by zlib.
namespace samara::io {

using Colour = std::array<std::uint8_t, 3>;

/// An image, rows from the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<Colour> pixels;

  /// @throws ArgumentError if a side is not between 1 and 20,000
  Picture(int width, int height, Colour background);

  /// Nothing happens outside.
  void set(int x, int y, Colour colour);
  /// A straight line, one pixel wide.
  void draw_line(double x0, double y0, double x1, double y1, Colour colour);
  /// Text of digits, letters and the signs of numbers and units, in a face of 5 x 7 dots; others are left blank.
  /// @param x, y of its upper left corner @param scale pixels to a dot
  void write_text(int x, int y, const std::string& text, Colour colour, int scale = 2);
  static int text_width(const std::string& text, int scale = 2) {
    return static_cast<int>(text.size()) * 6 * scale;
  }
};

/// The bytes of the file.
std::string format_png(const Picture& image);

}  // namespace samara::io
