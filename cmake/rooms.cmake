# A room is a folder of src/ and the target slipstream::<room>. Its public HEADERS are in
# include/slipstream/ and are all that is installed. It may include only headers of the rooms it
# USES; tests/rooms/rooms_test.cpp reads the lists written here and fails if a source includes any
# other.
#
#   slipstream_room(decode
#     HEADERS maps phase_decoder        include/slipstream/maps.h and so on
#     USES base codes frames            rooms declared before it
#     LINKS Eigen3::Eigen               libraries that its headers include
#     HIDES TBB::tbb                    libraries that only its sources include
#     LEAVES_OUT some.cpp               sources not to compile
#     READS_UNTRUSTED)                  checks each index, see hardening.cmake
#
# cmake/libraries.cmake says where to find each library. A room with sources also hides fmt::fmt.
#
# Each room is installed as a component of the CMake package and as slipstream-<room>.pc.
include(${CMAKE_CURRENT_LIST_DIR}/libraries.cmake)

set(slipstream_package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/slipstream)
set_property(GLOBAL PROPERTY SLIPSTREAM_ROOMS "")
set_property(GLOBAL PROPERTY SLIPSTREAM_ROOM_LINES "")
set_property(GLOBAL PROPERTY SLIPSTREAM_PACKAGE_LINES "")

# Precompiled: standard headers and those of libraries that every room uses. Sources still include all
# that they use, so CMAKE_DISABLE_PRECOMPILE_HEADERS works.
slipstream_find_library(Eigen3::Eigen REQUIRED)
slipstream_find_library(fmt::fmt REQUIRED)
set(slipstream_precompiled_headers
  <algorithm> <array> <atomic> <chrono> <cmath> <filesystem> <functional> <map> <memory> <mutex>
  <optional> <span> <string> <thread> <variant> <vector> <Eigen/Core> <Eigen/Geometry> <fmt/format.h>)
file(CONFIGURE OUTPUT precompiled.cpp CONTENT "")
foreach(target slipstream_precompiled slipstream_precompiled_checked)
  add_library(${target} OBJECT EXCLUDE_FROM_ALL ${CMAKE_CURRENT_BINARY_DIR}/precompiled.cpp)
  target_compile_features(${target} PRIVATE cxx_std_20)
  target_link_libraries(${target} PRIVATE Eigen3::Eigen fmt::fmt slipstream_warnings)
  target_precompile_headers(${target} PRIVATE ${slipstream_precompiled_headers})
endforeach()
target_compile_definitions(slipstream_precompiled_checked PRIVATE ${slipstream_assertions})

# Compiles several sources as one, to parse shared headers once. Sources of a target must not reuse
# each other's file-local names. -DCMAKE_UNITY_BUILD=OFF compiles each alone.
function(slipstream_unity target batch)
  if(NOT DEFINED CMAKE_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${batch})
  endif()
endfunction()

function(slipstream_room room)
  cmake_parse_arguments(PARSE_ARGV 1 arg "READS_UNTRUSTED" "" "HEADERS;USES;LINKS;HIDES;LEAVES_OUT")
  set(target slipstream_${room})
  set(folder ${PROJECT_SOURCE_DIR}/src/${room})
  file(GLOB sources CONFIGURE_DEPENDS ${folder}/*.cpp ${folder}/*/*.cpp)
  list(TRANSFORM arg_LEAVES_OUT PREPEND ${folder}/)
  list(REMOVE_ITEM sources ${arg_LEAVES_OUT})
  if(sources)
    list(PREPEND arg_HIDES fmt::fmt)
  endif()
  set(library_options "")
  foreach(library IN LISTS arg_LINKS arg_HIDES)
    slipstream_find_library(${library} REQUIRED)
    get_target_property(options ${library} INTERFACE_COMPILE_OPTIONS)
    if(options)
      list(APPEND library_options ${options})
    endif()
  endforeach()

  # Compiled already, by the release build: for the sanitized tests of every change.
  list(TRANSFORM arg_USES PREPEND slipstream_ OUTPUT_VARIABLE used_targets)
  set(compiled "")
  if(sources AND room IN_LIST SLIPSTREAM_TAKEN_ROOMS)
    set(compiled ${target}_compiled)
    add_library(${compiled} STATIC IMPORTED)
    set_target_properties(${compiled} PROPERTIES
      IMPORTED_LOCATION ${PROJECT_SOURCE_DIR}/build/lib${target}.a
      INTERFACE_LINK_LIBRARIES "${used_targets};${arg_LINKS};${arg_HIDES}")
    set(sources ${CMAKE_CURRENT_BINARY_DIR}/precompiled.cpp)
  endif()

  if(sources)
    add_library(${target} ${sources})
    slipstream_unity(${target} 10)
    set(scope PUBLIC)
    target_link_libraries(${target} PRIVATE ${arg_HIDES} $<BUILD_INTERFACE:slipstream_warnings>)
    set(precompiled slipstream_precompiled)
    if(arg_READS_UNTRUSTED AND slipstream_assertions)
      target_compile_definitions(${target} PRIVATE ${slipstream_assertions})
      set(precompiled slipstream_precompiled_checked)
    endif()
    # Precompiled headers require equal options; Aravis, for one, adds -pthread.
    if(NOT library_options)
      target_precompile_headers(${target} REUSE_FROM ${precompiled})
    endif()
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(slipstream::${room} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${room})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_include_directories(${target} ${scope} $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                                                $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  if(sources)
    target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  endif()
  if(hwy::hwy IN_LIST arg_HIDES)
    # Vector targets not compiled: SSSE3 machines are too old to matter, AVX3_DL adds no instruction
    # used here, and vectors of unknown length (SVE, RVV) cannot be class members. Builds for checks
    # have only AVX2 and the baseline: the others compile slowly from the same source.
    set(unused_targets HWY_SSSE3|HWY_AVX3_DL|HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128|HWY_RVV)
    if(CMAKE_CXX_FLAGS MATCHES "SLIPSTREAM_TWO_VECTOR_TARGETS")
      string(APPEND unused_targets "|HWY_SSE4|HWY_AVX3")
    endif()
    target_compile_definitions(${target} PRIVATE "HWY_DISABLED_TARGETS=(${unused_targets})")
    # On Windows GCC stores vectors of 32 and 64 bytes on a stack aligned to 16 as if it were aligned
    # to them, and the program crashes; the assembler makes these moves unaligned.
    if(MINGW AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      target_compile_options(${target} PRIVATE -Wa,-muse-unaligned-vector-move)
    endif()
  endif()
  target_link_libraries(${target} ${scope} ${compiled} ${used_targets} ${arg_LINKS})

  list(JOIN arg_USES " " uses)
  set_property(GLOBAL APPEND PROPERTY SLIPSTREAM_ROOMS ${room})
  list(JOIN arg_HEADERS " " headers)
  set_property(GLOBAL APPEND PROPERTY SLIPSTREAM_ROOM_LINES "${room}: ${uses}" "${room} has ${headers}")
  if(SLIPSTREAM_INSTALL)
    slipstream_install_room(${room} "${sources}")
  endif()
endfunction()

# Part of slipstream_room(); reads its variables.
function(slipstream_install_room room sources)
  list(TRANSFORM arg_HEADERS REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/include/slipstream/\\1.h"
       OUTPUT_VARIABLE headers)
  install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/slipstream)
  install(TARGETS ${target} EXPORT slipstream-${room})
  install(EXPORT slipstream-${room} NAMESPACE slipstream:: FILE slipstream-${room}-targets.cmake
          DESTINATION ${slipstream_package_folder})
  string(JOIN " " libraries ${arg_LINKS} ${arg_HIDES})
  set_property(GLOBAL APPEND_STRING PROPERTY SLIPSTREAM_PACKAGE_LINES
    "set(slipstream_${room}_uses ${uses})\nset(slipstream_${room}_libraries ${libraries})\n")

  # Users of a static library must link its hidden libraries too; a shared library links them itself.
  set(hidden "")
  if(BUILD_SHARED_LIBS)
    set(hidden .private)
  endif()
  foreach(variable requires requires.private libs libs.private)
    set(${variable} "")
  endforeach()
  if(sources)
    list(APPEND libs -l${target})
  endif()
  list(TRANSFORM arg_USES PREPEND slipstream- OUTPUT_VARIABLE requires)
  foreach(library IN LISTS arg_LINKS arg_HIDES)
    set(visibility "")
    if(NOT library IN_LIST arg_LINKS)
      set(visibility ${hidden})
    endif()
    slipstream_library_origin(${library} origin)
    list(GET origin 0 module)
    if(module MATCHES "^-l")
      list(APPEND libs${visibility} ${module})
    else()
      list(APPEND requires${visibility} ${module})
    endif()
  endforeach()
  foreach(variable requires requires.private libs libs.private)
    list(REMOVE_DUPLICATES ${variable})
    list(JOIN ${variable} " " ${variable})
  endforeach()
  # Paths are relative to the .pc file, so the installation can be moved.
  set(modules_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  cmake_path(ABSOLUTE_PATH CMAKE_INSTALL_LIBDIR BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX}
             OUTPUT_VARIABLE libraries_folder)
  cmake_path(ABSOLUTE_PATH CMAKE_INSTALL_INCLUDEDIR BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX}
             OUTPUT_VARIABLE headers_folder)
  cmake_path(RELATIVE_PATH headers_folder BASE_DIRECTORY ${libraries_folder}/pkgconfig)
  set(module ${PROJECT_BINARY_DIR}/pkgconfig/slipstream-${room}.pc)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/slipstream-room.pc.in ${module} @ONLY)
  install(FILES ${module} DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()

# slipstream_shaders(reconstruct points): compiles the room's gpu/points.comp to points.spirv.inc,
# an initialiser list that a source includes.
function(slipstream_shaders room)
  set(folder ${PROJECT_SOURCE_DIR}/src/${room}/gpu)
  set(all "")
  foreach(shader IN LISTS ARGN)
    set(words ${PROJECT_BINARY_DIR}/shaders/${shader}.spirv.inc)
    if(SLIPSTREAM_GPU)
      add_custom_command(OUTPUT ${words}
        COMMAND ${GLSLC} -O --target-env=vulkan1.1 -mfmt=c -o ${words} ${folder}/${shader}.comp
        DEPENDS ${folder}/${shader}.comp ${folder}/stages.glsl ${folder}/gpu_stages.h
                ${folder}/../fused/stage_numbers.h)
    else()
      file(CONFIGURE OUTPUT ${words} CONTENT "{0}")  # never used
    endif()
    target_sources(slipstream_${room} PRIVATE ${words})
    list(APPEND all ${words})
  endforeach()
  add_custom_target(slipstream_${room}_shaders DEPENDS ${all})
  target_include_directories(slipstream_${room} PRIVATE ${PROJECT_BINARY_DIR}/shaders)
endfunction()

# Installs the CMake package; called after the last room.
function(slipstream_install_package)
  get_property(rooms GLOBAL PROPERTY SLIPSTREAM_ROOMS)
  list(JOIN rooms " " rooms)
  get_property(rooms_and_needs GLOBAL PROPERTY SLIPSTREAM_PACKAGE_LINES)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/slipstream-config.cmake.in
    ${PROJECT_BINARY_DIR}/slipstream-config.cmake INSTALL_DESTINATION ${slipstream_package_folder})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/slipstream-config-version.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/slipstream-config.cmake
                ${PROJECT_BINARY_DIR}/slipstream-config-version.cmake
          DESTINATION ${slipstream_package_folder})
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/libraries.cmake DESTINATION ${slipstream_package_folder}
          RENAME slipstream-libraries.cmake)
endfunction()

# Two lines per room, "decode: base codes frames" and "decode has maps phase_decoder", for tests/rooms.
function(slipstream_write_rooms file)
  get_property(lines GLOBAL PROPERTY SLIPSTREAM_ROOM_LINES)
  list(JOIN lines "\n" text)
  file(WRITE ${file} "${text}\n")
endfunction()
