#pragma once
#include <memory>
#include <string>

#include "rooms.hpp"
#include "simulated_run.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/hardware/cell_file.hpp"

namespace stonestack::apps {

/// Content of a cell file: the devices, and, if `simulate`, how this program shall serve them itself.
struct CellFile {
  std::string path;
  bool simulate = false;
  CellConfig cell;
  SimulatedServersOptions servers;
};
/// `simulate` and the group `simulators`; CellConfig has the rest.
[[nodiscard]] FieldList cell_fields(CellFile& file);
/// A path, or the name of a cell that comes with stonestack, "loopback-ur10". Throws FileError.
[[nodiscard]] CellFile read_cell(const std::string& name);

/// Writes the addresses and ports where the servers really listen into the cell's client side.
void connect_to(const SimulatedServers& servers, CellConfig& cell);

}  // namespace stonestack::apps
