#include "core/prefix.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace stonestack::core {
namespace {

namespace fs = std::filesystem;

TEST(InstallPrefixes, BeginAboveTheFolderOfTheProgram) {
  const auto prefixes = install_prefixes();
  ASSERT_FALSE(prefixes.empty());
  EXPECT_EQ(prefixes.front(), fs::canonical("/proc/self/exe").parent_path().parent_path());
}

TEST(InstallPrefixes, AreFoldersAndEachStandsOnce) {
  auto prefixes = install_prefixes();
  for (const fs::path& prefix : prefixes) EXPECT_TRUE(fs::is_directory(prefix)) << prefix;
  std::sort(prefixes.begin(), prefixes.end());
  EXPECT_EQ(std::unique(prefixes.begin(), prefixes.end()), prefixes.end());
}

}  // namespace
}  // namespace stonestack::core
