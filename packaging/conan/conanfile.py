"""Conan 2 recipe of the library: conan create packaging/conan"""

import os

from conan import ConanFile
from conan.tools.cmake import CMake, cmake_layout
from conan.tools.files import copy


class Slipstream(ConanFile):
    name = "slipstream"
    version = "0.2.0"
    description = "Real-time 3-D reconstruction by structured light illumination"
    license = "Apache-2.0"
    settings = "os", "compiler", "build_type", "arch"
    options = {"io": [True, False], "calibrate": [True, False]}
    default_options = {"io": True, "calibrate": False}
    generators = "CMakeToolchain", "CMakeDeps", "PkgConfigDeps"

    def export_sources(self):
        root = os.path.join(self.recipe_folder, "..", "..")
        for pattern in ["CMakeLists.txt", "LICENSE", "cmake/*", "include/*", "src/*"]:
            copy(self, pattern, root, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        needed = ["eigen/[^3.4]", "fmt/[>=9]", "highway/[^1.0]", "onetbb/[>=2021]"]
        if self.options.io:
            needed += ["libdeflate/[^1.14]", "libjpeg-turbo/[>=2.1]", "libpng/[^1.6]",
                       "libtiff/[^4.5]", "nlohmann_json/[^3.11]", "pugixml/[^1.13]", "stb/cci.20240531",
                       "tinyobjloader/[>=2.0.0-rc10]", "yaml-cpp/[>=0.7]"]
        if self.options.calibrate:
            needed += ["ceres-solver/[^2.1]", "opencv/[>=4.5.4 <5]"]
        for one in needed:
            self.requires(one, transitive_headers=True)

    def build(self):
        parts = {"APP": False, "CAMERAS": False, "DLP": False, "PUBLISH": False, "SPATIAL": False,
                 "VIEW": False,
                 "IO": self.options.io, "CALIBRATE": self.options.calibrate}
        cmake = CMake(self)
        cmake.configure({f"SLIPSTREAM_{part}": bool(on) for part, on in parts.items()})
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        CMake(self).install()

    def package_info(self):
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "slipstream")]
