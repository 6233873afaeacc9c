# Where to find the libraries that rooms link. The build and the installed package both read this,
# so a program finds only the libraries that its rooms need.
set(slipstream_libraries
  # target                       pkg-config      find_package (if omitted: pkg-config)
  "Eigen3::Eigen                 eigen3          Eigen3"
  "fmt::fmt                      fmt             fmt"
  "TBB::tbb                      tbb             TBB"
  "hwy::hwy                      libhwy          hwy"
  "opencv_core                   opencv4         OpenCV COMPONENTS core"
  "opencv_imgproc                opencv4         OpenCV COMPONENTS imgproc"
  "opencv_calib3d                opencv4         OpenCV COMPONENTS calib3d"
  "opencv_features2d             opencv4         OpenCV COMPONENTS features2d"
  "opencv_objdetect              opencv4         OpenCV COMPONENTS objdetect"
  "opencv_aruco                  opencv4         OpenCV COMPONENTS aruco"
  "opencv_structured_light       opencv4         OpenCV OPTIONAL_COMPONENTS structured_light"
  "opencv_phase_unwrapping       opencv4         OpenCV OPTIONAL_COMPONENTS phase_unwrapping"
  "PkgConfig::yaml-cpp           yaml-cpp"
  "pugixml::pugixml              pugixml         pugixml"
  "tinyobjloader::tinyobjloader  tinyobjloader   tinyobjloader"
  "nlohmann_json::nlohmann_json  nlohmann_json   nlohmann_json"
  "PNG::PNG                      libpng          PNG"
  "TIFF::TIFF                    libtiff-4       TIFF"
  "PkgConfig::libdeflate         libdeflate"
  "PkgConfig::lemon              lemon"
  "PkgConfig::turbojpeg          libturbojpeg"
  "PkgConfig::zstd               libzstd"
  "Boost::headers                -lpthread       Boost CONFIG"
  "CycloneDDS::ddsc              CycloneDDS      CycloneDDS"
  "Ceres::ceres                  -lceres         Ceres"
  "PkgConfig::aravis             aravis-0.8"
  "PkgConfig::gio                gio-2.0"
  "PkgConfig::hidapi             hidapi-hidraw"
  "glfw                          glfw3           glfw3"
  "PkgConfig::epoxy              epoxy"
  "PkgConfig::imgui              imgui")

# The words of the library's line above, without the target.
function(slipstream_library_origin library result)
  foreach(line IN LISTS slipstream_libraries)
    separate_arguments(words UNIX_COMMAND "${line}")
    list(POP_FRONT words target)
    if(target STREQUAL library)
      set(${result} ${words} PARENT_SCOPE)
      return()
    endif()
  endforeach()
  message(FATAL_ERROR "cmake/libraries.cmake has no line for ${library}")
endfunction()

# slipstream_find_library(TBB::tbb REQUIRED) or QUIET: defines the target if the library is found.
function(slipstream_find_library library mode)
  if(TARGET ${library})
    return()
  endif()
  slipstream_library_origin(${library} origin)
  list(POP_FRONT origin module)
  if(origin)
    find_package(${origin} ${mode})
  else()
    find_package(PkgConfig ${mode})
    if(PkgConfig_FOUND)
      string(REPLACE "PkgConfig::" "" prefix ${library})
      pkg_check_modules(${prefix} ${mode} IMPORTED_TARGET ${module})
    endif()
  endif()
endfunction()
