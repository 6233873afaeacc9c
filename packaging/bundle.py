#!/usr/bin/env python3
"""Packs a build with the libraries that it links, for Linux systems at least as recent as this one.

bundle.py tarball BUILD OUTPUT   slipstream-VERSION-linux-MACHINE.tar.xz: the program
bundle.py wheel BUILD OUTPUT     slipstream-VERSION-*.whl: Python module and program, for this Python

The C and C++ runtime libraries and the loader are not packed: every system has them. The same build
gives the same bytes; files get the time of SOURCE_DATE_EPOCH.
"""

import base64
import hashlib
import os
import pathlib
import platform
import re
import shutil
import stat
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import time
import tomllib
import zipfile

SOURCE = pathlib.Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((SOURCE / "pyproject.toml").read_text())["project"]
NAME = f"slipstream-{PROJECT['version']}"
RUNTIME = re.compile(r"lib(c|m|dl|rt|pthread|stdc\+\+|gcc_s)\.so")
# Headers of static libraries and templates that become a part of the programs and the module.
COMPILED_IN = ["boost/version.hpp", "ceres/ceres.h", "CLI/CLI.hpp", "eigen3/Eigen/Core",
               "glm/glm.hpp", "imgui/imgui.h", "lemon/list_graph.h", "nlohmann/json.hpp",
               "pybind11/pybind11.h", "stb/stb_easy_font.h"]
BUILT_AT = int(os.environ.get("SOURCE_DATE_EPOCH", "315532800"))  # 1980: the oldest a zip knows

MAIN = '''"""Runs the program: python3 -m slipstream COMMAND"""

import os
import pathlib
import sys


def main():
    program = pathlib.Path(__file__).parent / "bin/slipstream"
    os.execv(program, ["slipstream", *sys.argv[1:]])


if __name__ == "__main__":
    main()
'''


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def seek_libraries_in(folder, binary):
    place = os.path.relpath(folder, binary.parent)
    subprocess.run(["patchelf", "--force-rpath", "--set-rpath", f"$ORIGIN/{place}", binary],
                   check=True)


def add_binary(source, target, libraries, licences):
    """Copies a binary that will find its libraries in the folder `libraries`, and copies those."""
    libraries.mkdir(parents=True, exist_ok=True)
    licences.mkdir(parents=True, exist_ok=True)
    target.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run(["strip", "-o", target, source], check=True)
    seek_libraries_in(libraries, target)
    for path in re.findall(r"=> (/\S+)", output_of("ldd", source)):
        library = pathlib.Path(path)
        if RUNTIME.match(library.name) or (libraries / library.name).exists():
            continue
        shutil.copy(library, libraries)
        seek_libraries_in(libraries, libraries / library.name)  # it may name another place itself
        real = str(library.resolve()).removeprefix("/usr")  # some packages list /lib for /usr/lib
        package = output_of("dpkg", "-S", f"*{real}").split(":")[0]
        shutil.copy(f"/usr/share/doc/{package}/copyright", licences / package)
    for header in COMPILED_IN:
        package = output_of("dpkg", "-S", f"/usr/include/{header}").split(":")[0]
        shutil.copy(f"/usr/share/doc/{package}/copyright", licences / package)
    shutil.copy(SOURCE / "LICENSE", licences / "slipstream")
    for path in re.findall(r"=> (\S+)", output_of("ldd", target)):
        library = pathlib.Path(path)
        if library.parent.resolve() != libraries.resolve() and not RUNTIME.match(library.name):
            raise SystemExit(f"{target.name} would load {path}, which is not packed")


def add_programs(build, root, libraries, licences):
    add_binary(build / "slipstream", root / "bin/slipstream", libraries, licences)
    add_binary(build / "whole/slipstream", root / "libexec/slipstream/slipstream", libraries,
               licences)


def files_below(folder):
    return sorted(path for path in folder.rglob("*") if path.is_file())


def tarball(build, output, folder):
    name = f"{NAME}-linux-{platform.machine()}"
    root = folder / name
    add_programs(build, root, root / "lib", root / "licences")

    def plain(entry):
        entry.mtime, entry.uid, entry.gid, entry.uname, entry.gname = BUILT_AT, 0, 0, "", ""
        entry.mode = 0o755 if entry.isdir() or entry.mode & 0o100 else 0o644
        return entry

    path = output / f"{name}.tar.xz"
    with tarfile.open(path, "w:xz") as archive:
        for file in files_below(root):
            archive.add(file, file.relative_to(folder), filter=plain)
    return path


def metadata():
    lines = ["Metadata-Version: 2.1", f"Name: {PROJECT['name']}", f"Version: {PROJECT['version']}",
             f"Summary: {PROJECT['description']}", f"License: {PROJECT['license']['text']}",
             f"Requires-Python: {PROJECT['requires-python']}",
             *(f"Requires-Dist: {name}" for name in PROJECT["dependencies"]),
             "Description-Content-Type: text/markdown", "", (SOURCE / "README.md").read_text()]
    return "\n".join(lines)


def wheel_tag():
    python = "cp{}{}".format(*sys.version_info[:2])
    libc = platform.libc_ver()[1].replace(".", "_")
    return f"{python}-{python}-manylinux_{libc}_{platform.machine()}"


def wheel(build, output, folder):
    package, libraries = folder / "slipstream", folder / "slipstream.libs"
    about = folder / f"{NAME}.dist-info"
    built = build / "python/slipstream"
    shutil.copytree(built, package, ignore=shutil.ignore_patterns("*.so", "__pycache__"))
    (package / "__main__.py").write_text(MAIN)
    module = "_slipstream" + sysconfig.get_config_var("EXT_SUFFIX")
    add_binary(built / module, package / module, libraries, about / "licenses")
    add_programs(build, package, libraries, about / "licenses")
    (about / "METADATA").write_text(metadata())
    (about / "WHEEL").write_text("Wheel-Version: 1.0\nGenerator: slipstream\n"
                                 f"Root-Is-Purelib: false\nTag: {wheel_tag()}\n")
    (about / "entry_points.txt").write_text(
        "[console_scripts]\nslipstream = slipstream.__main__:main\n")
    record = about / "RECORD"
    lines = []
    for file in files_below(folder):
        content = file.read_bytes()
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        lines.append(f"{file.relative_to(folder)},sha256={digest},{len(content)}")
    record.write_text("\n".join([*lines, f"{record.relative_to(folder)},,", ""]))

    path = output / f"{NAME}-{wheel_tag()}.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in files_below(folder):
            entry = zipfile.ZipInfo(str(file.relative_to(folder)), time.gmtime(BUILT_AT)[:6])
            mode = stat.S_IFREG | (0o755 if os.access(file, os.X_OK) else 0o644)
            entry.external_attr = mode << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, file.read_bytes())
    return path


if __name__ == "__main__":
    kind, build, output = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        print({"tarball": tarball, "wheel": wheel}[kind](build, output, pathlib.Path(folder)))
