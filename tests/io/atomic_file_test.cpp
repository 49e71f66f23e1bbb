#include "samara/io/atomic_file.h"

#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <unistd.h>

#include "../error_text.h"
#include "samara/base/text.h"
#include "samara/io/descriptor.h"
#include "temporary_directory.h"

using Catch::Matchers::Contains;
using samara::ArgumentError;
using samara::io::PendingFile;
using samara::io::require_name_of_format;
using samara::io::write_text_atomically;

namespace fs = std::filesystem;

TEST_CASE("a text written is the text in the file, and nothing else is left") {
  const TemporaryDirectory directory;
  const std::string text("a\r\n\0b", 5);
  write_text_atomically(directory / "f", "older and longer");
  write_text_atomically(directory / "f", text);
  CHECK(content(directory / "f") == text);
  CHECK(directory.file_count() == 1);
}

TEST_CASE("a pending file has its final name only after the commit") {
  const TemporaryDirectory directory;
  PendingFile pending(directory / "f");
  CHECK(pending.path().parent_path() == directory.path());
  CHECK(pending.final_path() == directory / "f");
  put_content(pending.path(), "new");
  CHECK_FALSE(fs::exists(directory / "f"));
  pending.commit();
  CHECK(content(directory / "f") == "new");
  CHECK(directory.file_count() == 1);
  CHECK_THAT(error_text<ArgumentError>([&] { pending.commit(); }), Contains("committed before"));
}

TEST_CASE("a pending file that is not committed leaves the old content") {
  const TemporaryDirectory directory;
  put_content(directory / "f", "old");
  {
    PendingFile pending(directory / "f");
    put_content(pending.path(), "new");
    const PendingFile moved = std::move(pending);
    CHECK(directory.file_count() == 2);
  }
  CHECK(content(directory / "f") == "old");
  CHECK(directory.file_count() == 1);
}

TEST_CASE("assigning to a pending file discards what it held") {
  const TemporaryDirectory directory;
  PendingFile pending(directory / "f");
  pending = PendingFile(directory / "g");
  CHECK(directory.file_count() == 1);
  pending.commit();
  CHECK(fs::exists(directory / "g"));
}

TEST_CASE("a symbolic link stays, and the file behind it is replaced") {
  const TemporaryDirectory directory;
  put_content(directory / "f", "old");
  fs::create_symlink(directory / "f", directory / "link");
  write_text_atomically(directory / "link", "new");
  CHECK(fs::is_symlink(directory / "link"));
  CHECK(content(directory / "f") == "new");
}

TEST_CASE("a symbolic link to a file that does not exist yet stays, and the file is created") {
  const TemporaryDirectory directory;
  fs::create_directory(directory / "far");
  fs::create_symlink("far/away", directory / "second");  // relative to where the link stands
  fs::create_symlink(directory / "second", directory / "first");
  write_text_atomically(directory / "first", "new");
  CHECK(fs::is_symlink(directory / "first"));
  CHECK(fs::is_symlink(directory / "second"));
  CHECK(content(directory / "far" / "away") == "new");
}

TEST_CASE("symbolic links that lead round in a circle, or into nothing, are refused") {
  const TemporaryDirectory directory;
  fs::create_symlink("b", directory / "a");
  fs::create_symlink("a", directory / "b");
  fs::create_symlink("none/f", directory / "lost");
  const auto error = [&](const char* name) {
    return error_text<ArgumentError>([&] { write_text_atomically(directory / name, "x"); });
  };
  CHECK_THAT(error("a"), Contains("cannot write") && Contains("/a\""));
  CHECK_THAT(error("lost"), Contains("lost\"") && Contains("does not exist"));
  CHECK(fs::is_symlink(directory / "a"));
}

TEST_CASE("a file that is replaced keeps its permissions") {
  const TemporaryDirectory directory;
  put_content(directory / "f", "old");
  fs::permissions(directory / "f", fs::perms::owner_read | fs::perms::owner_write);
  write_text_atomically(directory / "f", "new");
  CHECK(fs::status(directory / "f").permissions() == (fs::perms::owner_read | fs::perms::owner_write));
}

TEST_CASE("a file that may only be read is replaced, and may only be read again") {
  const TemporaryDirectory directory;
  put_content(directory / "f", "old");
  fs::permissions(directory / "f", fs::perms::owner_read);
  PendingFile pending(directory / "f");
  // What is yet to be written is written by its owner.
  CHECK((fs::status(pending.path()).permissions() & fs::perms::owner_write) != fs::perms::none);
  pending.write("new");
  pending.commit();
  CHECK(content(directory / "f") == "new");
  CHECK(fs::status(directory / "f").permissions() == fs::perms::owner_read);
}

TEST_CASE("a new file gets the permissions of the process") {
  const TemporaryDirectory directory;
  put_content(directory / "usual", "");
  write_text_atomically(directory / "f", "");
  CHECK(fs::status(directory / "f").permissions() == fs::status(directory / "usual").permissions());
}

TEST_CASE("a file with the longest possible name can be written") {
  const TemporaryDirectory directory;
  const std::string name(255, 'n');
  write_text_atomically(directory / name, "x");
  CHECK(content(directory / name) == "x");
}

TEST_CASE("a device is written directly and stays a device") {
  write_text_atomically("/dev/null", "x");
  CHECK(fs::is_character_file("/dev/null"));
  CHECK_THAT(error_text<ArgumentError>([] { write_text_atomically("/dev/full", "x"); }),
             Contains("cannot write \"/dev/full\"") && Contains("No space"));
}

TEST_CASE("a file that a descriptor named leads to keeps what stands in it") {
  const TemporaryDirectory directory;
  put_content(directory / "log", "header\n");
  const samara::io::Descriptor log(::open((directory / "log").c_str(), O_WRONLY | O_APPEND));
  const samara::io::Descriptor input(::open((directory / "log").c_str(), O_RDONLY));
  const fs::path name = "/dev/fd/" + std::to_string(log.get());
  CHECK_NOTHROW(samara::io::require_writable(name));
  write_text_atomically(name, "answer\n");
  REQUIRE(::write(log.get(), "footer\n", 7) == 7);
  CHECK(content(directory / "log") == "header\nanswer\nfooter\n");
  CHECK_THAT(error_text<ArgumentError>([&] { PendingFile pending(name); }), Contains("a file of its own"));
  const fs::path read_only = "/dev/fd/" + std::to_string(input.get());
  CHECK_THAT(error_text<ArgumentError>([&] { write_text_atomically(read_only, "x"); }),
             Contains("reading only"));
  CHECK_THAT(error_text<ArgumentError>([&] { samara::io::require_writable(read_only); }),
             Contains("reading only"));
  CHECK(directory.file_count() == 1);
}

TEST_CASE("a path that cannot be written is refused with path and reason") {
  const TemporaryDirectory directory;
  put_content(directory / "file", "");
  const auto error = [](const fs::path& path) {
    return error_text<ArgumentError>([&] { write_text_atomically(path, "x"); });
  };
  CHECK_THAT(error(directory / "none/f"), Contains("none/f\"") && Contains("does not exist"));
  CHECK_THAT(error(directory.path()), Contains("it is a directory"));
  CHECK_THAT(error(directory / "file/f"), Contains("file/f\""));
  CHECK_THAT(error(""), Contains("names no file"));
  CHECK_THAT(error(directory / std::string(256, 'n')), Contains("cannot write") && Contains("name too long"));
  CHECK_THAT(error(directory / std::string(256, 'n') / "f"), Contains("cannot write"));
  CHECK_THAT(error_text<ArgumentError>([] { PendingFile pending("/dev/null"); }),
             Contains("not a regular file"));
}

TEST_CASE("a name with the ending of another format is refused, and one with an unknown ending is not") {
  const std::vector<std::pair<std::string, std::string>> formats = {
      {".h5", "HDF5"}, {".csv", "CSV"}, {".json", "JSON"}, {".toml", "TOML"}, {".txt", "text"}};
  for (const auto& [ending, format] : formats) {
    for (const std::string name : {"fall", "run_0.2", "fall.dat", "fall.book"})
      CHECK_NOTHROW(require_name_of_format(name, ending));
    for (const std::string other : {".h5", ".csv", ".JSON", ".toml", ".tsv", ".glb", ".obj", ".stl", ".ply",
                                    ".fbx", ".gltf", ".svg", ".html"}) {
      const std::string name = "fall" + other;
      INFO(name << " of " << format);
      if (samara::lower_case(other) == ending) {
        CHECK_NOTHROW(require_name_of_format(name, ending));
      } else {
        CHECK_THROWS_WITH(require_name_of_format(name, ending),
                          "the output is \"" + name + "\", but " + format +
                              " is written; a name that ends in " + ending + " was expected");
      }
    }
  }
  CHECK_NOTHROW(require_name_of_format("fall.hdf5", ".h5"));
  CHECK_NOTHROW(require_name_of_format("fall.txt", ".csv"));
  CHECK_THROWS_AS(require_name_of_format("fall.txt", ".h5"), ArgumentError);
}

TEST_CASE("a directory without write permission is refused") {
  if (::geteuid() == 0) return;  // root may write everywhere
  const TemporaryDirectory directory;
  fs::permissions(directory.path(), fs::perms::owner_read | fs::perms::owner_exec);
  const std::string error = error_text<ArgumentError>([&] { write_text_atomically(directory / "f", "x"); });
  fs::permissions(directory.path(), fs::perms::owner_all);
  CHECK_THAT(error, Contains("Permission denied"));
}
