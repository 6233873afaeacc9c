"""Clouds and maps from Python are those of the program, byte for byte."""

import random

import numpy
import pytest
from conftest import as_printed, program, run_program, taken

import slipstream

STRATEGIES = [
    ("pmp", {"steps": [3, 4, 5, 6, 8]}),
    ("dual-frequency", {"steps": [3, 4, 5], "high": [8, 16, 24], "low": [1]}),
    ("dual-frequency", {"steps": [4], "low_steps": [3, 6], "high": [16]}),
    ("pcmp", {"steps": [3, 4, 5]}),
    ("multi-frequency", {"periods": [[1, 6, 36], [15, 16]]}),
    ("gray-phase", {"steps": [4], "periods": [16, 32]}),
    ("two-plus-one", {}),
    ("micro", {}),
]
# Each setting of Python with the flag of the program.
SETTINGS = [
    ("minimum_modulation", "--minimum-modulation", [5, 15, 30]),
    ("drop_saturated", "--keep-saturated", [False]),
    ("nearest", "--nearest", [550.5]),
    ("farthest", "--farthest", [640.25]),
    ("raw", "--raw", [True]),
    ("correct_contrast", "--correct-contrast", [True]),
    ("largest_sigma", "--largest-sigma", [0.5, 2]),
    ("smallest_component", "--smallest-component", [0, 50]),
    ("widest_gap", "--widest-gap", [3]),
    ("smoothing", "--smoothing", [2]),
    ("backend", "--backend", ["equation", "closed-form", "lut"]),
    ("cue_rule", "--cue-rule", ["published", "likelihood"]),
    ("gamma", "--gamma", ["none", "1.4"]),
    ("box", "--box", [((-80.0, -60.0, 500.0), (80.0, 60.0, 700.0))]),
    ("outline", "--outline", [[(40.0, 30.0), (280.0, 200.0)]]),
]


def flag_of(flag, value):
    if isinstance(value, bool):
        return [flag]
    if isinstance(value, (list, tuple)):
        return [flag + "=" + ",".join(str(number) for number in numpy.ravel(value))]
    return [f"{flag}={value}"]


def drawn_settings(draw):
    settings, flags = {}, []
    for name, flag, values in draw.sample(SETTINGS, draw.randint(0, 4)):
        settings[name] = draw.choice(values)
        flags += flag_of(flag, settings[name])
    return settings, flags


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("seed", range(24))
def test_random_scans_and_settings(seed, tmp_path):
    draw = random.Random(seed)
    name, choices = STRATEGIES[seed % len(STRATEGIES)]
    strategy = {setting: draw.choice(values) for setting, values in choices.items()}
    scene = draw.choice(["sphere", "statue", "boxes", "board"])
    taken(name, camera=(160, 120), scene=scene, path=tmp_path / "scan", **strategy)
    settings, flags = drawn_settings(draw)
    ending = draw.choice([".ply", ".pcd", ".xyz"])
    ours, theirs = tmp_path / ("python" + ending), tmp_path / ("program" + ending)
    done = run_program("reconstruct", tmp_path / "scan", "-o", theirs, *flags)
    scan = slipstream.load_scan(tmp_path / "scan")
    if done.returncode == 2:
        with pytest.raises(slipstream.Error) as refused:
            slipstream.reconstruct(scan, **settings).write(ours)
        assert as_printed(refused.value) in done.stderr
        return
    assert done.returncode == 0, done.stderr
    slipstream.reconstruct(scan, **settings).write(ours)
    assert ours.read_bytes() == theirs.read_bytes(), (name, strategy, settings)


def test_settings_of_the_virtual_world_have_the_names_of_the_program():
    sequence = slipstream.Sequence("pmp, steps 3")
    world = {"scene": "board", "camera": (32, 24)}
    one = slipstream.simulate(sequence, noise_variance=9, bits=10, **world)
    other = slipstream.simulate(sequence, virtual_noise=9, camera_bits=10, **world)
    assert all(numpy.array_equal(one.scan.frames[n], other.scan.frames[n]) for n in range(3))


def test_arrays_give_what_the_scan_gives(dual, engine, tmp_path):
    dual.scan.save(tmp_path / "scan")
    program("reconstruct", tmp_path / "scan", "-o", tmp_path / "program.ply",
            "--coordinate", tmp_path / "coordinate.tiff", "--uncertainty")
    frames = numpy.stack(list(dual.scan.frames))
    cloud, maps = engine.cloud_and_maps(frames)
    cloud.write(tmp_path / "python.ply", engine.uncertainty(cloud, maps, frames))
    assert (tmp_path / "python.ply").read_bytes() == (tmp_path / "program.ply").read_bytes()
    coordinate = slipstream.load_map(tmp_path / "coordinate.tiff")
    unmeasured = numpy.isin(cloud.validity, [int(reason) for reason in (
        slipstream.Validity.TOO_DARK, slipstream.Validity.SATURATED,
        slipstream.Validity.DOUBTFUL_ORDER)])
    assert numpy.array_equal(
        coordinate, numpy.where(unmeasured, numpy.nan, maps.coordinate), equal_nan=True)


def test_depth_is_that_of_the_world(dual, engine):
    cloud = engine.cloud(dual.scan.frames)
    assert len(cloud) > 10000
    assert abs(numpy.nanmedian(cloud.z - dual.depth)) < 0.5
    assert (cloud.validity == slipstream.Validity.VALID).sum() == len(cloud)
    assert sum(cloud.counts.values()) == cloud.z.size
    assert len(slipstream.Validity) == len(cloud.counts)


def test_two_cameras_and_both_axes(tmp_path):
    program("simulate", tmp_path / "two", "--second-camera", "--camera", "160x120")
    both = slipstream.Sequence("pmp, steps 4", axis="both")
    slipstream.simulate(both, tmp_path / "both", camera=(160, 120))
    for name in ["two", "both"]:
        program("reconstruct", tmp_path / name, "-o", tmp_path / "program.ply")
        cloud = slipstream.reconstruct(slipstream.load_scan(tmp_path / name))
        cloud.write(tmp_path / "python.ply")
        assert (tmp_path / "python.ply").read_bytes() == (tmp_path / "program.ply").read_bytes()


def test_a_wrong_scan_is_refused_or_marked(dual, tmp_path):
    frames = [dual.scan.frames[n] for n in (3, 4, 5, 0, 1, 2)]
    wrong = slipstream.Scan([frame * 0 for frame in frames], dual.scan.sequence, dual.scan.scanner)
    assert slipstream.check(wrong)[0].wrong
    with pytest.raises(slipstream.Error, match="^scan: "):
        slipstream.reconstruct(wrong)
    with pytest.warns(UserWarning):
        cloud = slipstream.reconstruct(wrong, anyway=True)
    assert cloud.remarks[0].startswith("doubted: ")
    cloud.write(tmp_path / "cloud.ply")
    assert b"comment doubted: " in (tmp_path / "cloud.ply").read_bytes()


def test_slipped_frames_are_put_in_order(dual):
    slipped = [dual.scan.frames[n] for n in (1, 2, 3, 4, 5, 0)]
    scan = slipstream.Scan(slipped, dual.scan.sequence, dual.scan.scanner)
    with pytest.warns(UserWarning, match="put in the order"):
        cloud = slipstream.reconstruct(scan)
    right = slipstream.reconstruct(dual.scan)
    assert numpy.array_equal(cloud.z, right.z, equal_nan=True)


def test_clouds_are_cleaned_written_and_read(dual, engine, tmp_path):
    cloud = slipstream.Engine(dual.scan.scanner, dual.scan.sequence, raw=True).cloud(
        dual.scan.frames)
    clean = cloud.cleaned(smallest_component=500)
    assert 0 < len(clean) < len(cloud)
    clean.write(tmp_path / "cloud.pcd", normals=True)
    again = slipstream.load_cloud(tmp_path / "cloud.pcd")
    assert numpy.array_equal(again.points, clean.points, equal_nan=True)
    clean.write_mesh(tmp_path / "mesh.stl")
    clean.write_preview(tmp_path / "preview.png")
    lengths = numpy.linalg.norm(clean.normals(), axis=2)
    assert abs(numpy.nanmean(lengths) - 1) < 1e-3
    own = slipstream.Cloud(clean.points, clean.intensity)
    own.write(tmp_path / "own.ply")
    clean.write(tmp_path / "clean.ply")
    assert (tmp_path / "own.ply").read_bytes() == (tmp_path / "clean.ply").read_bytes()


def test_moves_into_another_frame(tmp_path):
    pose = tmp_path / "base.yaml"
    pose.write_text("{from: camera, to: base, unit: m, translation: [0, 0, 1], "
                    "euler: [180, 0, 0], order: intrinsic xyz, angles: degrees}")
    points = numpy.array([[[1, 2, 600], [3, 4, 610]], [[5, 6, 620], [7, 8, 630]]], numpy.float32)
    cloud = slipstream.Cloud(points)

    moved = cloud.moved(pose)
    assert (cloud.frame, moved.frame) == ("camera", "base")
    numpy.testing.assert_allclose(moved.points, points * [1, -1, -1] + [0, 0, 1000], atol=1e-3)
    with pytest.raises(slipstream.Error, match="the cloud is in the frame base"):
        moved.normals()

    # Its file is the one that is written into that frame.
    moved.write(tmp_path / "moved.pcd")
    cloud.write(tmp_path / "written.pcd", to_frame=pose)
    assert (tmp_path / "moved.pcd").read_bytes() == (tmp_path / "written.pcd").read_bytes()
    assert slipstream.load_cloud(tmp_path / "moved.pcd").frame == "base"
