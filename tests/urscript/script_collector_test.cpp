#include "urscript/script_collector.hpp"

#include <gtest/gtest.h>

namespace stonestack::urscript {
namespace {

TEST(ScriptCollector, TheEndOfAProgramThatIsTooLongIsNoProgram) {
  ScriptCollector collector;
  std::vector<std::string> whole = collector.feed("def long():\n");
  std::string some;
  for (int i = 0; i < 1000; ++i) some += " movej([0,0,0,0,0,0])\n";
  for (int i = 0; i < 250; ++i)
    for (auto& script : collector.feed(some)) whole.push_back(script);
  EXPECT_TRUE(whole.empty());
  whole = collector.feed("end\nset speed 0.5\n");
  ASSERT_EQ(whole.size(), 2u);
  EXPECT_GT(whole[0].size(), kLongestScript) << "which the controller refuses";
  EXPECT_LT(whole[0].size(), 2 * kLongestScript);
  EXPECT_EQ(whole[1], "set speed 0.5");
}

}  // namespace
}  // namespace stonestack::urscript
