#include "stonestack/simulation/ur/ur_controller_server.hpp"

namespace stonestack {
namespace {

constexpr FieldRange kTime{-1.0, 1e6};

}  // namespace

FieldList fields(ControllerFaults& f) {
  const std::string source = "facts/devices.md section 4";
  return {
      field("fieldbus_owns_lower_registers", f.fieldbus_owns_lower_registers, source),
      field("fieldbus_owns_outputs", f.fieldbus_owns_outputs, source),
      field("fieldbus_stops_programs", f.fieldbus_stops_programs, source),
      field("missing_fields", f.missing_fields, source),
      field("drop_rtde_at", f.drop_rtde_at, kTime, "s", source),
      field("close_rtde_at", f.close_rtde_at, kTime, "s", source),
      field("restart_rtde_at", f.restart_rtde_at, kTime, "s", source),
      field("boot_seconds", f.boot_seconds, kTime, "s", source),
      field("refuse_protocol_2", f.refuse_protocol_2, source),
      field("message_before_reply", f.message_before_reply, source),
      field("out_of_step", f.out_of_step, source),
      field("split_packets", f.split_packets, source),
      field("local_mode", f.local_mode, source),
      field("read_only_links", f.read_only_links, {0, 1000}, "", source),
      field("scripts_never_start", f.scripts_never_start, source),
      field("script_dies_after", f.script_dies_after, kTime, "s", source),
      field("protective_stop_at", f.protective_stop_at, kTime, "s", source),
      field("emergency_stop_at", f.emergency_stop_at, kTime, "s", source),
      field("speed_slider", f.speed_slider, {0.0, 1.0}, "", source),
      field("no_dashboard", f.no_dashboard, source),
      field("no_rtde", f.no_rtde, source),
      field("no_script_ports", f.no_script_ports, source),
      field("refuse_unlock", f.refuse_unlock, source),
  };
}

FieldList fields(UrServerOptions& o) {
  return join({{
                   field("address", o.address, "any 127.x.y.z"),
                   field("standard_ports", o.standard_ports, "30001 to 30004, 30011 to 30013, 29999"),
                   field("version", o.version, "PolyScope: 3.x is a CB3, 5.x an e-Series, 10.x PolyScope X"),
                   field("model", o.model, "as the Dashboard names it"),
                   field("serial", o.serial, "as the Dashboard names it"),
                   field("speed", o.speed, {0.01, 1000.0}, "", "times real time"),
                   field("powered", o.powered, "starts with the brakes released"),
               },
               nest("faults", fields(o.faults))});
}

}  // namespace stonestack
