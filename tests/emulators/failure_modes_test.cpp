// docs/failure-modes.md promises a switch and a test for each failure; it is held to that here.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "emulators/servers_options.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/emulators/simulated_servers.hpp"

namespace stonestack::emulators {
namespace {

const std::string kRoot = STONESTACK_SOURCE_DIR;
constexpr std::size_t kMax = 1 << 20;

std::set<std::string> all_tests() {
  std::set<std::string> names;
  const std::regex test(R"(\nTEST(_F|_P)?\((\w+),\s*(\w+)\))");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kRoot + "/tests")) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = read_file(entry.path().string(), kMax);
    for (std::sregex_iterator it(text.begin(), text.end(), test), end; it != end; ++it)
      names.insert((*it)[2].str() + "." + (*it)[3].str());
  }
  return names;
}

TEST(FailureModes, EverySwitchIsListedAndEveryTestIsThere) {
  const std::string text = read_file(kRoot + "/docs/failure-modes.md", kMax);
  SimulatedServersOptions options;
  int switches = 0;
  for (const auto& field : fields(options)) {
    const auto at = field.name.find("faults.");
    if (at == std::string::npos) continue;
    ++switches;
    EXPECT_NE(text.find("`" + field.name.substr(at + 7) + "`"), std::string::npos)
        << field.name << " stands nowhere in docs/failure-modes.md";
  }
  EXPECT_GT(switches, 60);
  const auto tests = all_tests();
  const std::regex named(R"(`([A-Z]\w+\.[A-Z]\w+)`)");
  int shown = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), named), end; it != end; ++it, ++shown)
    EXPECT_TRUE(tests.count((*it)[1].str()) > 0) << (*it)[1].str() << " is no test here";
  EXPECT_GT(shown, 60);
}

}  // namespace
}  // namespace stonestack::emulators
