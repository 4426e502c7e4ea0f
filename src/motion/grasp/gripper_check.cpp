#include "motion/grasp/gripper_check.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::motion {

namespace {

double chosen(double users, double padding) {
  return users < 0.0 || padding == 0.0 ? padding : users;
}

}  // namespace

GripperCheck::GripperCheck(const PlanningScene& scene, double approach, int left_out)
    : table_z_(scene.table_z), table_padding_(padding_between(scene, "hand", "hand", "table", kNoPadding)) {
  for (const GripperBox& box : scene.gripper.boxes) {
    std::vector<Eigen::Vector3d> corners;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d sign(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
      corners.push_back(box.p_T_centre + sign.cwiseProduct(box.size));
      if (sign.z() < 0) corners.back().z() -= approach;
    }
    parts_.push_back({make_core(std::move(corners), 0.0), box.finger_side, box.advance});
  }
  for (std::size_t object = 0; object < scene.objects.size(); ++object) {
    if (static_cast<int>(object) == left_out) continue;
    for (const Mesh& mesh : scene.objects[object].pieces) {
      const Mesh piece_W = transformed(mesh, scene.objects[object].T_W_object);
      Piece piece{make_core(piece_W.vertices, 0.0), bounds(piece_W).center(), 0.0, static_cast<int>(object)};
      piece.user_padding = padding_between(scene, "hand", "hand", scene.objects[object].name, kNoPadding);
      for (const Eigen::Vector3d& p : piece_W.vertices)
        piece.radius = std::max(piece.radius, (p - piece.centre).norm());
      pieces_.push_back(std::move(piece));
    }
  }
}

bool GripperCheck::near(const Part& part, const Pose& T_W_part, const Piece& piece, double padding) const {
  const Segment axis{T_W_part * part.core.axis.a, T_W_part * part.core.axis.b};
  const double reach = part.core.reach + piece.radius + padding;
  if (squared_distance(axis, piece.centre) > reach * reach) return false;
  return hull_distance(part.core, to_bullet(T_W_part), piece.core, btTransform::getIdentity()) <= padding;
}

GripperCheck::Hit GripperCheck::sweep(const Pose& T_W_T, const Fingers& fingers, double padding) const {
  // Most grasps of a stone fall here, so only heights are worked out.
  const Eigen::RowVector3d up_T = T_W_T.linear().row(2);
  for (const Part& part : parts_) {
    const double min = table_z_ + chosen(table_padding_, padding) - T_W_T.translation().z() -
                       up_T.x() * part.finger_side * fingers.opening / 2 -
                       up_T.z() * part.advance * fingers.advance;
    for (const Eigen::Vector3d& p : part.core.points)
      if (up_T.dot(p) < min) return {Hit::What::kTheTable, -1};
  }
  const int object = first_object(T_W_T, fingers, padding);
  return object < 0 ? Hit{} : Hit{Hit::What::kObject, object};
}

int GripperCheck::first_object(const Pose& T_W_T, const Fingers& fingers, double padding) const {
  for (const Part& part : parts_) {
    const Pose T_W_part = T_W_T * Pose(Eigen::Translation3d(part.finger_side * fingers.opening / 2, 0,
                                                            part.advance * fingers.advance));
    for (const Piece& piece : pieces_)
      if (near(part, T_W_part, piece, chosen(piece.user_padding, padding))) return piece.object;
  }
  return -1;
}

bool GripperCheck::touches_object(const Pose& T_W_T, const Fingers& fingers, double padding) const {
  return first_object(T_W_T, fingers, padding) >= 0;
}

}  // namespace stonestack::motion
