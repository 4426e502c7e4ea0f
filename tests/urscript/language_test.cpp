// The language on its own, without a controller: values, functions, control flow, scopes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "urscript/machine_bench.hpp"

namespace stonestack::urscript {
namespace {

using ::testing::HasSubstr;

TEST(Language, Expressions) {
  MachineBench bench;
  EXPECT_EQ(bench.value("1 + 2 * 3"), "7");
  EXPECT_EQ(bench.value("(1 + 2) * 3"), "9");
  EXPECT_EQ(bench.value("7 / 2"), "3.5");
  EXPECT_EQ(bench.value("7 % 3"), "1");
  EXPECT_EQ(bench.value("-2 - -3"), "1");
  EXPECT_EQ(bench.value("0x10"), "16");
  EXPECT_EQ(bench.value("1e-3 * 2"), "0.002");
  EXPECT_EQ(bench.value("2147483647 + 1"), "-2147483648") << "integers have 32 bits";
  EXPECT_EQ(bench.value("-(-2147483647 - 1)"), "-2147483648");
  EXPECT_EQ(bench.output("def a():\n def f(x=4294967295):\n  return x\n end\n textmsg(f())\nend\n"), "-1")
      << "wherever they are written";
  EXPECT_EQ(bench.value("0x"), "");
  EXPECT_THAT(bench.exceptions, HasSubstr("syntax_error_on_line:2"));
  EXPECT_EQ(bench.value("1 < 2 and not 2 == 3"), "True");
  EXPECT_EQ(bench.value("False or 3 >= 3"), "True");
  EXPECT_EQ(bench.value("True xor True"), "False");
  EXPECT_EQ(bench.value("1 == 1.0"), "True");
  EXPECT_EQ(bench.value("[1, 2] == [1, 2]"), "True");
  EXPECT_EQ(bench.value("\"a # b\""), "a # b");
  EXPECT_EQ(bench.value("[1, 2.5, True, \"x\"]"), "[1,2.5,True,x]");
  EXPECT_EQ(bench.value("p[0.1, -0.2, 0.3, 0, 0, 1.5]"), "p[0.1,-0.2,0.3,0,0,1.5]");
  EXPECT_EQ(bench.value("[10, 20, 30][1]"), "20");
  EXPECT_EQ(bench.value("[[1, 2], [3, 4]][1, 0]"), "3");
}

TEST(Language, ListArithmetic) {
  MachineBench bench;
  EXPECT_EQ(bench.value("[1, 2, 3] * 2"), "[2,4,6]");
  EXPECT_EQ(bench.value("3.0 * [1, 2] + [0.5, 1]"), "[3.5,7]");
  EXPECT_EQ(bench.value("-[1, 2]"), "[-1,-2]");
  EXPECT_EQ(bench.value("[2, 4] / 4"), "[0.5,1]");
  bench.value("[1, 2] + [1, 2, 3]");
  EXPECT_THAT(bench.exceptions, HasSubstr("lists of 2 and 3 elements"));
}

TEST(Language, NothingOfAnAbsentSideIsEvaluated) {
  MachineBench bench;
  EXPECT_EQ(bench.value("False and [1][5] == 1"), "False");
  EXPECT_EQ(bench.value("True or 1 / 0 == 1"), "True");
}

TEST(Language, FunctionsSeeTheProgramsVariables) {
  MachineBench bench;
  EXPECT_EQ(bench.output("def scopes():\n"
                         "  $ 2 \"a node of PolyScope\"\n"
                         "  global g = 1\n"
                         "  outer = 10\n"
                         "  def late():\n"
                         "    return below(2) + outer\n"  // defined below
                         "  end\n"
                         "  def below(x, factor=3, offset=-1):\n"
                         "    local outer = 100\n"
                         "    outer = outer + x\n"
                         "    g = g + 1\n"
                         "    mine = x * factor + offset\n"
                         "    return mine\n"
                         "  end\n"
                         "  mine = 7\n"
                         "  textmsg(late(), \" \")\n"
                         "  textmsg(below(1, offset=0))\n"
                         "  textmsg([outer, g])\n"
                         "  l = [1, [2, 3]]\n"
                         "  l[1][0] = 9\n"
                         "  l[1, 1] = 8\n"
                         "  copy = l\n"
                         "  copy[0] = 5\n"
                         "  textmsg(l)\n"
                         "  pose = p[0,0,0,0,0,0]\n"
                         "  pose[2] = 0.5\n"
                         "  textmsg(pose)\n"
                         "end\n"),
            "15 |3|[10,3]|[1,[9,8]]|p[0,0,0.5,0,0,0]");
}

TEST(Language, Functions) {
  MachineBench bench;
  EXPECT_EQ(bench.value("str_cat(\"q=\", [1, 2])"), "q=[1,2]");
  EXPECT_EQ(bench.value("str_sub(\"Universal\", 3, 2)"), "ve");
  EXPECT_EQ(bench.value("str_find(\"abcabc\", \"c\", 3)"), "5");
  EXPECT_EQ(bench.value("to_num(\"-1.5\")"), "-1.5");
  EXPECT_EQ(bench.value("floor(-1.5)"), "-2");
  EXPECT_EQ(bench.value("norm([3, 4])"), "5");
  EXPECT_EQ(bench.value("norm(-2.5)"), "2.5");
  EXPECT_EQ(bench.value("r2d(d2r(30))"), "30");
  EXPECT_EQ(bench.value("binary_list_to_integer([True, False, True])"), "5");
  EXPECT_EQ(bench.value("integer_to_binary_list(4)[2]"), "True");
  EXPECT_EQ(bench.value("get_list_length([1, 2, 3])"), "3");
}

TEST(Language, PoseFunctions) {
  MachineBench bench;
  // A quarter turn about z, one step ahead: x of the inner frame points along y of the outer one.
  EXPECT_EQ(
      bench.value("point_dist(pose_trans(p[1,2,3,0,0,d2r(90)], p[1,0,0,0,0,0]), p[1,3,3,0,0,0]) < 1e-9"),
      "True");
  EXPECT_EQ(
      bench.value(
          "pose_dist(pose_trans(pose_inv(p[1,2,3,.1,.2,.3]), p[1,2,3,.1,.2,.3]), p[0,0,0,0,0,0]) < 1e-9"),
      "True");
  EXPECT_EQ(bench.value("pose_add(p[1,0,0,0,0,0], p[0,2,0,0,0,1])"), "p[1,2,0,0,0,1]");
  EXPECT_EQ(bench.value("interpolate_pose(p[0,0,0,0,0,0], p[1,0,0,0,0,1], 0.25)"), "p[0.25,0,0,0,0,0.25]");
  EXPECT_EQ(bench.value("wrench_trans(p[0,1,0,0,0,0], [1,0,0,0,0,0])"), "[1,0,0,0,0,-1]");
}

TEST(Language, ControlFlow) {
  MachineBench bench;
  EXPECT_EQ(bench.output("def flow():\n"
                         "  i = 0\n"
                         "  while True:\n"
                         "    i = i + 1\n"
                         "    if i == 2:\n"
                         "      continue\n"
                         "    elif i == 3 or\n"  // goes on in the next line
                         "        i == 4:\n"
                         "      textmsg(\"three or four \", i)\n"
                         "    elif i > 5:\n"
                         "      break\n"
                         "    else:\n"
                         "      textmsg(i)\n"
                         "    end\n"
                         "  end\n"
                         "  textmsg(\"end\")\n"
                         "  halt\n"
                         "  textmsg(\"never\")\n"
                         "end\n"),
            "1|three or four 3|three or four 4|5|end");
}

TEST(Language, FindsTheEndOfAProgramInAStream) {
  int depth = 0;
  std::string ends;
  for (const char* line : {"def a():", "  if x:", "  elif y:", "  end # if", "  thread t():", "  while 1:",
                           "end", " end ", "endless = 1", "  if x: y = \"end if\" end # end", "end"}) {
    depth += block_balance(line);
    if (depth == 0) ends += line;
  }
  EXPECT_EQ(ends, "end");
  EXPECT_TRUE(opens_program(" def a():"));
  EXPECT_TRUE(opens_program("sec b():"));
  EXPECT_FALSE(opens_program("define = 1"));
}

TEST(Language, OnlyWhatTheLibraryHasIsCalled) {
  MachineBench bench;
  bench.output("def a():\n  movej([0,0,0,0,0,0])\nend\n");
  EXPECT_THAT(bench.exceptions, HasSubstr("compile_error_name_not_found:movej"));
  EXPECT_EQ(bench.texts, "");
}

TEST(Language, FunctionsActOnTheHost) {
  MachineBench bench;
  EXPECT_EQ(bench.output("def a():\n  textmsg(add_up(2))\n  textmsg(add_up(3))\nend\n"), "2|5");
  EXPECT_EQ(bench.sum, 5);
}

}  // namespace
}  // namespace stonestack::urscript
