#pragma once
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace stonestack::test {

/// A folder of this process alone, with a slash at its end. It is removed when the process ends. ctest runs
/// the tests of one fixture at the same time, so a fixed name in testing::TempDir() would be written and
/// removed by several of them.
inline const std::string& temporary_folder() {
  struct Folder {
    Folder() {
      std::string pattern = testing::TempDir() + "stonestack_test_XXXXXX";
      if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder: " + pattern);
      path = pattern + "/";
    }
    ~Folder() {
      if (getpid() != owner) return;  // a forked child leaves its parent's folder alone
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
    std::string path;
    pid_t owner = getpid();
  };
  static const Folder folder;
  return folder.path;
}

}  // namespace stonestack::test
