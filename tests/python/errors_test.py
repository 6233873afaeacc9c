"""What is wrong is said in the sentence of the program, as an exception that Python knows."""

import pickle

import numpy
import pytest
from conftest import run_program

import slipstream


def test_bad_input_is_a_value_error_with_the_same_sentence(tmp_path):
    missing = tmp_path / "nothing"
    with pytest.raises(slipstream.Error) as error:
        slipstream.load_scan(missing)
    assert isinstance(error.value, ValueError)
    assert str(error.value) in run_program("reconstruct", missing, "-o", "cloud.ply").stderr
    with pytest.raises(slipstream.Error, match="did you mean pmp"):
        slipstream.Strategy("pmpp", steps=3)
    with pytest.raises(slipstream.Error, match="has no setting 'stops'"):
        slipstream.Strategy("pmp", stops=3)


def test_the_world_is_an_os_error(dual, engine):
    cloud = engine.cloud(dual.scan.frames)
    with pytest.raises(slipstream.WorldError) as error:
        cloud.write("/proc/nowhere/cloud.ply")
    assert isinstance(error.value, OSError) and not isinstance(error.value, slipstream.Error)


def test_settings_are_known_by_name(dual):
    scan = dual.scan
    with pytest.raises(TypeError, match="minimum_modulation"):
        slipstream.Engine(scan.scanner, scan.sequence, minimum_modulatoin=3)
    with pytest.raises(TypeError, match="minimum_modulation cannot be 'much'"):
        slipstream.Engine(scan.scanner, scan.sequence, minimum_modulation="much")
    with pytest.raises(slipstream.Error):
        slipstream.Engine(scan.scanner, scan.sequence, minimum_modulation=-3)
    with pytest.raises(slipstream.Error):
        slipstream.Engine(scan.scanner, scan.sequence, backend="magic")
    with pytest.raises(slipstream.Error):
        slipstream.simulate(scan.sequence, scene="garden")
    with pytest.raises(TypeError, match="there is no setting"):
        slipstream.simulate(scan.sequence, sceen="statue")


@pytest.mark.parametrize("frames", [
    numpy.zeros((5, 240, 320), numpy.uint8),
    numpy.zeros((6, 240, 319), numpy.uint8),
    numpy.zeros((6, 240, 320), numpy.int32),
    numpy.zeros((6, 240, 320), ">u2"),
    numpy.zeros((6, 240, 640), numpy.uint8)[:, :, ::2],
    numpy.zeros((240, 320), numpy.uint8),
    numpy.zeros((6, 240, 320, 1), numpy.uint8),
    [],
    [numpy.zeros((240, 320), numpy.uint8)] * 5 + [numpy.zeros((240, 320), numpy.uint16)],
    [[1, 2], [3, 4]],
])
def test_what_is_no_frames_is_refused(engine, frames):
    with pytest.raises(slipstream.Error):
        engine.cloud(frames)


def test_what_is_no_array_is_refused(engine):
    for frames in [None, 3]:
        with pytest.raises(TypeError):
            engine.cloud(frames)
    with pytest.raises(slipstream.Error, match="got 10 bits"):
        engine.cloud(numpy.zeros((6, 240, 320), numpy.uint8), bits=10)


def test_things_say_what_they_are(dual, engine):
    scan = dual.scan
    cloud, maps = engine.cloud_and_maps(scan.frames)
    for thing in [scan, scan.frames, scan.sequence, scan.sequence.strategy, scan.scanner, engine,
                  cloud, maps, engine.uncertainty(cloud, maps, scan.frames),
                  slipstream.Response(2.2)]:
        assert repr(thing).startswith("<slipstream."), repr(thing)
    low, high = (f"{depth(cloud.z):.1f}" for depth in (numpy.nanmin, numpy.nanmax))
    assert repr(cloud) == (
        f"<slipstream.Cloud 320x240: {len(cloud)} points of 76800 pixels, {low} to {high} mm>")
    assert repr(slipstream.design()[0]).startswith("namespace(strategy=<slipstream.Strategy ")
    assert " object at " not in repr(scan)


def test_everything_prints_in_one_line(dual, engine):
    cloud, maps = engine.cloud_and_maps(dual.scan.frames)
    for thing in [dual, dual.scan, dual.scan.scanner, dual.scan.sequence, cloud, maps,
                  slipstream.find_gamma(dual.scan.frames, 3),
                  slipstream.unwrap_in_space(maps.wrapped_phase)]:
        assert "\n" not in repr(thing) and len(repr(thing)) < 400
    assert "depth=<240 x 320 float64>" in repr(dual)
    copied = pickle.loads(pickle.dumps(slipstream.find_gamma(dual.scan.frames, 3)))
    assert repr(copied) == repr(slipstream.find_gamma(dual.scan.frames, 3))


def test_values_compare_and_are_told_apart():
    strategy = slipstream.Strategy("dual-frequency", steps=4, high=16)
    assert slipstream.Strategy(strategy.label) == strategy
    assert slipstream.Strategy(strategy.name, **strategy.settings) == strategy
    assert slipstream.Strategy("pmp") != strategy
    for name in slipstream.strategy_names():
        assert slipstream.Strategy(name).name == name
    scanner = slipstream.example_scanner()
    scanner.response = slipstream.Response(2.2)
    scanner.ambient, scanner.noise_variance = 5, 1.5
    assert scanner != slipstream.example_scanner()
    with pytest.raises(slipstream.Error):
        scanner.ambient = 1000
    assert scanner.ambient == 5
    again = slipstream.Scanner(
        camera_matrix=scanner.camera_matrix, camera_size=scanner.camera_size,
        camera_distortion=scanner.camera_distortion, projector_matrix=scanner.projector_matrix,
        projector_size=scanner.projector_size, projector_distortion=scanner.projector_distortion,
        rotation=scanner.rotation, translation=scanner.translation)
    assert again == slipstream.example_scanner()
    with pytest.raises(TypeError, match="rotation is missing"):
        slipstream.Scanner(
            camera_matrix=scanner.camera_matrix, camera_size=scanner.camera_size,
            projector_matrix=scanner.projector_matrix, projector_size=scanner.projector_size)


def test_the_projector_of_a_scan_is_its_scanners(dual):
    given = slipstream.Sequence(dual.scan.sequence.strategy)
    assert given.projector == (0, 0)
    scan = slipstream.Scan(list(dual.scan.frames), given, dual.scan.scanner)
    assert scan.sequence.projector == dual.scan.scanner.projector_size
    later = slipstream.Scan(list(dual.scan.frames), given)
    later.scanner = dual.scan.scanner
    assert later.sequence.projector == dual.scan.scanner.projector_size
    other = slipstream.Sequence(given.strategy, projector=(64, 48))
    with pytest.raises(slipstream.Error, match="the patterns are for 64x48"):
        slipstream.Scan(list(dual.scan.frames), other).scanner = dual.scan.scanner


def test_a_scan_keeps_its_scanner(dual):
    scan = slipstream.Scan(list(dual.scan.frames), dual.scan.sequence)
    assert scan.scanner is None
    scan.scanner = slipstream.example_scanner((320, 240))
    scan.scanner.ambient = 7  # its own, no copy
    held = scan.scanner
    scan.scanner = dual.scan.scanner
    assert held == dual.scan.scanner and scan.scanner.ambient != 7
    with pytest.raises(TypeError):
        scan.scanner = None
