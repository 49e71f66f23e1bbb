// PNG files: what stands in them, read back by zlib and a checksum of our own.
#include "samara/io/png_image.h"

#include <algorithm>
#include <set>

#include <catch2/catch.hpp>
#include <zlib.h>

#include "samara/base/errors.h"

using namespace samara::io;

namespace {

constexpr Colour kWhite = {255, 255, 255}, kRed = {200, 10, 20};

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
  return value;
}

/// The polynomial of ISO/IEC 15948, annex D, bit by bit.
std::uint32_t checksum(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffU;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? 0xedb88320U ^ (crc >> 1) : crc >> 1;
  }
  return ~crc;
}

/// Width, height and pixels of a file of 8 bits a colour, without filters.
Picture read_back(const std::string& file) {
  REQUIRE(file.substr(0, 8) == "\x89PNG\r\n\x1a\n");
  std::size_t at = 8, width = 0, height = 0;
  std::string packed, last;
  while (at < file.size()) {
    const std::size_t size = big_endian(file, at);
    last = file.substr(at + 4, 4);
    const std::string content = file.substr(at + 8, size);
    CHECK(big_endian(file, at + 8 + size) == checksum(last + content));
    if (last == "IHDR") {
      width = big_endian(content, 0);
      height = big_endian(content, 4);
      CHECK(content.substr(8) == std::string("\x08\x02\x00\x00\x00", 5));
    }
    if (last == "IDAT") packed += content;
    at += 12 + size;
  }
  CHECK(last == "IEND");
  std::string rows(height * (1 + 3 * width), '\0');
  uLongf count = rows.size();
  REQUIRE(uncompress(reinterpret_cast<Bytef*>(rows.data()), &count,
                     reinterpret_cast<const Bytef*>(packed.data()), packed.size()) == Z_OK);
  REQUIRE(count == rows.size());
  Picture picture(static_cast<int>(width), static_cast<int>(height), kWhite);
  for (std::size_t y = 0; y < height; ++y) {
    const std::size_t row = y * (1 + 3 * width);
    CHECK(rows[row] == 0);
    for (std::size_t x = 0; x < width; ++x) {
      for (std::size_t c = 0; c < 3; ++c)
        picture.pixels[y * width + x][c] = static_cast<std::uint8_t>(rows[row + 1 + 3 * x + c]);
    }
  }
  return picture;
}

}  // namespace

TEST_CASE("a picture is read back from its file pixel by pixel") {
  Picture picture(37, 11, kWhite);
  picture.set(3, 4, kRed);
  picture.set(-1, 4, kRed);  // outside: nothing
  picture.set(37, 4, kRed);
  picture.draw_line(30.0, 0.0, 30.0, 10.0, {0, 128, 255});
  const Picture again = read_back(format_png(picture));
  CHECK(again.width == 37);
  CHECK(again.height == 11);
  CHECK(again.pixels == picture.pixels);
  CHECK(again.pixels[4 * 37 + 3] == kRed);
  CHECK(std::count(again.pixels.begin(), again.pixels.end(), kRed) == 1);
  for (std::size_t y = 0; y < 11; ++y) CHECK(again.pixels[y * 37 + 30] == Colour{0, 128, 255});
}

TEST_CASE("lines go from end to end, and letters stand where they are put") {
  Picture picture(20, 20, kWhite);
  picture.draw_line(2.0, 3.0, 17.0, 10.0, kRed);
  const auto is_red = [&](int x, int y) {
    return picture.pixels[static_cast<std::size_t>(y * 20 + x)] == kRed;
  };
  CHECK(is_red(2, 3));
  CHECK(is_red(17, 10));
  // One pixel in each column, none beyond its ends.
  for (int x = 0; x < 20; ++x) {
    int reds = 0;
    for (int y = 0; y < 20; ++y) reds += is_red(x, y);
    CHECK(reds == (x >= 2 && x <= 17 ? 1 : 0));
  }
  Picture text(40, 30, kWhite);
  text.write_text(4, 6, "I", kRed, 2);
  int left = 40, right = -1, top = 30, bottom = -1;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      if (text.pixels[static_cast<std::size_t>(y * 40 + x)] != kRed) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  CHECK(left >= 4);
  CHECK(right < 4 + Picture::text_width("I", 2));
  CHECK(top == 6);
  CHECK(bottom == 6 + 2 * 7 - 1);
  // No letter and no digit is a blank, and no two are alike.
  std::set<std::vector<Colour>> shapes;
  const std::string all = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
  for (const char letter : all) {
    Picture one(6, 7, kWhite);
    one.write_text(0, 0, std::string(1, letter), kRed, 1);
    CHECK(std::find(one.pixels.begin(), one.pixels.end(), kRed) != one.pixels.end());
    shapes.insert(one.pixels);
  }
  CHECK(shapes.size() == all.size());
}

TEST_CASE("pictures of no size, or too large a one, are refused") {
  CHECK_THROWS_AS(Picture(0, 5, kWhite), samara::ArgumentError);
  CHECK_THROWS_AS(Picture(5, 20001, kWhite), samara::ArgumentError);
}
