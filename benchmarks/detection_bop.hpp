#pragma once
#include <string>

#include "result_table.hpp"
#include "rooms.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::bench {

/// Detects in a data set of the BOP layout (models/obj_NNNNNN.ply in mm; SPLIT/NNNNNN/scene_camera.json and
/// depth/; test_targets_bop19.json if there is one) and writes the results as BOP's tools read them:
/// scene_id,im_id,obj_id,score,R,t,time with R by rows, t in mm, time in s an image. Reports how many of the
/// true poses (scene_gt.json, if there is one) were found, as the BOP toolkit scores them: recall of MSSD and
/// MSPD, averaged over ten thresholds, and of ADD-S below a tenth of the diameter; also how many were found
/// within 5 deg and 5 mm, and with ADD-S below 5 mm, and how often an object was reported where the truth of
/// an image does not have it. All but ADD-S take symmetries from models/models_info.json and are left empty
/// for an object that it does not have; where it names none of any object, they are those of the meshes.
/// Throws FileError.
void run_bop(const std::string& folder, const std::string& split, const std::string& csv,
             const DetectionOptions& options, Results& results);

}  // namespace stonestack::bench
