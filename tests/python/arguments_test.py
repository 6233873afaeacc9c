"""Things are also given by their paths and labels, and a wrong argument is named in one line."""

import inspect
import pickle

import numpy
import pytest
from conftest import taken

import slipstream

LABEL = "dual-frequency, high 16, low 1, steps 3"


@pytest.fixture(scope="module")
def small():
    return taken("dual-frequency", camera=(160, 120), steps=3, high=16, low=1).scan


@pytest.fixture
def saved(small, tmp_path):
    """A folder and a recording of the same scan, and its scanner's file."""
    for name in ["scan", "scan.slip"]:
        small.save(tmp_path / name)
    small.scanner.write(tmp_path / "scanner.yaml")
    return tmp_path


def test_scans_are_given_by_their_paths(small, saved):
    right = slipstream.reconstruct(small).z
    for path in [str(saved / "scan"), saved / "scan", saved / "scan.slip"]:
        assert numpy.array_equal(slipstream.reconstruct(path).z, right, equal_nan=True)
        assert slipstream.check(path) == []
    with pytest.raises(slipstream.Error, match="no such folder or file"):
        slipstream.reconstruct(saved / "missing")
    dark = slipstream.Scan([frame * 0 for frame in small.frames], small.sequence, small.scanner)
    dark.save(saved / "dark")
    with pytest.raises(slipstream.Error, match=f"^{saved / 'dark'}: "):
        slipstream.reconstruct(saved / "dark")


def test_sequences_are_given_by_their_labels(small, saved):
    frames = list(small.frames)
    right = slipstream.Engine(small.scanner, small.sequence).cloud(frames).z
    for given in [LABEL, slipstream.Strategy(LABEL), slipstream.Sequence(LABEL)]:
        engine = slipstream.Engine(saved / "scanner.yaml", given)
        assert numpy.nanmax(abs(engine.cloud(frames).z - right)) < 1e-3
        scan = slipstream.Scan(frames, given, str(saved / "scanner.yaml"))
        assert scan.sequence.strategy == small.sequence.strategy
        assert slipstream.decode(frames, given).coordinate.shape == (120, 160)
        loaded = slipstream.load_scan(saved / "scan", given)
        assert loaded.sequence.strategy == small.sequence.strategy
        again = slipstream.simulate(given, camera=(64, 48)).scan
        assert again.sequence.strategy == small.sequence.strategy
    with pytest.raises(slipstream.Error, match="did you mean pmp"):
        slipstream.Sequence("pmpp")
    with pytest.raises(slipstream.Error, match="did you mean pmp"):
        slipstream.Engine(small.scanner, "pmpp")


def test_scanners_are_given_by_their_files(small, saved):
    scan = slipstream.Scan(list(small.frames), small.sequence)
    scan.scanner = saved / "scanner.yaml"
    assert scan.scanner.translation == pytest.approx(small.scanner.translation)
    world = slipstream.simulate(small.sequence, scanner=str(saved / "scanner.yaml"))
    assert world.scan.frames.size == (160, 120)
    with pytest.raises(slipstream.Error, match="missing.yaml"):
        slipstream.Engine(saved / "missing.yaml", small.sequence)


def test_live_takes_paths_and_labels(saved):
    with slipstream.Live(saved / "scan.slip", LABEL, saved / "scanner.yaml", rate=0) as live:
        assert len(list(live)[-1]) > 1000


def test_a_single_scan_is_a_list_of_one(tmp_path):
    flat = slipstream.simulate("pmp, steps 8", camera=(64, 48), scene="board").scan
    flat.save(tmp_path / "flat")
    alone = slipstream.calibrate_gamma([flat]).gamma
    for given in [flat, tmp_path / "flat", str(tmp_path / "flat")]:
        assert slipstream.calibrate_gamma(given).gamma == pytest.approx(alone)
    with pytest.raises(TypeError, match=r"^scans cannot have 3; expected Scans or their paths$"):
        slipstream.calibrate_noise([flat, 3])


def refusal_of(call, *arguments, **named):
    with pytest.raises(TypeError) as error:
        call(*arguments, **named)
    message = str(error.value)
    assert "incompatible" not in message and "\n" not in message, message
    return message


@pytest.mark.parametrize("call, arguments, named, message", [
    (slipstream.reconstruct, (3,), {}, "reconstruct(): scan cannot be 3; expected Scan | str | "
                                       "PathLike"),
    (slipstream.phases, (numpy.zeros((3, 4, 4)), "3"), {},
     "phases(): steps cannot be '3'; expected int"),
    (slipstream.phases, (numpy.zeros((3, 4, 4)),), {}, "phases(): steps is missing; expected int"),
    (slipstream.load_scan, ("scan",), {"scaner": "x"},
     "load_scan(): unknown argument 'scaner'; did you mean scanner?"),
    (slipstream.load_scan, (numpy.zeros((3, 4)),), {},
     "load_scan(): path cannot be an array of shape (3, 4) and type float64; expected str | "
     "PathLike"),
    (slipstream.Sequence, ("pmp",), {"projector": "1280x800"},
     "projector cannot be '1280x800'; expected tuple[int, int]"),
    (slipstream.design, (), {"frames": "few"}, "frames cannot be 'few'; expected int"),
    (slipstream.Strategy, (3,), {}, "Strategy(): name cannot be 3; expected str"),
    (slipstream.Sequence, (["pmp"],), {},
     "Sequence(): strategy cannot be ['pmp']; expected Strategy | str"),
    (slipstream.write_map, ("map.npy", "x"), {}, "write_map(): cannot take path 'map.npy', map "
                                                 "'x'; expected path str | PathLike, map ArrayLike"),
])
def test_the_wrong_argument_is_named(call, arguments, named, message):
    assert refusal_of(call, *arguments, **named) == message


def test_the_wrong_argument_of_a_method_is_named(small):
    cloud = slipstream.Cloud(numpy.zeros((2, 2, 3)))
    assert refusal_of(cloud.write, 5) == (
        "Cloud.write(): path cannot be 5; expected str | PathLike")
    with pytest.raises(TypeError, match="^noise_variance cannot be 'x'; expected float | None$"):
        slipstream.example_scanner().noise_variance = "x"
    assert "an array of shape (6, 120, 160)" in refusal_of(
        slipstream.reconstruct, numpy.stack(list(small.frames)))


def test_arguments_without_a_name_are_counted():
    assert refusal_of(slipstream.Scanner, numpy.eye(3)).startswith(
        "Scanner(): takes 0 arguments without a name, not 1; name them: camera_matrix=...")
    assert refusal_of(slipstream.strategy_names, 1) == (
        "strategy_names(): takes 0 arguments without a name, not 1")


CALLS = [name for name, bound in vars(slipstream).items()
         if not name.startswith("_") and callable(bound) and name not in (
             "Error", "WorldError", "Validity", "threads")]


@pytest.mark.parametrize("name", CALLS)
def test_every_refusal_is_one_line(name):
    for arguments in [(object(),), (object(), object()), (object(),) * 9]:
        refusal_of(getattr(slipstream, name), *arguments)
    assert inspect.getdoc(getattr(slipstream, name))


def test_a_failed_constructor_leaves_something_to_print():
    assert repr(slipstream.Live.__new__(slipstream.Live)) == "<slipstream.Live not constructed>"


def test_functions_go_to_other_processes():
    for call in [slipstream.reconstruct, slipstream.Cloud.write]:
        assert pickle.loads(pickle.dumps(call)) is call


def test_lists_are_points():
    assert slipstream.Cloud([[[1, 2, 3], [4, 5, 6]]]).size == (2, 1)
    with pytest.raises(slipstream.Error, match=r"shape \(5, 4\) .* or N x 3"):
        slipstream.Cloud(numpy.zeros((5, 4)))
    listed = slipstream.Cloud(numpy.ones((5, 3)), numpy.arange(5), frame="table")
    assert (listed.size, len(listed), listed.frame) == ((5, 1), 5, "table")
    assert list(listed.intensity[0]) == [0, 1, 2, 3, 4]
    with pytest.raises(slipstream.Error, match="two words"):
        slipstream.Cloud(numpy.ones((5, 3)), frame="two words")
