# Compiles the decoder anew, for one vector target and without optimisation, as that is quick.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/bare.cmake)
file(REMOVE_RECURSE ${WORK_FOLDER})
hide_modules(${WORK_FOLDER}/modules)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/decoder -B ${WORK_FOLDER}/build -G Ninja
    -DSLIPSTREAM_FOLDER=${SOURCE_FOLDER} -DCMAKE_CXX_FLAGS=-DHWY_COMPILE_ONLY_STATIC
    ${without_packages})
run(${CMAKE_COMMAND} --build ${WORK_FOLDER}/build --target decoder)
run(${WORK_FOLDER}/build/decoder)
