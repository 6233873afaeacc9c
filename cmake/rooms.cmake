# A room is a folder of slipstream/ and the target slipstream::<room>. It may include headers of the
# rooms it USES and of no others; tests/rooms/rooms_test.cpp reads the list written here and fails
# when a source file includes another.
#
#   slipstream_room(phase
#     USES error image capture          rooms to its left
#     LINKS Eigen3::Eigen               libraries that its headers show
#     HIDES TBB::tbb                    libraries that only its sources see
#     LEAVES_OUT some.cpp)              sources that this build goes without
#
# The libraries are found when a room names them: cmake/libraries.cmake says where. A room that is
# compiled also hides fmt::fmt. Headers in folders below it, and those called *-inl.h, are its own
# affair and are not installed.
#
# Each room is installed as a component of the CMake package and as slipstream-<room>.pc.
include(${CMAKE_CURRENT_LIST_DIR}/libraries.cmake)

set(slipstream_package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/slipstream)
set_property(GLOBAL PROPERTY SLIPSTREAM_ROOMS "")
set_property(GLOBAL PROPERTY SLIPSTREAM_ROOM_LINES "")
set_property(GLOBAL PROPERTY SLIPSTREAM_PACKAGE_LINES "")

# Read once, not by each source: headers of the standard library and of the packages that all need.
# Sources include what they use all the same: CMAKE_DISABLE_PRECOMPILE_HEADERS goes without.
slipstream_find_library(Eigen3::Eigen REQUIRED)
slipstream_find_library(fmt::fmt REQUIRED)
set(slipstream_precompiled_headers
  <algorithm> <array> <atomic> <chrono> <cmath> <filesystem> <functional> <map> <memory> <mutex>
  <optional> <span> <string> <thread> <variant> <vector> <Eigen/Core> <Eigen/Geometry> <fmt/format.h>)
file(CONFIGURE OUTPUT precompiled.cpp CONTENT "")
add_library(slipstream_precompiled OBJECT ${CMAKE_CURRENT_BINARY_DIR}/precompiled.cpp)
target_compile_features(slipstream_precompiled PRIVATE cxx_std_20)
target_link_libraries(slipstream_precompiled PRIVATE Eigen3::Eigen fmt::fmt slipstream_warnings)
target_precompile_headers(slipstream_precompiled PRIVATE ${slipstream_precompiled_headers})

# Several sources are compiled as one: what they all read is read once. No two sources of a target
# may give one name to two things of their own. -DCMAKE_UNITY_BUILD=OFF compiles each alone.
function(slipstream_unity target batch)
  if(NOT DEFINED CMAKE_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${batch})
  endif()
endfunction()

function(slipstream_room room)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "USES;LINKS;HIDES;LEAVES_OUT")
  set(target slipstream_${room})
  set(folder ${PROJECT_SOURCE_DIR}/slipstream/${room})
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

  if(sources)
    add_library(${target} ${sources})
    slipstream_unity(${target} 10)
    set(scope PUBLIC)
    target_link_libraries(${target} PRIVATE ${arg_HIDES} $<BUILD_INTERFACE:slipstream_warnings>)
    # They hold for one set of options only: those of Aravis have -pthread.
    if(NOT library_options)
      target_precompile_headers(${target} REUSE_FROM slipstream_precompiled)
    endif()
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(slipstream::${room} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${room})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_include_directories(${target} ${scope} $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  if(hwy::hwy IN_LIST arg_HIDES)
    # Vector targets that are not compiled. SSSE3 is older than any machine worth it, AVX3_DL has
    # nothing more that is used here, and vectors of a length unknown to the compiler (SVE, RVV)
    # cannot be members of a class. Sanitized builds have AVX2 and what any machine has: the other
    # targets come from the same source, and they take long to compile.
    set(unused_targets HWY_SSSE3|HWY_AVX3_DL|HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128|HWY_RVV)
    if(CMAKE_CXX_FLAGS MATCHES "SLIPSTREAM_TWO_VECTOR_TARGETS")
      string(APPEND unused_targets "|HWY_SSE4|HWY_AVX3")
    endif()
    target_compile_definitions(${target} PRIVATE "HWY_DISABLED_TARGETS=(${unused_targets})")
  endif()
  list(TRANSFORM arg_USES PREPEND slipstream_ OUTPUT_VARIABLE used_targets)
  target_link_libraries(${target} ${scope} ${used_targets} ${arg_LINKS})

  list(JOIN arg_USES " " uses)
  set_property(GLOBAL APPEND PROPERTY SLIPSTREAM_ROOMS ${room})
  set_property(GLOBAL APPEND PROPERTY SLIPSTREAM_ROOM_LINES "${room}: ${uses}")
  if(SLIPSTREAM_INSTALL)
    slipstream_install_room(${room} "${sources}")
  endif()
endfunction()

# Part of slipstream_room(), whose arguments it reads.
function(slipstream_install_room room sources)
  file(GLOB headers CONFIGURE_DEPENDS ${folder}/*.h)
  list(FILTER headers EXCLUDE REGEX "-inl\\.h$")
  install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/slipstream/${room})
  install(TARGETS ${target} EXPORT slipstream-${room})
  install(EXPORT slipstream-${room} NAMESPACE slipstream:: FILE slipstream-${room}-targets.cmake
          DESTINATION ${slipstream_package_folder})
  string(JOIN " " libraries ${arg_LINKS} ${arg_HIDES})
  set_property(GLOBAL APPEND_STRING PROPERTY SLIPSTREAM_PACKAGE_LINES
    "set(slipstream_${room}_uses ${uses})\nset(slipstream_${room}_libraries ${libraries})\n")

  # Who links an archive links what it hides, too; a shared library brings that along.
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
  # The prefix is told from where the file lies, so that the folder can be moved.
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

# slipstream_shaders(reconstruct points): gpu/points.comp of the room to points.spirv.inc, the
# words of a constant that a source includes.
function(slipstream_shaders room)
  set(folder ${PROJECT_SOURCE_DIR}/slipstream/${room}/gpu)
  set(all "")
  foreach(shader IN LISTS ARGN)
    set(words ${PROJECT_BINARY_DIR}/shaders/${shader}.spirv.inc)
    if(SLIPSTREAM_GPU)
      add_custom_command(OUTPUT ${words}
        COMMAND ${GLSLC} -O --target-env=vulkan1.1 -mfmt=c -o ${words} ${folder}/${shader}.comp
        DEPENDS ${folder}/${shader}.comp ${folder}/stages.glsl ${folder}/gpu_stages.h
                ${folder}/../fused/stage_numbers.h)
    else()
      file(CONFIGURE OUTPUT ${words} CONTENT "{0}")  # for no device
    endif()
    target_sources(slipstream_${room} PRIVATE ${words})
    list(APPEND all ${words})
  endforeach()
  add_custom_target(slipstream_${room}_shaders DEPENDS ${all})
  target_include_directories(slipstream_${room} PRIVATE ${PROJECT_BINARY_DIR}/shaders)
endfunction()

# After the last room: what makes one package of them.
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

# One line a room, "decode: base codes frames", for the test.
function(slipstream_write_rooms file)
  get_property(lines GLOBAL PROPERTY SLIPSTREAM_ROOM_LINES)
  list(JOIN lines "\n" text)
  file(WRITE ${file} "${text}\n")
endfunction()
