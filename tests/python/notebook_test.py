"""Pictures of clouds in notebooks, one-line reprs, and other libraries' types."""

import base64
import pathlib
import re
import sys
import types

import numpy
import pytest

import slipstream


@pytest.fixture
def cloud(dual, engine):
    return engine.cloud(dual.scan.frames)


def test_a_cloud_shows_its_depth(cloud, tmp_path):
    shown = cloud._repr_html_()
    png = base64.b64decode(re.search(r'src="data:image/png;base64,([^"]*)"', shown)[1])
    cloud.write_preview(tmp_path / "preview.png")
    assert png == cloud.preview() == (tmp_path / "preview.png").read_bytes()
    assert "http" not in shown and "file:" not in shown
    caption = re.search("<figcaption>(.*)</figcaption>", shown)[1]
    assert caption == repr(cloud).removeprefix("<slipstream.Cloud ").removesuffix(">")


def test_a_cloud_without_points_shows():
    empty = slipstream.Cloud(numpy.full((48, 64, 3), numpy.nan))
    assert repr(empty) == "<slipstream.Cloud 64x48: 0 points of 3072 pixels>"
    assert "data:image/png" in empty._repr_html_()


def test_reprs_are_one_line_with_figures(dual, engine):
    cloud, maps = engine.cloud_and_maps(dual.scan.frames)
    uncertainty = engine.uncertainty(cloud, maps, dual.scan.frames)
    for thing, told in [(dual.scan.scanner, r"camera 320x240, projector 1280x800, \S+ mm apart"),
                        (maps, r"320x240: median modulation \S+"),
                        (uncertainty, r"320x240: median \S+ mm of depth"),
                        (slipstream.Response(2.2), r"gamma 2\.2")]:
        assert re.match(rf"<slipstream\.\w+ {told}", repr(thing)), repr(thing)
    for thing in [dual.scan, engine, cloud]:
        assert "\n" not in repr(thing)


def stand_in(monkeypatch, name, **members):
    stand = types.ModuleType(name)
    vars(stand).update(members)
    monkeypatch.setitem(sys.modules, name, stand)


def ply(path):
    """Header lines of a binary PLY file, and its vertices as a structured array."""
    header, _, data = pathlib.Path(path).read_bytes().partition(b"end_header\n")
    lines = header.decode().splitlines()
    count = int(next(line for line in lines if line.startswith("element vertex")).split()[2])
    kinds = {"float": "<f4", "double": "<f8", "uchar": "u1"}
    vertices = numpy.dtype([(words[2], kinds[words[1]]) for words in map(str.split, lines)
                            if words[0] == "property" and words[1] in kinds])
    return lines, numpy.frombuffer(data, vertices, count)


def test_open3d(cloud, monkeypatch):
    stand_in(monkeypatch, "open3d", io=types.SimpleNamespace(read_point_cloud=ply))
    _, read = cloud.to_open3d()
    valid = cloud.validity == slipstream.Validity.VALID
    for name, right in [("xyz", cloud.points), (["nx", "ny", "nz"], cloud.normals())]:
        given = numpy.stack([read[axis] for axis in name], axis=1)
        assert numpy.array_equal(given, right[valid], equal_nan=True), name
    assert abs(read["red"] - cloud.intensity[valid]).max() <= 0.5
    assert numpy.array_equal(read["red"], read["blue"])


def test_trimesh(cloud, monkeypatch):
    def load(path, process):
        assert process is False  # it would merge vertices
        return ply(path)

    stand_in(monkeypatch, "trimesh", load=load)
    header, vertices = cloud.to_trimesh()
    assert "property list uchar int vertex_indices" in header
    assert {"x", "y", "z", "red", "green", "blue"} <= set(vertices.dtype.names)
    assert 10000 < len(vertices) <= len(cloud)
    fewer, _ = cloud.to_trimesh(largest_step=0.01)
    faces = [int(line.split()[2]) for lines in (header, fewer) for line in lines
             if line.startswith("element face")]
    assert faces[0] > faces[1]


@pytest.mark.parametrize("name", ["open3d", "trimesh"])
def test_libraries_that_are_not_installed_are_named(cloud, name, monkeypatch):
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError, match=name):
        getattr(cloud, f"to_{name}")()


def test_with_the_real_open3d(cloud):
    pytest.importorskip("open3d", reason="package open3d is not installed")
    assert len(cloud.to_open3d().points) == len(cloud)


def test_with_the_real_trimesh(cloud):
    pytest.importorskip("trimesh", reason="package trimesh is not installed")
    mesh = cloud.to_trimesh()
    assert len(mesh.vertices) > 0 and len(mesh.faces) > 0
