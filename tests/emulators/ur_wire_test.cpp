// Bytes of the simulated controller, written by hand from UR's tables, against RTDE sessions, primary and
// realtime messages and Dashboard lines; no sockets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "emulators/ur/dashboard_session.hpp"
#include "emulators/ur/primary_messages.hpp"
#include "emulators/ur/rtde_access.hpp"
#include "emulators/ur/rtde_session.hpp"
#include "emulators/ur/script_queue.hpp"
#include "protocol/big_endian.hpp"
#include "script_bench.hpp"
#include "urscript/script_collector.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::ElementsAre;

std::string hex(const std::string& digits) {
  std::string bytes, pair;
  for (const char c : digits) {
    if (c == ' ') continue;
    pair += c;
    if (pair.size() < 2) continue;
    bytes.push_back(static_cast<char>(std::stoi(pair, nullptr, 16)));
    pair.clear();
  }
  return bytes;
}

std::string wire_packet(char type, const std::string& payload) {
  const auto size = payload.size() + 3;
  return {std::string{static_cast<char>(size >> 8), static_cast<char>(size & 0xFF), type} + payload};
}

ControllerFaults from_zero() {
  ControllerFaults faults;
  faults.boot_seconds = 0;
  return faults;
}

struct Rtde {
  explicit Rtde(const ControllerFaults& faults = from_zero(), const std::string& version = "3.15.8.106339")
      : bench(version, faults) {}
  std::string ask(const std::string& bytes) {
    std::string all;
    for (const auto& reply : session.feed(bytes)) all += reply;
    return all;
  }
  ScriptBench bench;
  InputOwners owners;
  RtdeSession session{1, bench.controller, owners};
};

TEST(UrWire, RtdeHandshakeByteByByte) {
  Rtde rtde;
  EXPECT_EQ(rtde.ask(hex("00 05 56 00 02")), hex("00 04 56 01"));
  EXPECT_EQ(rtde.ask(hex("00 05 56 00 03")), hex("00 04 56 00")) << "there is no protocol 3";
  EXPECT_EQ(rtde.ask(hex("00 03 76")), hex("00 13 76 00000003 0000000f 00000008 00019f63"));
  EXPECT_EQ(rtde.ask(hex("00 03 53")), hex("00 04 53 00")) << "no start without outputs";
  // 125 Hz, names with the trailing comma of ur_rtde.
  EXPECT_EQ(rtde.ask(wire_packet('O', hex("405f400000000000") + "timestamp,robot_mode,")),
            wire_packet('O', "\1DOUBLE,INT32"));
  EXPECT_EQ(rtde.ask(hex("00 03 53")), hex("00 04 53 01"));
  rtde.bench.controller.step();
  EXPECT_EQ(rtde.session.sample(), hex("00 10 55 01 3f80624dd2f1a9fc 00000007")) << "0.008 s, RUNNING";
  EXPECT_EQ(rtde.session.sample(), std::nullopt) << "one a step";
  EXPECT_EQ(rtde.ask(hex("00 03 50")), hex("00 04 50 01"));
  rtde.bench.controller.step();
  EXPECT_EQ(rtde.session.sample(), std::nullopt) << "paused";
}

TEST(UrWire, RtdeProtocol1HasNoFrequencyAndNoOutputRecipe) {
  Rtde rtde;
  EXPECT_EQ(rtde.ask(wire_packet('O', "timestamp")), wire_packet('O', "DOUBLE"));
  EXPECT_EQ(rtde.ask(wire_packet('I', "input_int_register_0")), wire_packet('I', "\1INT32"));
  EXPECT_EQ(rtde.ask(hex("00 03 53")), hex("00 04 53 01"));
  rtde.bench.controller.step();
  EXPECT_EQ(rtde.session.sample(), hex("00 0b 55 3f80624dd2f1a9fc"));
}

TEST(UrWire, RtdeTypesAreTheDocumentedOnes) {
  Rtde rtde;
  rtde.ask(hex("00 05 56 00 02"));
  EXPECT_EQ(
      rtde.ask(wire_packet('O', hex("405f400000000000") +
                                    "actual_q,actual_TCP_pose,actual_digital_output_bits,joint_mode,"
                                    "runtime_state,safety_status,output_bit_register_64,elbow_position,"
                                    "output_bit_registers0_to_31,output_int_register_47,tcp_offset")),
      wire_packet(
          'O', "\1VECTOR6D,VECTOR6D,UINT64,VECTOR6INT32,UINT32,INT32,BOOL,VECTOR3D,UINT32,INT32,VECTOR6D"));
  EXPECT_EQ(rtde.ask(wire_packet('I',
                                 "speed_slider_mask,speed_slider_fraction,standard_digital_output_mask,"
                                 "external_force_torque,input_bit_register_127")),
            wire_packet('I', "\1UINT32,DOUBLE,UINT8,VECTOR6D,BOOL"));
}

TEST(UrWire, RtdeReportsNotFoundAndStartsNothing) {
  Rtde rtde;
  rtde.ask(hex("00 05 56 00 02"));
  EXPECT_EQ(rtde.ask(wire_packet('O', hex("405f400000000000") + "timestamp,nonsense")),
            wire_packet('O', std::string(1, '\0') + "DOUBLE,NOT_FOUND"));
  EXPECT_EQ(rtde.ask(hex("00 03 53")), hex("00 04 53 00"));
  Rtde old(from_zero(), "3.5.4.10845");
  old.ask(hex("00 05 56 00 02"));
  EXPECT_EQ(
      old.ask(wire_packet('O', hex("405f400000000000") + "tcp_offset,safety_status,output_int_register_24")),
      wire_packet('O', std::string(1, '\0') + "NOT_FOUND,NOT_FOUND,NOT_FOUND"));
  auto faults = from_zero();
  faults.missing_fields = "payload,actual_q";
  Rtde missing(faults);
  missing.ask(hex("00 05 56 00 02"));
  EXPECT_EQ(missing.ask(wire_packet('O', hex("405f400000000000") + "actual_q,actual_qd")),
            wire_packet('O', std::string(1, '\0') + "NOT_FOUND,VECTOR6D"));
}

TEST(UrWire, RtdeFieldsCameWithVersions) {
  const auto types = [](const std::string& version, const std::string& names) {
    Rtde rtde(from_zero(), version);
    rtde.ask(hex("00 05 56 00 02"));
    return rtde.ask(wire_packet('O', hex("405f400000000000") + names)).substr(4);
  };
  // Each as UR's guide says.
  const std::string payload = "payload,payload_cog", wrench = "ft_raw_wrench,actual_current_as_torque";
  EXPECT_EQ(types("3.5.4.10845", payload), "NOT_FOUND,NOT_FOUND");
  EXPECT_EQ(types("3.11.0.82155", payload), "DOUBLE,VECTOR3D");
  EXPECT_EQ(types("5.4.3.83992", payload), "NOT_FOUND,NOT_FOUND");
  EXPECT_EQ(types("5.5.1.82186", payload), "DOUBLE,VECTOR3D");
  EXPECT_EQ(types("3.14.3.0", "payload_inertia,script_control_line"), "NOT_FOUND,UINT32");
  EXPECT_EQ(types("3.13.1.0", "script_control_line"), "NOT_FOUND");
  EXPECT_EQ(types("3.15.8.106339", "payload_inertia"), "VECTOR6D");
  EXPECT_EQ(types("3.15.8.106339", wrench), "NOT_FOUND,NOT_FOUND") << "no CB3 has them";
  EXPECT_EQ(types("5.12.2.1101534", wrench), "VECTOR6D,NOT_FOUND");
  EXPECT_EQ(types("5.23.0.0", wrench), "VECTOR6D,VECTOR6D");
  EXPECT_EQ(types("3.15.8.106339", "target_gravity,control_step"), "NOT_FOUND,NOT_FOUND");
}

TEST(UrWire, UrsRecordingExampleGetsAllOfItsFields) {
  // The outputs of record_configuration_v2.xml, with which UR's record.py begins.
  const std::string names =
      "timestamp,target_q,target_qd,target_qdd,target_current,target_moment,actual_q,actual_qd,actual_"
      "current,"
      "joint_control_output,actual_TCP_pose,actual_TCP_speed,actual_TCP_force,target_TCP_pose,"
      "target_TCP_speed,actual_digital_input_bits,joint_temperatures,actual_execution_time,robot_mode,"
      "joint_mode,safety_status,actual_tool_accelerometer,speed_scaling,target_speed_fraction,"
      "actual_momentum,actual_main_voltage,actual_robot_voltage,actual_robot_current,actual_joint_voltage,"
      "actual_digital_output_bits,runtime_state,joint_position_deviation_ratio";
  for (const char* version : {"3.15.8.106339", "5.12.2.1101534"}) {
    Rtde rtde(from_zero(), version);
    rtde.ask(hex("00 05 56 00 02"));
    const std::string reply = rtde.ask(wire_packet('O', hex("405f400000000000") + names));
    EXPECT_EQ(reply.find("NOT_FOUND"), std::string::npos) << version << ": " << reply.substr(4);
    EXPECT_EQ(reply.substr(reply.size() - 13), "UINT32,DOUBLE") << version;
    EXPECT_EQ(rtde.ask(hex("00 03 53")), hex("00 04 53 01")) << version;
  }
}

TEST(UrWire, RtdeReads2048BytesOfASetup) {
  std::string names, types;
  for (int i = 0; i < 128; ++i) {  // 15 characters and a comma each: 2047 bytes
    names += (i ? "," : "") + std::string("actual_momentum");
    types += (i ? "," : "") + std::string("DOUBLE");
  }
  Rtde rtde;
  rtde.ask(hex("00 05 56 00 02"));
  EXPECT_EQ(rtde.ask(wire_packet('O', hex("405f400000000000") + names)), wire_packet('O', "\1" + types));
  EXPECT_EQ(rtde.ask(wire_packet('O', hex("405f400000000000") + names + ",timestamp")),
            wire_packet('O', std::string(1, '\0') + types + ",NOT_FOUND"));
  std::string inputs;
  for (int i = 0; i < 48; ++i) inputs += "input_double_register_" + std::to_string(i) + ",";
  for (int i = 64; i < 128; ++i) inputs += "input_bit_register_" + std::to_string(i) + ",";
  const std::string answer = rtde.ask(wire_packet('I', inputs));
  EXPECT_EQ(answer[3], '\0');
  EXPECT_EQ(answer.substr(answer.size() - 9), "NOT_FOUND");
}

TEST(UrWire, RtdeInputsHaveOneOwner) {
  Rtde rtde;
  RtdeSession* other = new RtdeSession(2, rtde.bench.controller, rtde.owners);
  EXPECT_THAT(other->feed(wire_packet('I', "input_int_register_24")),
              ElementsAre(wire_packet('I', "\1INT32")));
  EXPECT_EQ(rtde.ask(wire_packet('I', "input_int_register_24,input_int_register_25")),
            wire_packet('I', std::string(1, '\0') + "IN_USE,INT32"));
  EXPECT_THAT(other->feed(wire_packet('I', "input_int_register_25")),
              ElementsAre(wire_packet('I', "\2INT32")))
      << "a failed setup owns nothing; recipes count from 1";
  delete other;
  EXPECT_EQ(rtde.ask(wire_packet('I', "input_int_register_24")), wire_packet('I', "\1INT32"))
      << "free when its owner has gone";
  auto faults = from_zero();
  faults.fieldbus_owns_lower_registers = true;
  Rtde shared(faults);
  EXPECT_EQ(
      shared.ask(wire_packet('I', "input_int_register_23,input_bit_registers0_to_31,input_int_register_24")),
      wire_packet('I', std::string(1, '\0') + "IN_USE,IN_USE,INT32"));
}

TEST(UrWire, RtdeInputsTakeEffect) {
  Rtde rtde;
  rtde.ask(hex("00 05 56 00 02"));
  EXPECT_EQ(rtde.ask(wire_packet('I', "input_int_register_24,input_double_register_24")),
            wire_packet('I', "\1INT32,DOUBLE"));
  EXPECT_EQ(rtde.ask(wire_packet('I', "standard_digital_output_mask,standard_digital_output")),
            wire_packet('I', "\2UINT8,UINT8"));
  EXPECT_EQ(rtde.ask(wire_packet('I', "speed_slider_mask,speed_slider_fraction")),
            wire_packet('I', "\3UINT32,DOUBLE"));
  EXPECT_EQ(rtde.ask(wire_packet('U', hex("01 fffffffe 3fd0000000000000"))), "");
  EXPECT_EQ(rtde.bench.controller.registers.in_int[24], -2);
  EXPECT_EQ(rtde.bench.controller.registers.in_double[24], 0.25);
  rtde.bench.controller.io.digital_out = 0x81;
  rtde.ask(wire_packet('U', hex("02 0f 0a")));
  EXPECT_EQ(rtde.bench.controller.io.digital_out, 0x8AU) << "only where the mask is";
  rtde.ask(wire_packet('U', hex("03 00000001 3fe0000000000000")));
  EXPECT_EQ(rtde.bench.controller.speed_slider, 0.5);
  rtde.ask(wire_packet('U', hex("03 00000000 3fd0000000000000")));
  EXPECT_EQ(rtde.bench.controller.speed_slider, 0.5);
  // Too short, unknown recipe: ignored.
  rtde.ask(wire_packet('U', hex("01 00000000")) + wire_packet('U', hex("09 00")));
  EXPECT_EQ(rtde.bench.controller.registers.in_int[24], -2);
  EXPECT_FALSE(rtde.session.broken());
}

TEST(UrWire, RtdeFrequencyDividesTheControlRate) {
  Rtde rtde(from_zero(), "5.12.2.1101534");
  rtde.ask(hex("00 05 56 00 02"));
  rtde.ask(wire_packet('O', hex("4059000000000000") + "timestamp") + hex("00 03 53"));  // 100 Hz
  int count = 0;
  for (int k = 0; k < 500; ++k) {
    rtde.bench.controller.step();
    if (rtde.session.sample()) ++count;
  }
  EXPECT_EQ(count, 100);
}

TEST(UrWire, RtdeBrokenStreamsAreGivenUp) {
  for (const char* bytes : {"00 00 56", "00 02 56 00", "00 03 05"}) {
    Rtde rtde;
    EXPECT_EQ(rtde.ask(hex(bytes)), "");
    EXPECT_TRUE(rtde.session.broken()) << bytes;
  }
  Rtde rtde;
  std::string all;
  for (const char byte : hex("00 05 56 00 02 00 03 76"))
    for (const auto& reply : rtde.session.feed({&byte, 1})) all += reply;
  EXPECT_EQ(all, hex("00 04 56 01 00 13 76 00000003 0000000f 00000008 00019f63"));
}

TEST(UrWire, PrimaryMessages) {
  ScriptBench bench("3.15.8.106339", from_zero());
  EXPECT_EQ(encode_version_message(bench.controller), hex("00000037 14 0000000000000000 fe 03 09") +
                                                          "URControl" + hex("03 0f 00000008 00019f63") +
                                                          "01-01-2024, 00:00:00");
  ControllerEvent event;
  event.kind = ControllerEvent::Kind::kKey;
  event.title = "PROGRAM_XXX_STARTED";
  event.text = "textmsg";
  EXPECT_EQ(encode_event(bench.controller, event),
            hex("00000032 14 0000000000000000 fe 07 00000000 00000000 13") + "PROGRAM_XXX_STARTEDtextmsg");
  event = {};
  event.kind = ControllerEvent::Kind::kRuntimeException;
  event.line = 3;
  event.column = 1;
  event.text = "compile_error_name_not_found:txtmsg:";
  EXPECT_EQ(
      encode_event(bench.controller, event),
      hex("0000003b 14 0000000000000000 fd 0a 00000003 00000001") + "compile_error_name_not_found:txtmsg:");
  event = read_only_error();
  event.text = "x";
  EXPECT_EQ(encode_event(bench.controller, event),
            hex("00000024 14 0000000000000000 fe 06 000000d2 00000000 00000002 00000000 00000000") + "x");
}

// The sub-packages' types and sizes as a robot with PolyScope 5.8 sends them.
TEST(UrWire, RobotStateHasItsSubPackages) {
  ScriptBench bench("5.12.2.1101534", from_zero());
  bench.controller.step();
  const std::string state = encode_robot_state(bench.controller);
  const auto number = [&](std::size_t at) {
    return static_cast<std::size_t>(
        static_cast<unsigned char>(state[at]) << 24 | static_cast<unsigned char>(state[at + 1]) << 16 |
        static_cast<unsigned char>(state[at + 2]) << 8 | static_cast<unsigned char>(state[at + 3]));
  };
  ASSERT_EQ(number(0), state.size());
  EXPECT_EQ(state[4], 16);
  std::map<int, std::size_t> sizes;
  for (std::size_t at = 5; at < state.size(); at += number(at)) {
    ASSERT_GE(number(at), 5U);
    sizes[state[at + 4]] = number(at);
  }
  const std::map<int, std::size_t> expected{{0, 47},  {1, 251}, {2, 37}, {3, 75}, {4, 101}, {5, 225},
                                            {6, 445}, {7, 61},  {8, 9},  {9, 53}, {10, 43}};
  EXPECT_EQ(sizes, expected);
}

TEST(UrWire, RealtimePackagesGrewWithTheVersions) {
  const auto size = [](const char* version) {
    ScriptBench bench(version, from_zero());
    bench.controller.step();
    const std::string package = encode_realtime(bench.controller);
    EXPECT_EQ(package.substr(4, 4), hex(version[0] == '3' ? "3f80624d" : "3f60624d")) << "time first";
    EXPECT_EQ(package.substr(2, 2), (std::string{static_cast<char>(package.size() >> 8),
                                                 static_cast<char>(package.size() & 0xFF)}));
    return package.size();
  };
  EXPECT_EQ(size("3.2.19171"), 1060U);
  EXPECT_EQ(size("3.5.4.10845"), 1108U);
  EXPECT_EQ(size("3.12.1.90940"), 1116U);
  EXPECT_EQ(size("3.14.3.0"), 1140U);
  EXPECT_EQ(size("3.15.8.106339"), 1220U);
  EXPECT_EQ(size("5.12.2.1101534"), 1220U);
}

TEST(UrWire, DashboardLines) {
  ScriptBench bench, newer("5.12.2.1101534");
  const auto answer_to = [&](const char* command) {
    return answer_dashboard(bench.controller, command).line;
  };
  EXPECT_EQ(answer_to("PolyscopeVersion").rfind("URSoftware 3.15.8.106339 (", 0), 0U);
  EXPECT_EQ(answer_to("robotmode"), "Robotmode: RUNNING");
  EXPECT_EQ(answer_to("safetymode"), "Safetymode: NORMAL");
  EXPECT_EQ(answer_to("running"), "Program running: false");
  EXPECT_EQ(answer_to("get robot model"), "UR10");
  EXPECT_EQ(answer_to("safetystatus"), "could not understand: 'safetystatus'") << "5.4 and later";
  EXPECT_EQ(answer_to("is in remote control"), "could not understand: 'is in remote control'")
      << "no CB3 has it";
  EXPECT_EQ(answer_dashboard(newer.controller, "is in remote control").line, "true");
  EXPECT_EQ(answer_dashboard(newer.controller, "safetystatus").line, "Safetystatus: NORMAL");
  EXPECT_EQ(answer_to("popup hello"), "showing popup");
  EXPECT_EQ(answer_to("close popup"), "closing popup");
  EXPECT_EQ(answer_to("close safety popup"), "closing safety popup");
  bench.controller.run_script("def wait():\n  sleep(60)\nend\n");
  bench.run(0.1);
  EXPECT_EQ(answer_to("programState"), "PLAYING wait");
  EXPECT_EQ(answer_to("pause"), "Pausing program");
  EXPECT_EQ(answer_to("programState"), "PAUSED wait");
  EXPECT_EQ(answer_to("play"), "Starting program");
  EXPECT_EQ(answer_to("running"), "Program running: true");
  EXPECT_EQ(answer_to("stop"), "Stopped");
  EXPECT_EQ(answer_to("stop"), "Stopped") << "also when nothing runs: clients begin with it";
  EXPECT_EQ(answer_to("programState"), "STOPPED wait");
  bench.controller.protective_stop(153, "test");
  EXPECT_EQ(answer_to("safetymode"), "Safetymode: PROTECTIVE_STOP");
  bench.run(4.0);
  EXPECT_EQ(
      answer_to("unlock protective stop"),
      "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of protective stop "
      "before unlocking");
  bench.run(1.1);
  EXPECT_EQ(answer_to("unlock protective stop"), "Protective stop releasing");
  EXPECT_EQ(answer_to("safetymode"), "Safetymode: NORMAL");
  EXPECT_EQ(answer_to("power off"), "Powering off");
  EXPECT_EQ(answer_to("robotmode"), "Robotmode: POWER_OFF");
  EXPECT_EQ(answer_to("power on"), "Powering on");
  bench.run(3.5);
  EXPECT_EQ(answer_to("robotmode"), "Robotmode: IDLE");
  EXPECT_EQ(answer_to("brake release"), "Brake releasing");
  bench.run(2.0);
  EXPECT_EQ(answer_to("robotmode"), "Robotmode: RUNNING");
  EXPECT_TRUE(answer_dashboard(bench.controller, "quit").closes);
}

TEST(UrWire, ProgramsOfTheCellFileAreLoadedAndPlayed) {
  const RobotModel robot = read_robot("ur10");
  IdealPlant plant(ScriptBench::start());
  UrServerOptions options;
  options.programs = "hello.urp,external-control.urp";
  UrController controller(options, robot, plant);
  const auto answer_to = [&](const std::string& command) {
    return answer_dashboard(controller, command).line;
  };
  EXPECT_EQ(answer_to("get loaded program"), "No program loaded");
  EXPECT_EQ(answer_to("play"), "Failed to execute: play");
  EXPECT_EQ(answer_to("load other.urp"), "File not found: other.urp");
  EXPECT_EQ(answer_to("load external-control.urp"), "Loading program: external-control.urp");
  EXPECT_EQ(answer_to("get loaded program"), "Loaded program: /programs/external-control.urp");
  EXPECT_EQ(answer_to("running"), "Program running: false");
  EXPECT_EQ(answer_to("play"), "Starting program");
  for (int k = 0; k < 500; ++k) controller.step();
  EXPECT_EQ(answer_to("running"), "Program running: true") << "until somebody stops it";
  EXPECT_EQ(answer_to("programState"), "PLAYING external-control.urp");
  EXPECT_EQ(answer_to("pause"), "Pausing program");
  EXPECT_EQ(answer_to("play"), "Starting program");
  EXPECT_EQ(answer_to("stop"), "Stopped");
  EXPECT_EQ(answer_to("programState"), "STOPPED external-control.urp");
  EXPECT_EQ(answer_to("load /programs/hello.urp"), "Loading program: /programs/hello.urp");
  EXPECT_EQ(answer_to("power off"), "Powering off");
  EXPECT_EQ(answer_to("play"), "Failed to execute: play");
}

TEST(UrWire, TheDashboardPlaysTheLoadedProgram) {
  // UR's client library waits for "STOPPED <file>" after a load, and loads by other folders' names, too.
  const RobotModel robot = read_robot("ur10");
  IdealPlant plant(ScriptBench::start());
  UrServerOptions options;
  options.programs = "wait_program.urp";
  UrController controller(options, robot, plant);
  const auto answer_to = [&](const std::string& command) {
    return answer_dashboard(controller, command).line;
  };
  EXPECT_EQ(answer_to("programState"), "STOPPED <unnamed>");
  EXPECT_EQ(answer_to("load /ursim/programs/wait_program.urp"),
            "Loading program: /ursim/programs/wait_program.urp");
  EXPECT_EQ(answer_to("programState"), "STOPPED wait_program.urp");
  EXPECT_EQ(answer_to("isProgramSaved"), "true wait_program.urp");
  EXPECT_EQ(answer_to("load installation default.installation"),
            "Loading installation: default.installation");
  EXPECT_EQ(answer_to("load installation other.installation"), "File not found: other.installation");
  EXPECT_EQ(answer_to("load"), "could not understand: 'load'");
}

TEST(UrWire, LogAndReportsAreAnswered) {
  ScriptBench bench, old("3.12.1.90940");
  const auto answer_to = [&](const char* command) {
    return answer_dashboard(bench.controller, command).line;
  };
  EXPECT_EQ(answer_to("addToLog Testing Log:"), "Added log message");
  EXPECT_EQ(answer_to("addToLog "), "No log message to add");
  EXPECT_EQ(answer_to("addToLog"), "No log message to add");
  EXPECT_EQ(answer_to("saveLog"), "Log saved to disk");
  EXPECT_EQ(answer_to("generate flight report "), "Flight Report generated with id: 1");
  EXPECT_EQ(answer_to("generate flight report system"), "Flight Report generated with id: 2");
  EXPECT_EQ(answer_to("generate support file ."), "Completed successfully: ./ur_2014301234_support_file.zip");
  for (const char* later : {"saveLog", "generate flight report ", "generate support file ."})
    EXPECT_EQ(answer_dashboard(old.controller, later).line.rfind("could not understand", 0), 0U) << later;
}

TEST(UrWire, AnUnlockOnAScriptPortIsKeptUntilItMayBe) {
  // UR's client library sends it right after the stop and waits up to 5 s for the stop to end.
  ScriptBench bench;
  ScriptQueue port(bench.controller);
  const auto run = [&](double seconds) {
    for (double t = 0; t < seconds; t += bench.controller.period()) {
      port.turn();
      bench.run(bench.controller.period());
    }
  };
  port.put(1, "set unlock protective stop");
  run(0.1);
  bench.controller.protective_stop(153, "test");
  run(0.1);
  EXPECT_EQ(bench.controller.safety_mode, SafetyMode::kProtectiveStop);
  port.put(1, "set unlock protective stop");
  run(4.7);
  EXPECT_EQ(bench.controller.safety_mode, SafetyMode::kProtectiveStop) << "not before 5 s";
  run(0.4);
  EXPECT_EQ(bench.controller.safety_mode, SafetyMode::kNormal);
  bench.controller.protective_stop(153, "test");
  run(6.0);
  EXPECT_EQ(bench.controller.safety_mode, SafetyMode::kProtectiveStop) << "one order, one stop";
  port.put(1, "set unlock protective stop");
  bench.controller.emergency_stop();
  run(6.0);
  EXPECT_EQ(bench.controller.safety_mode, SafetyMode::kRobotEmergencyStop);
}

TEST(UrWire, AnUnlockOnAScriptPortIsCarriedOutInTheStepAtFiveSeconds) {
  for (const char* version : {"3.15.8.106339", "5.12.2.1101534"}) {
    ScriptBench bench(version);
    UrController& c = bench.controller;
    const int steps = static_cast<int>(5.0 / c.period() + 0.5);
    for (int offset = 0; offset < 40; ++offset) {
      c.step();
      c.protective_stop(153, "test");
      c.unlock_when_allowed();
      for (int k = 1; k < steps; ++k) c.step();
      ASSERT_EQ(c.safety_mode, SafetyMode::kProtectiveStop) << version << ", " << offset;
      c.step();
      ASSERT_EQ(c.safety_mode, SafetyMode::kNormal) << version << ", " << offset;
    }
  }
}

/// Safety modes that the messages since the last call report.
std::vector<int> reported_safety_modes(UrController& controller) {
  std::vector<int> modes;
  for (const auto& event : controller.take_events())
    if (event.kind == ControllerEvent::Kind::kSafetyMode) modes.push_back(event.code);
  return modes;
}

TEST(UrWire, EveryChangeOfTheSafetyModeIsReported) {
  // The messages are the only source of the safety mode for UR's PrimaryClient.
  ScriptBench bench;
  UrController& c = bench.controller;
  c.protective_stop(153, "test");
  EXPECT_THAT(reported_safety_modes(c), ElementsAre(3));
  EXPECT_FALSE(c.unlock_protective_stop());
  EXPECT_THAT(reported_safety_modes(c), ElementsAre()) << "refused";
  for (int k = 0; k < 630; ++k) c.step();
  EXPECT_TRUE(c.unlock_protective_stop());
  EXPECT_THAT(reported_safety_modes(c), ElementsAre(1));
  c.restart_safety();
  EXPECT_THAT(reported_safety_modes(c), ElementsAre()) << "it was normal before";
  c.emergency_stop();
  EXPECT_THAT(reported_safety_modes(c), ElementsAre(7));
  c.restart_safety();
  EXPECT_THAT(reported_safety_modes(c), ElementsAre(1));
}

TEST(UrWire, ProtectiveStopsAreWarningsToClients) {
  // UR's client library, doc/architecture/primary_client.rst: "protective stops are reported as warnings".
  ScriptBench bench;
  for (const int code : {153, 157, 206}) {
    bench.controller.safety_mode = SafetyMode::kNormal;
    bench.controller.protective_stop(code, "test");
    const auto events = bench.controller.take_events();
    ASSERT_EQ(events.back().kind, ControllerEvent::Kind::kErrorCode);
    EXPECT_EQ(events.back().level, 2) << code;
  }
}

TEST(UrWire, SpeedScalingLeavesTheSliderOut) {
  // Clients multiply speed_scaling by target_speed_fraction.
  ScriptBench bench;
  UrController& c = bench.controller;
  struct Speeds {
    double scaling = 0.0, fraction = 0.0;
  };
  const auto by_rtde = [&] {
    const auto read = [&](const char* name) {
      return std::get<double>(rtde_reader(*find_rtde_output(name))(c));
    };
    return Speeds{read("speed_scaling"), read("target_speed_fraction")};
  };
  const auto by_state = [&] {
    const std::string state = encode_robot_state(c);
    protocol::BigEndianReader in(std::string_view(state).substr(27));  // behind flags and modes
    Speeds speeds;
    in.get(speeds.fraction);
    in.get(speeds.scaling);
    return speeds;
  };
  c.speed_slider = 0.5;
  c.run_script("def s():\n  speedj([0.4,0,0,0,0,0], 4.0, 60)\nend\n");
  bench.run(1.0);
  EXPECT_NEAR(c.plant().qd[0], 0.2, 1e-9);
  for (const Speeds& speeds : {by_rtde(), by_state()}) {
    EXPECT_EQ(speeds.fraction, 0.5);
    EXPECT_EQ(speeds.scaling, 1.0);
    EXPECT_NEAR(0.4 * speeds.fraction * speeds.scaling, c.plant().qd[0], 1e-9);
  }
  EXPECT_TRUE(c.pause_program());
  bench.run(0.5);
  EXPECT_EQ(c.plant().qd[0], 0.0);
  EXPECT_EQ(by_rtde().fraction, 0.5);
  EXPECT_EQ(by_rtde().scaling, 0.0);
  EXPECT_TRUE(c.resume_program());
  c.speed_slider = 0.0;
  bench.run(0.5);
  EXPECT_EQ(c.plant().qd[0], 0.0);
  EXPECT_EQ(by_rtde().fraction, 0.0);
  EXPECT_EQ(by_rtde().scaling, 1.0);
}

TEST(UrWire, AStopThatCannotBeAcknowledged) {
  ControllerFaults faults;
  faults.refuse_unlock = true;
  ScriptBench bench("3.15.8.106339", faults);
  bench.controller.protective_stop(153, "test");
  bench.run(6.0);
  EXPECT_NE(answer_dashboard(bench.controller, "unlock protective stop").line, "Protective stop releasing");
  EXPECT_EQ(answer_dashboard(bench.controller, "safetymode").line, "Safetymode: PROTECTIVE_STOP");
  bench.controller.faults.refuse_unlock = false;
  EXPECT_EQ(answer_dashboard(bench.controller, "unlock protective stop").line, "Protective stop releasing");
}

TEST(UrWire, ScriptsAreCutFromTheStream) {
  ScriptCollector collector;
  std::vector<std::string> got;
  const std::string stream =
      "\n# note\npower on\ndef a():\n  if True:\n    sync()\n  end\nend\nrun "
      "program\nset_tcp(p[0,0,0,0,0,0])\n";
  for (const char byte : stream)
    for (auto& script : collector.feed({&byte, 1})) got.push_back(script);
  EXPECT_THAT(got, ElementsAre("power on", "def a():\n  if True:\n    sync()\n  end\nend\n", "run program",
                               "set_tcp(p[0,0,0,0,0,0])"));
  EXPECT_THAT(collector.feed("def b():\n  while True:\n  end\n"), ElementsAre());
  EXPECT_THAT(ScriptCollector().feed("def c():\r\n  sync()\r\nend\r\nstop program\r\n"),
              ElementsAre("def c():\r\n  sync()\r\nend\r\n", "stop program\r"));
  EXPECT_TRUE(collector.inside_program());
  EXPECT_EQ(collector.give_up(), "def b():\n  while True:\n  end\n");
  EXPECT_FALSE(collector.inside_program());
}

}  // namespace
}  // namespace stonestack::emulators
