# The wheel of ./dev release, unpacked: its program runs, its module loads.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
file(REMOVE_RECURSE ${WORK_FOLDER})
run(/usr/bin/python3 ${SOURCE_FOLDER}/packaging/bundle.py wheel ${BUILD_FOLDER} ${WORK_FOLDER})
file(GLOB wheel ${WORK_FOLDER}/*.whl)
file(ARCHIVE_EXTRACT INPUT ${wheel} DESTINATION ${WORK_FOLDER}/unpacked)
set(ENV{PYTHONPATH} ${WORK_FOLDER}/unpacked)

run(/usr/bin/python3 -m slipstream simulate ${WORK_FOLDER}/scan --camera 160x120)
run(/usr/bin/python3 -c "import importlib.metadata, slipstream
slipstream.reconstruct(slipstream.load_scan('${WORK_FOLDER}/scan')).write('${WORK_FOLDER}/cloud.ply')
[entry] = importlib.metadata.distribution('slipstream').entry_points
entry.load()")
