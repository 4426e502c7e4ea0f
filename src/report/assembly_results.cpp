#include <algorithm>
#include <cmath>
#include <string_view>

#include "report/drawn_arm.hpp"
#include "report/picture.hpp"
#include "report/text.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {

// From page/, by embed_files.cmake.
extern const std::string_view kSceneJs, kAssemblyJs, kThreeJs;

namespace {

constexpr double kDrawnSize = 0.6;     // m: size at which an assembly is drawn on the table
constexpr double kDrawnShrink = 0.82;  // of each block about its centre: one sees between them
constexpr double kDrawnForce = 0.25;   // of the drawn size: length of the largest force

std::string block_name(const AssemblyCheck& check, int body) {
  if (body == kTable) return "a support";
  return check.blocks[static_cast<std::size_t>(check.block_of_body[static_cast<std::size_t>(body)])].name;
}

nlohmann::json vector_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

double turn_degrees(const Eigen::Vector2d& direction) {
  return std::atan2(direction.y(), direction.x()) * 180.0 / M_PI;
}

/// How an assembly is drawn: scaled and moved to `site`, its lowest point there.
struct DrawnPlace {
  Eigen::Vector3d middle, site;
  double scale, height;
  DrawnPlace(const AssemblyCheck& check, const Eigen::Vector3d& to) : site(to) {
    Eigen::AlignedBox3d box;
    for (const CheckedBlock& block : check.blocks) box.extend(bounds(block.mesh));
    scale = kDrawnSize / box.sizes().maxCoeff();
    height = scale * box.sizes().z();
    middle = {box.center().x(), box.center().y(), box.min().z()};
  }
  [[nodiscard]] Eigen::Vector3d operator()(const Eigen::Vector3d& p) const {
    return site + scale * (p - middle);
  }
};

/// Drawn force for each in shares of the total weight [m].
double force_scale(const BlockBalance& balance) {
  double largest = 1e-9;
  for (const Eigen::Vector3d& f : balance.forces_W) largest = std::max(largest, f.norm());
  return kDrawnForce * kDrawnSize / largest;
}

/// One HTML file without links: the assembly in 3-D with contacts and forces.
std::string assembly_html(const AssemblyCheck& check) {
  const DrawnPlace place(check, Eigen::Vector3d::Zero());
  const BlockBalance& b = check.balance;
  nlohmann::json data = {{"text", assembly_text(check)},
                         {"height", place.height},
                         {"blocks", nlohmann::json::array()},
                         {"contacts", nlohmann::json::array()}};
  const int moving = b.moving < 0 ? -1 : check.block_of_body[static_cast<std::size_t>(b.moving)];
  for (std::size_t i = 0; i < check.blocks.size(); ++i) {
    const CheckedBlock& block = check.blocks[i];
    nlohmann::json p = nlohmann::json::array(), f = nlohmann::json::array();
    for (const Eigen::Vector3d& v : block.mesh.vertices)
      for (const double x : place(v)) p.push_back(std::round(1e5 * x) / 1e5);
    for (const Eigen::Vector3i& face : block.mesh.faces)
      for (const int corner : face) f.push_back(corner);
    data["blocks"].push_back({{"name", block.name},
                              {"support", block.support},
                              {"moving", static_cast<int>(i) == moving},
                              {"p", std::move(p)},
                              {"f", std::move(f)}});
  }
  const double scale = force_scale(b);
  for (std::size_t i = 0; i < b.contacts.size(); ++i)
    data["contacts"].push_back(
        {{"p", vector_json(place(b.contacts[i].p_W))}, {"force", vector_json(scale * b.forces_W[i])}});
  std::string text = data.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at))
    text.replace(at, 1, "\\u003c");
  std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>Assembly</title>\n<style>\n"
      "body{margin:0;font:14px sans-serif}#view{width:100vw;height:85vh}pre{margin:.5em "
      "1em}\n</style>\n<body>\n"
      "<div id=\"view\"></div>\n<pre id=\"text\"></pre>\n<script>";
  page.append(kThreeJs)
      .append("</script>\n<script>\nconst assembly = ")
      .append(text)
      .append(";\n</script>\n<script>\n");
  page.append(kSceneJs)
      .append("</script>\n<script>\n")
      .append(kAssemblyJs)
      .append("</script>\n</body>\n</html>\n");
  return page;
}

}  // namespace

std::string assembly_json(const AssemblyCheck& check) {
  const BlockBalance& b = check.balance;
  nlohmann::json out = {{"schema", "stonestack.assembly/1"},
                        {"friction", check.friction},
                        {"tilt_rad", check.tilt},
                        {"stands", b.stands},
                        {"unbalanced", b.unbalanced},
                        {"moving", nullptr},
                        {"margin_g", b.margin},
                        {"margin_direction", {b.direction.x(), b.direction.y()}},
                        {"min_friction", nullptr},
                        {"weakest_contact", nullptr},
                        {"interfaces_given", check.interfaces_given},
                        {"interfaces", check.interfaces},
                        {"blocks", nlohmann::json::array()},
                        {"contacts", nlohmann::json::array()}};
  if (b.moving >= 0) out["moving"] = block_name(check, b.moving);
  if (std::isfinite(b.min_friction)) out["min_friction"] = b.min_friction;
  if (b.weakest_contact >= 0) out["weakest_contact"] = b.weakest_contact;
  for (const CheckedBlock& block : check.blocks)
    out["blocks"].push_back(
        {{"name", block.name}, {"support", block.support}, {"volume", volume(block.mesh)}});
  for (std::size_t i = 0; i < b.contacts.size(); ++i) {
    const Contact& c = b.contacts[i];
    nlohmann::json item = {{"below", nullptr},
                           {"above", block_name(check, c.above)},
                           {"p_W", vector_json(c.p_W)},
                           {"n_W", vector_json(c.n_W)},
                           {"force_W", vector_json(b.forces_W[i])}};
    if (c.below != kTable) item["below"] = block_name(check, c.below);
    out["contacts"].push_back(std::move(item));
  }
  return document(out);
}

std::string assembly_text(const AssemblyCheck& check) {
  const BlockBalance& b = check.balance;
  const auto supports = std::count_if(check.blocks.begin(), check.blocks.end(),
                                      [](const CheckedBlock& block) { return block.support; });
  std::string text = format("assembly     %zu blocks, %d of them supports, %d interfaces %s; friction %g",
                            check.blocks.size(), static_cast<int>(supports), check.interfaces,
                            check.interfaces_given ? "from the file" : "found", check.friction);
  text += check.tilt != 0.0 ? format(", tilted by %.4g deg about y\n", check.tilt * 180 / M_PI) : "\n";
  if (b.stands) {
    text += "verdict      stands: forces and motions agree\n";
    text +=
        format("margin       bears %.3f g sideways, least when pushed towards %.0f deg (x is 0, y is 90)\n",
               b.margin, turn_degrees(b.direction));
  } else {
    text += format("verdict      falls: block %s keeps %.3g of its weight unbalanced\n",
                   block_name(check, b.moving).c_str(), b.unbalanced);
  }
  text += std::isfinite(b.min_friction) ? format("friction     holds down to %.3f\n", b.min_friction)
                                        : "friction     none up to 2 holds it\n";
  if (b.weakest_contact >= 0) {
    const Contact& c = b.contacts[static_cast<std::size_t>(b.weakest_contact)];
    text += format("weakest      %s on %s at (%.4g, %.4g, %.4g)\n", block_name(check, c.above).c_str(),
                   block_name(check, c.below).c_str(), c.p_W.x(), c.p_W.y(), c.p_W.z());
  }
  return text;
}

void draw_assembly(const std::string& path, const AssemblyCheck& check) {
  if (path.ends_with(".html")) return write_file(path, assembly_html(check));
  const DrawnPlace place(check, {0.7, 0.28, 0.005});
  std::vector<DrawnMesh> meshes;
  for (const CheckedBlock& block : check.blocks) {
    DrawnMesh drawn;
    const Eigen::Vector3d centre = bounds(block.mesh).center();
    drawn.mesh.faces = block.mesh.faces;
    for (const Eigen::Vector3d& v : block.mesh.vertices)
      drawn.mesh.vertices.push_back(place(centre + kDrawnShrink * (v - centre)));
    drawn.colour = block.support ? Eigen::Vector3d(0.35, 0.36, 0.38) : Eigen::Vector3d(0.75, 0.72, 0.66);
    meshes.push_back(std::move(drawn));
  }
  const BlockBalance& b = check.balance;
  const double scale = force_scale(b);
  for (std::size_t i = 0; i < b.contacts.size(); ++i) {
    const Eigen::Vector3d p = place(b.contacts[i].p_W);
    meshes.push_back({make_sphere(0.004, 1), Pose(Eigen::Translation3d(p)), {0.15, 0.35, 0.75}});
    const Eigen::Vector3d half = 0.5 * scale * b.forces_W[i];
    if (half.norm() > 1e-3) meshes.push_back(drawn_bar(p - half, p + half, 0.003, {0.85, 0.15, 0.10}));
  }
  View view;
  view.p_W_target = place.site + Eigen::Vector3d(0.0, 0.0, 0.5 * place.height);
  view.p_W_eye = view.p_W_target + Eigen::Vector3d(0.45, -1.15, 0.45);
  write_png(path, draw(meshes, view));
}

}  // namespace stonestack::report
