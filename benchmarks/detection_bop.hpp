#pragma once
#include <string>

#include "rooms.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::bench {

/// Detects in a data set of the BOP layout (models/obj_NNNNNN.ply in mm; SPLIT/NNNNNN/scene_camera.json and
/// depth/; test_targets_bop19.json if there is one) and writes the results as BOP's tools read them:
/// scene_id,im_id,obj_id,score,R,t,time with R by rows, t in mm, time in s an image. Prints how many of the
/// true poses (scene_gt.json, if there is one) were found within 5 deg and 5 mm. Throws FileError.
void run_bop(const std::string& folder, const std::string& split, const std::string& csv,
             const DetectionOptions& options);

}  // namespace stonestack::bench
