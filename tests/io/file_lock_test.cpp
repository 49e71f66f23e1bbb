#include "samara/io/file_lock.h"

#include <filesystem>
#include <string>

#include <catch2/catch.hpp>
#include <unistd.h>

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

TEST_CASE("a lock that a killed process has left is taken over, and names who holds it now") {
  const TemporaryDirectory folder;
  const auto path = folder / "left.lock";
  put_content(path, "12345678901234567890");
  {
    const FileLock held(path, "builds it");
    CHECK(content(path) == std::to_string(::getpid()));
  }
  CHECK_FALSE(std::filesystem::exists(path));
}

TEST_CASE("where the file of a lock cannot be made there is none") {
  const TemporaryDirectory folder;
  CHECK_NOTHROW(FileLock(folder / std::string(300, 'n'), "builds it"));
  CHECK_NOTHROW(FileLock(folder / "no folder/lock", "builds it"));
}

TEST_CASE("a file that is no lock is left as it is") {
  const TemporaryDirectory folder;
  const auto path = folder / "Cargo.lock";
  for (const std::string& text : {std::string("version = 3\n"), std::string(100, '1'), std::string(),
                                  std::string("\n"), std::string("   1234\n")}) {
    put_content(path, text);
    CHECK_THAT(error_text<ArgumentError>([&] { FileLock(path, "builds Cargo"); }),
               Contains("Cargo.lock\" is in the way: it is no lock of samara"));
    CHECK(std::filesystem::exists(path));
    CHECK(content(path) == text);
  }
}

TEST_CASE("a link that stands where a lock would is left as it is, wherever it leads") {
  const TemporaryDirectory folder;
  const auto path = folder / "draft.lock", target = folder / "target";
  std::filesystem::create_symlink(target, path);
  const auto refused = [&] { return error_text<ArgumentError>([&] { FileLock(path, "writes draft"); }); };
  CHECK_THAT(refused(), Contains("draft.lock\" is in the way"));
  CHECK_FALSE(std::filesystem::exists(target));
  put_content(target, "1");
  CHECK_THAT(refused(), Contains("draft.lock\" is in the way"));
  CHECK(content(target) == "1");
  CHECK(std::filesystem::is_symlink(path));
}
