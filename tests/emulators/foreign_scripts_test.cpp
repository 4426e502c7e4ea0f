// Scripts as foreign client libraries build them: a resident command loop over RTDE registers, and one that
// dials back to the host and is fed over sockets. The scripts here were written for these tests; they do what
// those libraries' do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "core/socket.hpp"
#include "protocol/big_endian.hpp"
#include "script_bench.hpp"

namespace stonestack::emulators {
namespace {

TEST(UrForeignScripts, AResidentLoopServesCommandsFromRegisters) {
  ScriptBench bench;
  bench.controller.run_script(
      "def resident():\n"
      "  global target = [0, 0, 0, 0, 0, 0]\n"
      "  global servo = 0\n"
      "  global servoing = 0\n"
      "  thread follow():\n"
      "    while (True):\n"
      "      servoj(target, t=0.008, lookahead_time=0.05, gain=600)\n"
      "    end\n"
      "  end\n"
      "  def ready(value):\n"
      "    write_output_integer_register(0, value)\n"
      "  end\n"
      "  def command():\n"
      "    cmd = read_input_integer_register(0)\n"
      "    if cmd == 1:\n"
      "      q = get_actual_joint_positions()\n"
      "      q[0] = read_input_float_register(0)\n"
      "      movej(q, a=read_input_float_register(7), v=read_input_float_register(6))\n"
      "    elif cmd == 12:\n"
      "      q = get_actual_joint_positions()\n"
      "      q[5] = read_input_float_register(5)\n"
      "      enter_critical\n"
      "      target = q\n"
      "      exit_critical\n"
      "      if servoing == 0:\n"
      "        servoing = 1\n"
      "        global servo = run follow()\n"
      "      end\n"
      "    elif cmd == 17:\n"
      "      enter_critical\n"
      "      servoing = 0\n"
      "      kill servo\n"
      "      exit_critical\n"
      "      stopj(20)\n"
      "    end\n"
      "    return cmd != 255\n"
      "  end\n"
      "  going = True\n"
      "  busy = False\n"
      "  ready(1)\n"
      "  while going:\n"
      "    if read_input_integer_register(0) == 0:\n"
      "      ready(1)\n"
      "      busy = False\n"
      "    else:\n"
      "      ready(0)\n"
      "      if not busy:\n"
      "        going = command()\n"
      "      end\n"
      "      busy = True\n"
      "    end\n"
      "    sync()\n"
      "  end\n"
      "  textmsg(\"terminated\")\n"
      "end\n");
  auto& registers = bench.controller.registers;
  const auto command = [&](int number, double seconds) {
    registers.in_int[0] = number;
    bench.run(seconds);
    registers.in_int[0] = 0;
    bench.run(0.05);
    return registers.out_int[0];
  };
  registers.in_double[0] = 0.4;
  registers.in_double[6] = 0.8;
  registers.in_double[7] = 1.5;
  EXPECT_EQ(command(1, 2.0), 1);
  EXPECT_NEAR(bench.controller.plant().q[0], 0.4, 1e-9);
  registers.in_double[5] = 0.3;
  command(12, 1.0);
  EXPECT_NEAR(bench.controller.plant().q[5], 0.3, 1e-3);
  command(17, 0.5);
  EXPECT_FALSE(bench.controller.motion.moving());
  EXPECT_EQ(bench.exceptions, "");
  command(255, 0.1);
  EXPECT_EQ(bench.texts, "terminated");
  EXPECT_EQ(bench.controller.runtime(), RuntimeState::kStopped);
}

TEST(UrForeignScripts, AProgramDialsBackAndIsFedOverASocket) {
  TcpListener listener(ListenOptions{});
  ScriptBench bench;
  bench.controller.run_script(
      "def callback():\n"
      "  SCALE = 1000000\n"
      "  global mode = 0\n"
      "  global q_goal = get_joint_positions()\n"
      "  mover = 0\n"
      "  thread follow():\n"
      "    while mode == 1:\n"
      "      enter_critical\n"
      "      q = q_goal\n"
      "      servoj(q, t=get_steptime(), lookahead_time=0.03, gain=2000)\n"
      "      exit_critical\n"
      "    end\n"
      "    stopj(4.0)\n"
      "  end\n"
      "  if not socket_open(\"127.0.0.1\", " +
      std::to_string(listener.endpoint().port) +
      ", \"reverse_socket\"):\n"
      "    textmsg(\"no connection\")\n"
      "    halt\n"
      "  end\n"
      "  timeout = 0.0\n"
      "  while mode > -2:\n"
      "    enter_critical\n"
      "    params = socket_read_binary_integer(8, \"reverse_socket\", timeout)\n"
      "    if params[0] > 0:\n"
      "      timeout = params[1] / 1000.0\n"
      "      if mode != params[8]:\n"
      "        mode = params[8]\n"
      "        join mover\n"
      "        if mode == 1:\n"
      "          q_goal = get_joint_positions()\n"
      "          mover = run follow()\n"
      "        end\n"
      "      end\n"
      "      q_goal = [params[2], params[3], params[4], params[5], params[6], params[7]] / SCALE\n"
      "    else:\n"
      "      textmsg(\"timed out\")\n"
      "      mode = -2\n"
      "    end\n"
      "    exit_critical\n"
      "  end\n"
      "  join mover\n"
      "  socket_send_int(7, \"reverse_socket\")\n"
      "  textmsg(\"over\")\n"
      "end\n");
  bench.run(bench.controller.period());
  auto host = listener.accept(Deadline::in(5));
  ASSERT_TRUE(host.has_value()) << bench.texts << bench.exceptions;
  Joints goal = ScriptBench::start();
  for (int k = 0; k < 200; ++k) {
    goal[0] += 0.0008;
    std::string message;
    put(message, std::int32_t{200});
    for (int j = 0; j < 6; ++j) put(message, static_cast<std::int32_t>(std::lround(goal[j] * 1e6)));
    put(message, std::int32_t{1});
    ASSERT_TRUE(host->write_all(message, Deadline::in(5)));
    bench.run(bench.controller.period());
  }
  EXPECT_EQ(bench.exceptions, "");
  EXPECT_TRUE(bench.controller.program_running());
  EXPECT_NEAR(bench.controller.plant().q[0], goal[0], 0.02) << "it follows, behind by its delay";
  bench.run(1.0);
  EXPECT_EQ(bench.texts, "timed out|over");
  std::array<std::uint8_t, 4> answer;
  EXPECT_TRUE(host->read_exact(answer, Deadline::in(5)));
  EXPECT_EQ(answer[3], 7);
}

TEST(UrForeignScripts, TextInjectedIntoAScriptMayJoinItsLines) {
  // ur_rtde writes its register offsets below a comment, at the beginning of the next statement's line.
  ScriptBench bench;
  EXPECT_EQ(bench.output("def injected():\n"
                         "  global offset = # float register offset\n"
                         "24  global other = # int register offset\n"
                         "12  global third = 3\n"
                         "  if offset == 24: third = 4 end\n"
                         "  while third < 9: third = third + 5 end\n"
                         "  textmsg(offset + other + third)\n"
                         "end\n"),
            "45");
  EXPECT_EQ(bench.exceptions, "");
  bench.output("def two():\n  a = 1 b = 2\nend\n");
  EXPECT_EQ(bench.exceptions, "2,9,syntax_error_on_line:2:  a = 1 b = 2:");
}

TEST(UrForeignScripts, AVariableMayBeCalledP) {
  ScriptBench bench;
  EXPECT_EQ(bench.output("def scaled():\n"
                         "  def scale(p, factor):\n"
                         "    p[0] = p[0] * factor\n"
                         "    p[5] = p[p[1]] + 1\n"
                         "    return p\n"
                         "  end\n"
                         "  p = p[1, 2, 3, 0, 0, 0]\n"
                         "  textmsg(scale(p, 2))\n"
                         "  textmsg(p)\n"
                         "end\n"),
            "p[2,2,3,0,0,4]|p[1,2,3,0,0,0]");
  EXPECT_EQ(bench.exceptions, "");
  bench.output("def lacking():\n  q = p[1, 2]\nend\n");
  EXPECT_EQ(bench.exceptions, "2,7,syntax_error_on_line:2:  q = p[1, 2]:");
}

TEST(UrForeignScripts, ThreadsThatNeverRanAreKilledAndJoined) {
  ScriptBench bench;
  EXPECT_EQ(bench.output("def never():\n"
                         "  global mover = 0\n"
                         "  kill mover\n"
                         "  join mover\n"
                         "  if mover == 0:\n"
                         "    textmsg(\"none\")\n"
                         "  end\n"
                         "end\n"),
            "none");
  EXPECT_EQ(bench.exceptions, "");
}

TEST(UrForeignScripts, SplinesAreSpeedsWithTheAccelerationTheyNeed) {
  // As UR's client library follows a spline: a speedj a step, whose acceleration is 0 where the speed stays.
  ScriptBench bench;
  bench.controller.run_script(
      "def spline():\n"
      "  global last = [0, 0, 0, 0, 0, 0]\n"
      "  def largest(list):\n"
      "    local length = get_list_length(list)\n"
      "    local max = norm(list[0])\n"
      "    local i = 1\n"
      "    while i < length:\n"
      "      local tmp = norm(list[i])\n"
      "      if tmp > max:\n"
      "        max = tmp\n"
      "      end\n"
      "      i = i + 1\n"
      "    end\n"
      "    return max\n"
      "  end\n"
      "  def go(c1, c2, t, step, factor=1.0, is_last = False):\n"
      "    local qd = (c1 + 2.0 * t * c2) * factor\n"
      "    local qdd = largest((qd - last) / step)\n"
      "    last = qd\n"
      "    speedj(qd, qdd, step)\n"
      "  end\n"
      "  local t = 0.0\n"
      "  local dt = get_steptime()\n"
      "  while t < 0.5:\n"
      "    go([0.4, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0], t, dt)\n"
      "    t = t + dt\n"
      "  end\n"
      "  go([0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0], t, dt, is_last = True)\n"
      "  stopj(4.0)\n"
      "end\n");
  bench.run_to_end();
  EXPECT_EQ(bench.exceptions, "");
  EXPECT_NEAR(bench.controller.plant().q[0] - ScriptBench::start()[0], 0.2, 0.01);
}

TEST(UrForeignScripts, NewerMotionFunctions) {
  ScriptBench old("5.12.2.1101534"), recent("5.23.0.1234");
  const std::string script =
      "def moves():\n"
      "  q = get_actual_joint_positions()\n"
      "  q[0] = q[0] + 0.3\n"
      "  optimovej(q, a = 0.5, v = 0.5)\n"
      "end\n";
  old.output(script);
  EXPECT_EQ(old.exceptions, "4,3,compile_error_name_not_found:optimovej:");
  recent.output(script);
  EXPECT_EQ(recent.exceptions, "");
  EXPECT_NEAR(recent.controller.plant().q[0] - ScriptBench::start()[0], 0.3, 1e-9);
  recent.output("def torque():\n  direct_torque([0, 0, 0, 0, 0, 0])\nend\n");
  EXPECT_THAT(recent.exceptions, testing::HasSubstr("positions and speeds only"));
}

TEST(UrForeignScripts, ConditionsGoOnInTheNextLine) {
  // UR's client library lists kinds of points one below the other, and nests its texts in brackets.
  ScriptBench bench;
  EXPECT_EQ(bench.output("def lines():\n"
                         "  kind = 11.0\n"
                         "  if kind == 3 or\n"
                         "    kind == 9 or\n"
                         "    kind == 11:\n"
                         "    textmsg(\"arc\")\n"
                         "  elif kind == 5 and\n"
                         "       kind > 4:\n"
                         "    textmsg(\"other\")\n"
                         "  end\n"
                         "  local str = str_cat(\n"
                         "    str_cat(\"Velocity \", 2.5), str_cat(\n"
                         "      str_cat(\" in joint \", 3),\n"
                         "      \" is too high\"))\n"
                         "  textmsg(str)\n"
                         "  textmsg(\"list \",\n"
                         "    str_cat(True, str_cat(\", \", to_str([1, 2.5]))))\n"
                         "end\n"),
            "arc|Velocity 2.5 in joint 3 is too high|list True, [1,2.5]");
  EXPECT_EQ(bench.exceptions, "");
}

TEST(UrForeignScripts, NumbersThatWereDividedAreWholeNumbersWhereThoseAreWanted) {
  // Hosts send micro-units; what comes out of the division is a float, and goes where modes and switches go.
  ScriptBench bench("5.12.2.1101534");
  EXPECT_EQ(
      bench.output("def scaled():\n"
                   "  MULT = 1000000\n"
                   "  raw = [1, 24000000, 2000000, 1000000, 0]\n"
                   "  set_tool_voltage(raw[1] / MULT)\n"
                   "  has_qnear = raw[3] / MULT\n"
                   "  if has_qnear:\n"
                   "    textmsg(\"near\")\n"
                   "  end\n"
                   "  force_mode(p[0, 0, 0, 0, 0, 0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0, 0, 0, 0, 0, 0], "
                   "raw[2] / MULT, [0.1, 0.1, 0.1, 0.1, 0.1, 0.1])\n"
                   "  end_force_mode()\n"
                   "  count = 3\n"
                   "  textmsg(count * get_steptime() % 5.0 == 0)\n"
                   "  textmsg(7.5 % 5.0)\n"
                   "  flag = (raw[4] != 0)\n"
                   "  textmsg(True and (flag == False))\n"
                   "  textmsg((-3 * [1, 2] + [2, 2] * 3 - [1, 1] * 2 * 0.5) / pow(2, 2))\n"
                   "end\n"),
      "near|False|2.5|True|[0.5,-0.25]");
  EXPECT_EQ(bench.exceptions, "");
}

TEST(UrForeignScripts, NestedFunctionsSetAndJoinTheProgramsThreads) {
  ScriptBench bench;
  EXPECT_EQ(bench.output("def threads():\n"
                         "  thread_clear = 0\n"
                         "  thread_move = 0\n"
                         "  left = 3\n"
                         "  global busy = False\n"
                         "  def request():\n"
                         "    if not busy:\n"
                         "      busy = True\n"
                         "      thread_clear = run clear()\n"
                         "    end\n"
                         "  end\n"
                         "  def settle():\n"
                         "    join thread_clear\n"
                         "    thread_clear = 0\n"
                         "  end\n"
                         "  thread clear():\n"
                         "    local reads = 0\n"
                         "    while left > 0:\n"
                         "      left = left - 1\n"
                         "      reads = reads + 1\n"
                         "      if reads >= 2:\n"
                         "        sync()\n"
                         "        reads = 0\n"
                         "      end\n"
                         "      if left == 0:\n"
                         "        break\n"
                         "      end\n"
                         "    end\n"
                         "    busy = False\n"
                         "  end\n"
                         "  thread mover():\n"
                         "    enter_critical\n"
                         "    q = get_target_joint_positions()\n"
                         "    q[0] = q[0] + 2.0\n"
                         "    movej(q, a = 1.4, v = 1.0, t = 0.0, r = 0.0)\n"
                         "    exit_critical\n"
                         "  end\n"
                         "  thread_move = run mover()\n"
                         "  sleep(0.3)\n"
                         "  kill thread_move\n"
                         "  request()\n"
                         "  request()\n"
                         "  stopj(4.0)\n"
                         "  settle()\n"
                         "  textmsg(\"left \", left)\n"
                         "  textmsg(is_steady())\n"
                         "  halt\n"
                         "  textmsg(\"never\")\n"
                         "end\n"),
            "left 0|True");
  EXPECT_EQ(bench.exceptions, "");
}

TEST(UrForeignScripts, LinesMayEndAsOnWindows) {
  ScriptBench bench;
  EXPECT_EQ(bench.output("def windows():\r\n"
                         "  # a remark\r\n"
                         "\r\n"
                         "  if True:\r\n"
                         "    textmsg(\"there\")\r\n"
                         "  else:\r\n"
                         "    textmsg(\"not there\")\r\n"
                         "  end\r\n"
                         "end\r\n"),
            "there");
  EXPECT_EQ(bench.exceptions, "");
}

/// A script on the bench with a server that it has connected to.
struct CalledServer {
  TcpListener listener{ListenOptions{}};
  ScriptBench bench;
  std::optional<TcpStream> host;

  void run_script(const std::string& body) {
    bench.controller.run_script("def client():\n  socket_open(\"127.0.0.1\", " +
                                std::to_string(listener.endpoint().port) + ")\n" + body + "end\n");
    bench.run(0.05);
    host = listener.accept(Deadline::in(5));
    EXPECT_TRUE(host.has_value()) << bench.texts << bench.exceptions;
  }
  std::string line() { return host->read_line(100, Deadline::in(5)).line; }
  /// Sends an answer, and runs the script for a moment.
  std::string answer(const std::string& text) {
    bench.texts.clear();
    EXPECT_TRUE(host->write_all(text, Deadline::in(5)));
    bench.run(0.05);
    return bench.texts;
  }
};

TEST(UrForeignScripts, VariablesOfAServerAreSetAndRead) {
  CalledServer server;
  server.run_script(
      "  socket_set_var(\"POS_Y\", 2200)\n"
      "  socket_set_var(\"POS\", 120.0, \"socket_0\")\n"
      "  textmsg(socket_get_var(\"POS\"))\n"
      "  textmsg(socket_get_var(\"SPE\", \"socket_0\"))\n"
      "  textmsg(socket_get_var(\"NOT\"))\n");
  EXPECT_EQ(server.line(), "SET POS_Y 2200");
  EXPECT_EQ(server.line(), "SET POS 120");
  EXPECT_EQ(server.line(), "GET POS");
  EXPECT_EQ(server.answer("ackackPOS 120"), "120") << "no line end, behind what nobody read";
  EXPECT_EQ(server.line(), "GET SPE");
  EXPECT_EQ(server.answer("SPE -7\n"), "-7");
  EXPECT_EQ(server.line(), "GET NOT");
  server.bench.run(2.1);
  EXPECT_EQ(server.bench.texts, "-7|0") << "no answer in two seconds";
  EXPECT_EQ(server.bench.exceptions, "");
}

TEST(UrForeignScripts, BytesAreReadAsAListOfTheirNumber) {
  CalledServer server;
  server.run_script(
      "  textmsg(socket_read_byte_list(3))\n"
      "  textmsg(socket_read_byte_list(2, \"socket_0\", 0))\n"
      "  textmsg(socket_read_byte_list(4, \"socket_0\", 0.5))\n"
      "  textmsg(socket_read_byte_list(3, \"socket_0\", 0.1))\n");
  EXPECT_EQ(server.answer("ack"), "[3,97,99,107]");
  server.bench.run(10.0);
  EXPECT_EQ(server.answer(std::string("\x00\xFFz", 3)), "[2,0,255]") << "it waited without an end";
  server.bench.texts.clear();
  server.bench.run(1.0);
  EXPECT_EQ(server.bench.texts, "[1,122,-1,-1,-1]|[0,-1,-1,-1]") << "those that came in time";
  EXPECT_EQ(server.bench.exceptions, "");
  server.bench.value("socket_read_byte_list(31)");
  EXPECT_THAT(server.bench.exceptions, testing::HasSubstr("1 to 30 bytes"));
}

TEST(UrForeignScripts, DomainsOfAnalogPortsAreSet) {
  ScriptBench bench;
  EXPECT_EQ(bench.output("def domains():\n"
                         "  set_analog_inputrange(0, 0)\n"
                         "  set_analog_inputrange(3, 1)\n"
                         "  set_analog_outputdomain(0, 0)\n"
                         "  set_analog_outputdomain(1, 1)\n"
                         "  set_runstate_outputs([])\n"
                         "  set_runstate_outputs([0, 17])\n"
                         "  textmsg(\"set\")\n"
                         "end\n"),
            "set");
  EXPECT_EQ(bench.exceptions, "");
  EXPECT_EQ(bench.controller.io.analog_out_types, 2U) << "output 0 in mA, output 1 in V";
}

TEST(UrForeignScripts, SocketsStayOnThisMachine) {
  ScriptBench bench;
  EXPECT_EQ(bench.value("socket_open(\"192.0.2.1\", 80)"), "False");
  EXPECT_EQ(bench.value("socket_open(\"not an address\", 80)"), "False");
  EXPECT_EQ(bench.value("socket_send_int(1, \"none\")"), "False");
  EXPECT_EQ(bench.value("socket_read_binary_integer(2, \"none\")"), "[-1,0,0]");
  EXPECT_EQ(bench.value("socket_read_byte_list(2, \"none\")"), "[0,-1,-1]");
  EXPECT_EQ(bench.value("socket_get_var(\"POS\", \"none\")"), "0");
}

}  // namespace
}  // namespace stonestack::emulators
