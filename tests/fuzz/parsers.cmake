# What the fuzz targets need of the library, for clang's libFuzzer: without PCL, OMPL, Embree and the physics, so
# that it is built in minutes. A parser that begins to need another file of the library misses it here when it
# is linked.
pkg_check_modules(URDFDOM REQUIRED IMPORTED_TARGET urdfdom)

# stonestack_files(VARIABLE ROOM FILE...): adds src/ROOM/FILE.cpp to the list
macro(stonestack_files list room)
  foreach(name ${ARGN})
    list(APPEND ${list} "${PROJECT_SOURCE_DIR}/src/${room}/${name}.cpp")
  endforeach()
endmacro()

# What reads foreign bytes: instrumented.
stonestack_files(parsers core field_file file options yaml)
stonestack_files(parsers geometry bop_folder cloud_file depth_image depth_png depth_sequence lzf mesh_file mesh_import obj obstacle pair_padding pcd
  ply ply_header pose_yaml stl)
stonestack_files(parsers stone scene_file scene_text stone_yaml surface_file)
stonestack_files(parsers search wall/wall_target)
stonestack_files(parsers kinematics calibration dh hand_eye_file gripper_file mesh_uri robot_model urdf urdf_shapes xml_guard)
stonestack_files(parsers physics block_assembly)
stonestack_files(parsers protocol dashboard_text frame_stream ft_frames gripper_text modbus_frame primary_wire rtde_wire z16)
stonestack_files(parsers hardware cell_edit cell_file cell_limits camera/camera_settings camera/recording camera/v4l2_recording
  robotiq/gripper_words)
stonestack_files(parsers motion pick_and_place/problem_file)
stonestack_files(parsers urscript builtins builtins_poses builtins_text compile_expressions compile_statements lexer
  machine machine_calls script_collector value)
stonestack_files(parsers emulators robotiq/gripper_plant robotiq/gripper_registers robotiq/two_finger_registers
  ur/builtins_flow ur/builtins_io ur/builtins_kinematics ur/builtins_motion ur/builtins_sockets ur/builtins_state
  ur/controller ur/controller_programs ur/dashboard_session ur/external_control ur/robot_library ur/rtde_access
  ur/rtde_session)

# What these stand on: no foreign byte is read there, so it is built as fast as can be.
stonestack_files(others core byte_stream clock data error log prefix random serial socket spelling time_limit)
stonestack_files(others geometry capsule capsule_cover cloud depth_unit convex_hull convex_pieces enclosing_shapes mass_properties mesh mesh_edges mesh_shapes pose surface_tree)
stonestack_files(others kinematics calibrated_inverse closed_form forward hand_eye hand_eye_methods inverse jacobian joints polish tool_workspace)
stonestack_files(others hardware cell camera/realsense_absent camera/realsense_camera camera/recorded_camera
  camera/stream_camera camera/v4l2_camera camera/v4l2_kernel hold_watch robotiq/ft_link robotiq/ft_sensor robotiq/modbus
  robotiq/modbus_rtu robotiq/modbus_tcp robotiq/three_finger_gripper robotiq/two_finger_gripper robotiq/urcap_link ur/dashboard_client ur/primary_client
  ur/rtde_client ur/rtde_session ur/run_program trajectory_gate ur/script_gate ur/script_guard ur/script_text
  ur/script_writer ur/ur_arm ur/ur_force_torque ur/ur_link ur/ur_status wrench_readings)
stonestack_files(others protocol rtde_fields)
stonestack_files(others motion collision/planning_scene collision/read_gripper)
stonestack_files(others emulators ur/arm_geometry ur/ideal_plant ur/motion ur/motion_step ur/profile)

# stonestack_rest(ROOM FILE...): what the targets do not need of a room. A new file is in one of these lists or the other, so
# that what a target misses is seen here and not when it is linked.
function(stonestack_rest room)
  file(STRINGS "${PROJECT_SOURCE_DIR}/src/${room}/CMakeLists.txt" text)
  string(REGEX MATCHALL "[a-z0-9_/]+\\.cpp" sources "${text}")
  set(not_listed)
  foreach(source ${sources})
    string(REGEX REPLACE "\\.cpp$" "" name "${source}")
    set(file "${PROJECT_SOURCE_DIR}/src/${room}/${source}")
    if(NOT file IN_LIST parsers AND NOT file IN_LIST others AND NOT name IN_LIST ARGN)
      list(APPEND not_listed ${name})
    endif()
  endforeach()
  if(not_listed)
    message(FATAL_ERROR "src/${room}: ${not_listed}: in no list of tests/fuzz/parsers.cmake; add it to `parsers` if it reads foreign "
      "bytes, to `others` if these need it, or else to stonestack_rest(${room})")
  endif()
endfunction()
stonestack_rest(protocol)
stonestack_rest(urscript)
stonestack_rest(hardware camera/realsense_library read_only_devices setup_cell ur/joint_reader ur/rearm)
stonestack_rest(emulators camera/camera_simulator camera/world_depth cell_file robotiq/ft_serial
  robotiq/ft_simulator robotiq/ft_source robotiq/gripper_simulator robotiq/modbus_server
  robotiq/two_finger_simulator robotiq/world_gripper robotiq/world_wrench simulated_servers tcp_service
  ur/dashboard_link ur/plant ur/primary_messages ur/rtde_link ur/script_link ur/script_queue ur/server_link
  ur/server_options ur/state_messages ur/ur_controller_server)

function(stonestack_part target)
  add_library(${target} STATIC ${ARGN})
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  target_include_directories(${target} PUBLIC "${PROJECT_SOURCE_DIR}/include" "${PROJECT_SOURCE_DIR}/src")
  target_include_directories(${target} SYSTEM PRIVATE ${BULLET_INCLUDE_DIRS})
  target_link_libraries(${target} PUBLIC stonestack_settings Eigen3::Eigen PRIVATE spdlog::spdlog yaml-cpp
    nlohmann_json::nlohmann_json TBB::tbb PNG::PNG gmp mpfr HACD-float64 CGAL::CGAL PkgConfig::URDFDOM)
  target_precompile_headers(${target} PRIVATE <Eigen/Geometry> <functional> <map> <sstream> <string> <vector>)
endfunction()

stonestack_part(stonestack_parsers ${parsers})
target_compile_options(stonestack_parsers PRIVATE -fsanitize=fuzzer-no-link)
stonestack_part(stonestack_others ${others})
target_compile_options(stonestack_others PRIVATE -O0 -g0 -fno-sanitize=all)
target_link_libraries(stonestack_parsers PUBLIC stonestack_others)
target_link_libraries(stonestack_others PRIVATE stonestack_parsers)  # either way: rooms are cut across here
