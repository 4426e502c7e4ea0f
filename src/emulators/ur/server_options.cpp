#include "emulators/ur/ur_controller_server.hpp"

namespace stonestack::emulators {
namespace {

constexpr FieldRange kTime{-1.0, 1e6};

}  // namespace

FieldList fields(ControllerFaults& f) {
  const auto mode = [](const char* note) { return std::string("docs/failure-modes.md ") + note; };
  return {
      field("fieldbus_owns_lower_registers", f.fieldbus_owns_lower_registers,
            mode("1: registers 0 to 23 answer IN_USE")),
      field("fieldbus_owns_outputs", f.fieldbus_owns_outputs, mode("2: outputs answer IN_USE")),
      field("fieldbus_stops_programs", f.fieldbus_stops_programs, mode("3: protective stop at every start")),
      field("missing_fields", f.missing_fields, mode("4: outputs, by commas, that are NOT_FOUND")),
      field("drop_rtde_at", f.drop_rtde_at, kTime, "s", mode("6: sessions fall silent")),
      field("close_rtde_at", f.close_rtde_at, kTime, "s", mode("6, 9: RTDE links are cut once")),
      field("restart_rtde_at", f.restart_rtde_at, kTime, "s", mode("7: RTDE closed for two seconds")),
      field("boot_seconds", f.boot_seconds, kTime, "s", mode("7: where its clock starts")),
      field("refuse_protocol_2", f.refuse_protocol_2, mode("8: protocol 1 only")),
      field("message_before_reply", f.message_before_reply, mode("8: a text before every reply")),
      field("out_of_step", f.out_of_step, mode("8: a wrong length after ten packages")),
      field("split_packets", f.split_packets, mode("8: byte by byte")),
      field("local_mode", f.local_mode, mode("11: e-Series, not in remote control")),
      field("read_only_links", f.read_only_links, {0, 1000}, "", mode("11: so many script links only read")),
      field("scripts_never_start", f.scripts_never_start, mode("12: scripts are taken and nothing happens")),
      field("script_dies_after", f.script_dies_after, kTime, "s",
            mode("13: run-time exception so long after a start")),
      field("protective_stop_at", f.protective_stop_at, kTime, "s", mode("15")),
      field("emergency_stop_at", f.emergency_stop_at, kTime, "s", mode("16")),
      field("speed_slider", f.speed_slider, {0.0, 1.0}, "", mode("17: 0 is a pause")),
      field("no_dashboard", f.no_dashboard, mode("21: port closed")),
      field("no_rtde", f.no_rtde, mode("22: port closed")),
      field("no_script_ports", f.no_script_ports, mode("22: ports closed")),
      field("refuse_unlock", f.refuse_unlock, mode("15: cannot be acknowledged")),
  };
}

FieldList fields(UrServerOptions& o) {
  return join({{
                   field("address", o.address, "any 127.x.y.z"),
                   field("standard_ports", o.standard_ports, "30001 to 30004, 30011 to 30013, 29999"),
                   field("version", o.version, "PolyScope: 3.x is a CB3, 5.x an e-Series, 10.x PolyScope X"),
                   field("model", o.model, "as the Dashboard names it"),
                   field("serial", o.serial, "as the Dashboard names it"),
                   field("safety_checksum", o.safety_checksum,
                         "of the safety configuration, eight hexadecimal digits; empty: it is not said"),
                   field("speed", o.speed, {0.01, 1000.0}, "", "times real time"),
                   field("programs", o.programs, "by commas, as hello.urp: what the Dashboard can load"),
                   field("external_control", o.external_control, {0, 65535}, "",
                         "port of a script sender on 127.0.0.1, for external_control.urp; 0: no such URCap"),
               },
               nest("faults", fields(o.faults))});
}

}  // namespace stonestack::emulators
