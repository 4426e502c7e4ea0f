#pragma once
#include <string>
#include <vector>

#include "hardware/cell_config.hpp"
#include "report/picture.hpp"
#include "stonestack/report/results.hpp"

/// Private to report/: the page and the picture of a cell.
namespace stonestack::report {

/// Meshes of the picture of a cell: arm at its start, obstacles, limits, reach and what the camera sees as
/// thin bars.
[[nodiscard]] std::vector<DrawnMesh> drawn_cell(const CellPreview& cell);
/// From the front and the right, with all of the meshes in the picture.
[[nodiscard]] View view_of_cell(const std::vector<DrawnMesh>& meshes);
/// A box of limits as it is drawn: sides without an end go a little beyond the reach of the arm.
[[nodiscard]] Eigen::AlignedBox3d within_sight(const Eigen::AlignedBox3d& limits, const CellPreview& cell);

/// Data that the page's scripts draw (src/report/page/cell.js), as one line of JSON. Poses are
/// [x, y, z, qx, qy, qz, qw] in W, lengths in metres. `picture`: a data URI, or empty.
[[nodiscard]] std::string cell_page_data(const std::string& name, const CellConfig& config,
                                         const CellPreview& cell, const View& view,
                                         const std::string& picture);
/// The page around `data`; `text` stands there for a browser without scripts.
[[nodiscard]] std::string cell_page(const std::string& title, const std::string& text,
                                    const std::string& data);

}  // namespace stonestack::report
