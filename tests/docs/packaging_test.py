"""The versions that the files for packages say are the project's, and what they name is there."""

import ast
import importlib.util
import io
import json
import pathlib
import re
import tarfile
import tomllib

from pages import PROGRAM, SOURCES

CMAKE = (SOURCES / "CMakeLists.txt").read_text()


def said(path, pattern):
    return re.search(pattern, (SOURCES / path).read_text(), re.M)[1]


def test_versions_are_one():
    versions = {
        "CMakeLists.txt": said("CMakeLists.txt", r"^project\(slipstream VERSION (\S+)"),
        "pyproject.toml": said("pyproject.toml", r'^version = "(.*)"'),
        "CITATION.cff": said("CITATION.cff", r"^version: (\S+)"),
        "CHANGELOG.md": said("CHANGELOG.md", r"^## ([\d.]+)"),
        "debian": said("debian/changelog", r"^slipstream \((.*)\)"),
        "vcpkg": json.loads((SOURCES / "packaging/vcpkg/vcpkg.json").read_text())["version"],
        "ros": said("ros/package.xml", r"<version>(.*)</version>"),
        "conan": said("packaging/conan/conanfile.py", r'^    version = "(.*)"'),
    }
    assert len(set(versions.values())) == 1, versions


def test_parts_are_options_of_the_build():
    parts = set(re.findall(r"^slipstream_part\((\w+)", CMAKE, re.M))
    port = (SOURCES / "packaging/vcpkg/portfile.cmake").read_text()
    assert set(re.findall(r"SLIPSTREAM_(\w+)", port)) <= parts
    recipe = (SOURCES / "packaging/conan/conanfile.py").read_text()
    named = next(node for node in ast.walk(ast.parse(recipe)) if isinstance(node, ast.Dict)
                 and any(key.value == "APP" for key in node.keys if isinstance(key, ast.Constant)))
    assert {key.value for key in named.keys} <= parts


def test_features_of_the_port_are_those_of_its_manifest():
    port = said("packaging/vcpkg/portfile.cmake", r"FEATURES\n((?: +\w+ SLIPSTREAM_\w+\)?\n)+)")
    manifest = json.loads((SOURCES / "packaging/vcpkg/vcpkg.json").read_text())
    assert re.findall(r"^ +(\w+)", port, re.M) == list(manifest["features"])


def test_the_wheel_of_setuptools_holds_what_is_built():
    setup, python = ((SOURCES / path).read_text() for path in ("setup.py", "python/CMakeLists.txt"))
    settings = tomllib.loads((SOURCES / "pyproject.toml").read_text())["tool"]["setuptools"]
    [package], built = settings["packages"], pathlib.Path(PROGRAM).parent / "python"
    assert (SOURCES / settings["package-dir"][""] / package / "__init__.py").exists()

    extension = re.search(r'Extension\("(.*?)"', setup)[1].replace(".", "/")
    packed = [f"{extension}.*.so", *(f"{package}/{name}" for name in settings["package-data"][package])]
    assert not [name for name in packed if not any(built.glob(name))], "pyproject.toml, setup.py"

    target, component = (re.search(rf'"--{flag}", "(\w+)"', setup)[1]
                         for flag in ("target", "component"))
    assert f"pybind11_add_module({target} " in python
    assert set(re.findall(r"COMPONENT (\w+)", python)) == {component}


def test_the_container_copies_what_debian_packages_are_called():
    copied = re.findall(r"packages/(\S+)_\*\.deb", (SOURCES / "Containerfile").read_text())
    built = re.findall(r"^Package: (\S+)", (SOURCES / "debian/control").read_text(), re.M)
    assert copied and set(copied) <= set(built)


def test_workflows_call_commands_of_dev():
    known = set(re.findall(r"^  (\w+)\) ", (SOURCES / "dev").read_text(), re.M))
    called = set()
    for workflow in (SOURCES / ".github/workflows").glob("*.yml"):
        text = workflow.read_text()
        called |= set(re.findall(r"\./dev (\w+)", text))
        for commands in re.findall(r"command: \[(.*)\]", text):
            called |= {command.split()[0] for command in commands.split(", ")}
    assert called and called <= known


def test_the_bill_names_each_package_of_a_bundle_and_its_licences(tmp_path):
    spec = importlib.util.spec_from_file_location("bill", SOURCES / "packaging/bill.py")
    bill = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(bill)
    files = {
        "libplain1": "Format: 1\n\nFiles: *\nLicense: Expat\n\nFiles: debian/*\nLicense: GPL-3+\n",
        "libcholmod9": "Format: 1\n\nFiles: *\nLicense: LGPL-2.1+\n\nFiles: a/*\nLicense: GPL-2+\n",
        "libodd2": "All rights are explained here.",
        "slipstream": "Apache"}
    archive = tmp_path / "slipstream-1-linux-any.tar.xz"
    with tarfile.open(archive, "w:xz") as opened:
        for name, text in files.items():
            entry = tarfile.TarInfo(f"slipstream-1/licences/{name}")
            entry.size = len(text)
            opened.addfile(entry, io.BytesIO(text.encode()))

    bill.main(tmp_path)
    told = json.loads((tmp_path / f"{archive.name}.spdx.json").read_text())
    declared = {package["name"]: package["licenseDeclared"] for package in told["packages"]}
    assert declared == {archive.name: "Apache-2.0", "libplain1": "MIT",
                        "libcholmod9": "GPL-2.0-or-later AND LGPL-2.1-or-later",
                        "libodd2": "LicenseRef-libodd2"}
    assert [text["licenseId"] for text in told["hasExtractedLicensingInfos"]] == [
        "LicenseRef-libodd2"]
    assert "GPL" in next(p for p in told["packages"] if p["name"] == "libcholmod9")["comment"]
    assert len(told["relationships"]) == 4
