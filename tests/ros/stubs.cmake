# What ros/CMakeLists.txt finds of ROS 2, by CMAKE_PROJECT_INCLUDE: targets of the headers here.
set(here ${CMAKE_CURRENT_LIST_DIR})
foreach(target rclcpp::rclcpp rclcpp_components::component rclcpp_lifecycle::rclcpp_lifecycle
        std_srvs::std_srvs)
  add_library(${target} INTERFACE IMPORTED)
  target_include_directories(${target} INTERFACE ${here})
  string(REGEX REPLACE "::.*" "" package ${target})
  set(${package}_TARGETS ${target})
endforeach()
foreach(package ament_cmake rclcpp rclcpp_components rclcpp_lifecycle std_srvs)
  file(WRITE ${CMAKE_BINARY_DIR}/found/${package}-config.cmake "")
  set(${package}_DIR ${CMAKE_BINARY_DIR}/found)
endforeach()

function(rclcpp_components_register_node library)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "PLUGIN;EXECUTABLE" "")
  add_executable(${arg_EXECUTABLE} ${here}/main.cpp)
  target_compile_features(${arg_EXECUTABLE} PRIVATE cxx_std_20)
  target_link_libraries(${arg_EXECUTABLE} PRIVATE ${library} rclcpp::rclcpp)
  install(TARGETS ${arg_EXECUTABLE} DESTINATION lib/${PROJECT_NAME})
endfunction()

function(ament_package)
endfunction()
