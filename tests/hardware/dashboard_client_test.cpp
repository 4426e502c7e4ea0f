#include "hardware/ur/dashboard_client.hpp"
#include "protocol/dashboard_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <mutex>

#include "hardware/fake_server.hpp"

namespace stonestack::hardware {
namespace {

using testing::HasSubstr;

const std::string kGreeting = "Connected: Universal Robots Dashboard Server\n";

using Answers = std::map<std::string, std::string>;

/// Answers lines out of a table; an unknown one with silence.
class FakeDashboard {
 public:
  explicit FakeDashboard(std::map<std::string, std::string> answers, std::string greeting = kGreeting)
      : answers_(std::move(answers)),
        greeting_(std::move(greeting)),
        server_([this](TcpStream& s, int) { serve(s); }) {}
  ~FakeDashboard() { server_.stop(); }
  [[nodiscard]] DashboardClient client() const {
    return DashboardClient(server_.endpoint(), {0.5, 0.2, 0.2});
  }
  [[nodiscard]] int connections() const { return server_.connections(); }

 private:
  void serve(TcpStream& stream) {
    for (const char byte : greeting_)
      if (!stream.write_all(std::string_view(&byte, 1), Deadline::in(1.0))) return;
    while (!server_.ending()) {
      const LineResult line = stream.read_line(1024, Deadline::in(0.02));
      if (line.status == IoStatus::kClosed) return;
      const auto answer = answers_.find(line.line);
      if (line && answer != answers_.end() && !stream.write_all(answer->second, Deadline::in(1.0))) return;
    }
  }

  std::map<std::string, std::string> answers_;
  std::string greeting_;
  FakeServer server_;
};

template <class Call>
std::string error_of(Call&& call) {
  try {
    static_cast<void>(call());
  } catch (const DeviceError& error) {
    return error.what();
  }
  return {};
}

TEST(DashboardClient, Cb3) {
  const FakeDashboard server({{"PolyscopeVersion", "URSoftware 3.15.8.106339 (Nov 05 2021)\n"},
                              {"robotmode", "Robotmode: RUNNING\n"},
                              {"safetymode", "Safetymode: NORMAL\r\n"},
                              {"running", "Program running: false\n"},
                              {"get robot model", "UR10\n"},
                              {"get serial number", "2014301234\n"},
                              {"power on", "Powering on\n"},
                              {"power off", "Powering off\n"},
                              {"brake release", "Brake releasing\n"},
                              {"stop", "Stopped\n"},
                              {"close popup", "closing popup\n"},
                              {"close safety popup", "closing safety popup\n"},
                              {"popup look here", "showing popup\n"},
                              {"unlock protective stop", "Protective stop releasing\n"}});
  DashboardClient client = server.client();
  EXPECT_EQ(client.version(), (UrVersion{3, 15, 8, 106339}));
  EXPECT_EQ(client.robot_mode(), "RUNNING");
  EXPECT_EQ(client.safety(), "NORMAL");
  EXPECT_FALSE(client.is_in_remote_control()) << "a CB3 has no remote mode";
  EXPECT_EQ(client.robot_model(), "UR10");
  EXPECT_EQ(client.serial_number(), "2014301234");
  EXPECT_FALSE(client.is_program_running());
  client.power_on();
  client.power_off();
  client.release_brakes();
  client.stop_program();
  client.close_popup();
  client.close_safety_popup();
  client.show_popup("look here");
  client.unlock_protective_stop();
  EXPECT_EQ(server.connections(), 1);
}

TEST(DashboardClient, ESeries) {
  const FakeDashboard server({{"PolyscopeVersion", "URSoftware 5.11.0.108249 (Mar 02 2021)\n"},
                              {"safetystatus", "Safetystatus: PROTECTIVE_STOP\n"},
                              {"is in remote control", "false\n"}});
  DashboardClient client = server.client();
  EXPECT_EQ(client.safety(), "PROTECTIVE_STOP");
  EXPECT_EQ(client.is_in_remote_control(), false);
}

TEST(DashboardClient, OddAnswersAreQuoted) {
  const FakeDashboard server(
      {{"robotmode", "Robot mood: fine\n"},
       {"running", "Program running: perhaps\n"},
       {"PolyscopeVersion", "who knows\n"},
       {"unlock protective stop", "Cannot unlock protective stop until 5s after occurrence\n"},
       {"stop", std::string(2000, 'x') + "\n"},
       {"power on", "\x01\x02\n"}});
  DashboardClient client = server.client();
  EXPECT_THAT(error_of([&] { return client.robot_mode(); }), HasSubstr("'Robot mood: fine'"));
  EXPECT_THAT(error_of([&] { return client.is_program_running(); }), HasSubstr("perhaps"));
  EXPECT_THAT(error_of([&] { return client.version(); }), HasSubstr("who knows"));
  EXPECT_THAT(error_of([&] { return client.unlock_protective_stop(), 0; }), HasSubstr("until 5s"));
  EXPECT_NE(error_of([&] { return client.stop_program(), 0; }), "");
  EXPECT_NE(error_of([&] { return client.power_on(), 0; }), "");
}

TEST(DashboardClient, ALateAnswerIsNotMatchedToTheNextRequest) {
  const FakeDashboard server(Answers{{"running", "Program running: true\n"}});
  DashboardClient client = server.client();
  EXPECT_THAT(error_of([&] { return client.robot_mode(); }), HasSubstr("no answer within"));
  EXPECT_TRUE(client.is_program_running());
  EXPECT_EQ(server.connections(), 2);
}

TEST(DashboardClient, NoServerOrAnotherOne) {
  const FakeDashboard other({}, "SSH-2.0\n");
  DashboardClient to_other = other.client();
  EXPECT_THAT(error_of([&] { return to_other.robot_mode(); }), HasSubstr("SSH-2.0"));
  const FakeDashboard silent({}, "");
  DashboardClient to_silent = silent.client();
  EXPECT_THAT(error_of([&] { return to_silent.robot_mode(); }), HasSubstr("no answer"));
  Endpoint closed;
  {
    const TcpListener listener{ListenOptions{}};
    closed = listener.endpoint();
  }
  DashboardClient to_closed(closed);
  EXPECT_THAT(error_of([&] { return to_closed.robot_mode(); }), HasSubstr("security settings"));
}

TEST(DashboardText, Version) {
  EXPECT_EQ(parse_polyscope_version("URSoftware 5.11.0.108249"), (UrVersion{5, 11, 0, 108249}));
  EXPECT_EQ(parse_polyscope_version("3.9.1 (x)"), (UrVersion{3, 9, 1, 0}));
  for (const char* bad : {"", "URSoftware", "URSoftware 5", "URSoftware 5.", "URSoftware 5.11", "v5.11.0",
                          "URSoftware 5.11.0x", "URSoftware 99999999999.1.1", "URSoftware -5.1.1.1"})
    EXPECT_FALSE(parse_polyscope_version(bad)) << bad;
}

}  // namespace
}  // namespace stonestack::hardware
