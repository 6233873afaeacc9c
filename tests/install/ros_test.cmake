# The package for ROS 2 on the installed library, by headers that stand in for ROS 2's.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
file(REMOVE_RECURSE ${WORK_FOLDER})
file(MAKE_DIRECTORY ${WORK_FOLDER}/saved)
run(${CMAKE_COMMAND} -S ${SOURCE_FOLDER}/ros -B ${WORK_FOLDER}/build -G Ninja
    -DCMAKE_PREFIX_PATH=${PREFIX} -DCMAKE_CXX_FLAGS=${FLAGS}\ -Wall\ -Wextra\ -Werror
    -DCMAKE_PROJECT_INCLUDE=${SOURCE_FOLDER}/tests/ros/stubs.cmake)
run(${CMAKE_COMMAND} --build ${WORK_FOLDER}/build)
run(${CMAKE_COMMAND} --install ${WORK_FOLDER}/build --prefix ${WORK_FOLDER}/installed)
foreach(file lib/libscanner_node.so lib/slipstream_ros/scanner
        share/slipstream_ros/config/scanner.yaml share/slipstream_ros/launch/scanner.launch.py
        share/slipstream_ros/rviz/scanner.rviz)
  if(NOT EXISTS ${WORK_FOLDER}/installed/${file})
    message(FATAL_ERROR "${file} is not installed")
  endif()
endforeach()
run(${PREFIX}/bin/slipstream record --source virtual --world ideal --camera 160x120 --strategy pmp
    --steps 4 --frames 12 --rate 0 -o ${WORK_FOLDER}/recording.slip)
run(${WORK_FOLDER}/build/scanner ${WORK_FOLDER}/recording.slip ${WORK_FOLDER}/saved)
