#include "samara/io/text_file.h"

#include <future>

#include <catch2/catch.hpp>
#include <sys/stat.h>

#include "../error_text.h"
#include "temporary_directory.h"

using Catch::Matchers::Contains;
using samara::InputError;
using samara::io::read_text_file;

TEST_CASE("a text is read as it stands in the file") {
  const TemporaryDirectory directory;
  const std::string text = std::string("a\r\n\0b", 5) + std::string(200'000, 'x');
  put_content(directory / "f", text);
  CHECK(read_text_file(directory / "f") == text);
  put_content(directory / "empty", "");
  CHECK(read_text_file(directory / "empty").empty());
}

TEST_CASE("what is no readable file is refused with its path and the reason") {
  const TemporaryDirectory directory;
  const auto error = [](const std::filesystem::path& path) {
    return error_text<InputError>([&] { read_text_file(path); });
  };
  CHECK_THAT(error(directory / "none"), Contains("none: the file does not exist"));
  CHECK_THAT(error(""), Contains("does not exist"));
  CHECK_THAT(error(directory.path()), Contains("is a directory"));
  CHECK_THAT(error(directory / std::string(256, 'n')), Contains("cannot be opened: File name too long"));
}

TEST_CASE("what is no text is named by what it is, and by what was expected") {
  const TemporaryDirectory directory;
  const auto error = [&](const std::string& content) {
    put_content(directory / "f", content);
    return error_text<InputError>([&] { read_text_file(directory / "f", {.expected = "a plan"}); });
  };
  CHECK_THAT(error("\x89HDF\r\n\x1a\n and more"),
             Contains("f: is an HDF5 file, such as a codebook (samara info shows it), expected a plan"));
  CHECK_THAT(error("\x89PNG\r\n\x1a\n"), Contains("f: is a PNG picture, expected a plan"));
  CHECK_THAT(error("PK\x03\x04"), Contains("f: is an archive (zip, npz), expected a plan"));
  CHECK(read_text_file(directory / "f") == "PK\x03\x04");  // whoever says nothing takes any bytes
  put_content(directory / "f", "PK, a text that begins so");
  CHECK(read_text_file(directory / "f").starts_with("PK,"));
}

TEST_CASE("a file that never ends is refused at the limit") {
  CHECK_THAT(error_text<InputError>([] { read_text_file("/dev/zero"); }),
             Contains("/dev/zero: holds more than 256 MB"));
  const TemporaryDirectory directory;
  put_content(directory / "f", "12345");
  CHECK(read_text_file(directory / "f", {.bytes = 5}) == "12345");
  CHECK_THAT(error_text<InputError>([&] { read_text_file(directory / "f", {.bytes = 4}); }),
             Contains("f: holds more than 4 bytes"));
}

TEST_CASE("a pipe is read to its end, however late its writer comes") {
  const TemporaryDirectory directory;
  REQUIRE(::mkfifo((directory / "pipe").c_str(), 0600) == 0);
  const std::string text(100'000, 'x');  // more than a pipe holds at once
  auto reader = std::async(std::launch::async, [&] { return read_text_file(directory / "pipe"); });
  put_content(directory / "pipe", text);
  CHECK(reader.get() == text);
}

TEST_CASE("a pipe that nobody writes to is refused") {
  const TemporaryDirectory directory;
  REQUIRE(::mkfifo((directory / "pipe").c_str(), 0600) == 0);
  CHECK_THAT(error_text<InputError>([&] { read_text_file(directory / "pipe", {.silence = 0.05}); }),
             Contains("pipe: gave nothing to read for 0.05 s"));
}
