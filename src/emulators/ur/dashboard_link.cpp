#include "emulators/ur/dashboard_session.hpp"
#include "emulators/ur/server_links.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr std::size_t kDashboardLongestLine = 4096;

}  // namespace

DashboardLink::DashboardLink(TcpStream stream, UrController& controller)
    : ServerLink(std::move(stream), controller) {
  send(concat(kDashboardGreeting, "\n"));
}

void DashboardLink::receive(std::string_view bytes) {
  std::string answers;
  bool closes = false;
  for (const char c : bytes) {
    if (c != '\n') {
      closes = line_.size() >= kDashboardLongestLine;
      if (closes) break;
      if (c != '\r') line_ += c;
      continue;
    }
    const DashboardAnswer answer = answer_dashboard(controller(), line_);
    line_.clear();
    answers += answer.line + "\n";
    closes = answer.closes;
    if (closes) break;
  }
  send(answers);
  if (closes) close();
}

}  // namespace stonestack::emulators
