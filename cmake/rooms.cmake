# A room is a folder of slipstream/ and the target slipstream::<room>. It may include headers of the
# rooms it USES and of no others; tests/rooms/rooms_test.cpp reads the list written here and fails
# when a source file includes another.
#
#   slipstream_room(phase
#     USES error image capture          rooms to its left
#     LINKS Eigen3::Eigen               libraries that its headers show
#     HIDES TBB::tbb                    libraries that only its sources see
#     LEAVES_OUT some.cpp)              sources that this build goes without
set_property(GLOBAL PROPERTY SLIPSTREAM_ROOMS "")

function(slipstream_room room)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "USES;LINKS;HIDES;LEAVES_OUT")
  set(target slipstream_${room})
  set(folder ${PROJECT_SOURCE_DIR}/slipstream/${room})
  file(GLOB sources CONFIGURE_DEPENDS ${folder}/*.cpp)
  list(TRANSFORM arg_LEAVES_OUT PREPEND ${folder}/)
  list(REMOVE_ITEM sources ${arg_LEAVES_OUT})
  list(TRANSFORM arg_USES PREPEND slipstream_ OUTPUT_VARIABLE used_targets)

  if(sources)
    add_library(${target} ${sources})
    set(scope PUBLIC)
    # fmt serves messages only and is compiled in: who embeds a room does not need it.
    target_compile_definitions(${target} PRIVATE FMT_HEADER_ONLY=1)
    target_link_libraries(${target} PRIVATE ${arg_HIDES} $<BUILD_INTERFACE:slipstream_warnings>)
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(slipstream::${room} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${room})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_include_directories(${target} ${scope} $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                $<INSTALL_INTERFACE:include>)
  target_link_libraries(${target} ${scope} ${used_targets} ${arg_LINKS})
  install(TARGETS ${target} EXPORT slipstream-targets)
  install(DIRECTORY ${folder} DESTINATION include/slipstream FILES_MATCHING PATTERN "*.h")

  list(JOIN arg_USES " " uses)
  set_property(GLOBAL APPEND PROPERTY SLIPSTREAM_ROOMS "${room}: ${uses}")
endfunction()

# One line a room, "phase: error image capture", for the test.
function(slipstream_write_rooms file)
  get_property(rooms GLOBAL PROPERTY SLIPSTREAM_ROOMS)
  list(JOIN rooms "\n" text)
  file(WRITE ${file} "${text}\n")
endfunction()
