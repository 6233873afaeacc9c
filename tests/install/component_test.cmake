cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/bare.cmake)
file(REMOVE_RECURSE ${WORK_FOLDER})
hide_modules(${WORK_FOLDER}/modules)
set(configure ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/decoder -G Ninja
    -DCMAKE_PREFIX_PATH=${PREFIX} -DCMAKE_CXX_FLAGS=${FLAGS} ${without_packages})
run(${configure} -B ${WORK_FOLDER}/build)
run(${CMAKE_COMMAND} --build ${WORK_FOLDER}/build --target decoder)
run(${WORK_FOLDER}/build/decoder)

execute_process(COMMAND ${configure} -B ${WORK_FOLDER}/build-with-files -DMORE_ROOMS=io
                RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(result EQUAL 0 OR NOT output MATCHES "io needs PkgConfig::yaml-cpp")
  message(FATAL_ERROR "The room io was to be missing:\n${output}")
endif()
