#include "samara/io/file_lock.h"

#include <fstream>
#include <string>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "temporary_directory.h"

using namespace samara;
using namespace samara::io;
using Catch::Matchers::Contains;

TEST_CASE("a lock is held once at a time, and is free again afterwards") {
  const TemporaryDirectory folder;
  const auto path = folder / "book.h5.lock";
  {
    const FileLock held(path, "builds book.h5");
    const std::string refused = error_text<ArgumentError>([&] { FileLock(path, "builds book.h5"); });
    CHECK_THAT(refused, Contains("builds book.h5 already") && Contains("book.h5.lock is its lock"));
    CHECK(std::filesystem::exists(path));
  }
  CHECK_FALSE(std::filesystem::exists(path));
  CHECK_NOTHROW(FileLock(path, "builds book.h5"));
}

TEST_CASE("a lock that a killed process has left is taken over") {
  const TemporaryDirectory folder;
  const auto path = folder / "left.lock";
  std::ofstream(path) << "123456";
  CHECK_NOTHROW(FileLock(path, "builds it"));
}

TEST_CASE("where the file of a lock cannot be made there is none") {
  const TemporaryDirectory folder;
  CHECK_NOTHROW(FileLock(folder / std::string(300, 'n'), "builds it"));
  CHECK_NOTHROW(FileLock(folder / "no folder/lock", "builds it"));
}

TEST_CASE("a file that is no lock is left as it is") {
  const TemporaryDirectory folder;
  const auto path = folder / "Cargo.lock";
  for (const std::string& text : {std::string("version = 3\n"), std::string(100, '1')}) {
    put_content(path, text);
    CHECK_THAT(error_text<ArgumentError>([&] { FileLock(path, "builds Cargo"); }),
               Contains("Cargo.lock\" is in the way: it is no lock of samara"));
    CHECK(content(path) == text);
  }
}
