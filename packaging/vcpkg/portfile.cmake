# Overlay port of this source tree: vcpkg install slipstream --overlay-ports=packaging/vcpkg
set(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../..")
vcpkg_check_features(OUT_FEATURE_OPTIONS parts
  FEATURES
    io SLIPSTREAM_IO
    calibrate SLIPSTREAM_CALIBRATE)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    ${parts}
    -DSLIPSTREAM_APP=OFF
    -DSLIPSTREAM_CAMERAS=OFF
    -DSLIPSTREAM_DLP=OFF
    -DSLIPSTREAM_GPU=OFF
    -DSLIPSTREAM_PUBLISH=OFF
    -DSLIPSTREAM_SPATIAL=OFF
    -DSLIPSTREAM_VIEW=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/slipstream)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
