"""Builds the extension module with CMake; pyproject.toml has the metadata."""

import os
import pathlib
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext


class BuildByCMake(build_ext):
    def build_extension(self, extension):
        folder = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve().parent.parent
        build = pathlib.Path(self.build_temp).resolve()
        options = ["PYTHON=ON", "APP=OFF", "VIEW=OFF", f"PYTHON_FOLDER={folder}"]
        for command in [
                ["cmake", "-S", pathlib.Path(__file__).parent, "-B", build, "-G", "Ninja",
                 f"-DPython_EXECUTABLE={sys.executable}", *os.environ.get("CMAKE_ARGS", "").split(),
                 *(f"-DSLIPSTREAM_{option}" for option in options)],
                ["cmake", "--build", build, "--target", "_slipstream"],
                ["cmake", "--install", build, "--component", "python"]]:
            subprocess.run(command, check=True)


setup(ext_modules=[Extension("slipstream._slipstream", [])], cmdclass={"build_ext": BuildByCMake},
      options={"build": {"build_base": "build-wheel"}})
