"""Frames in every form, and what is wrong with those that are none."""

import warnings

import numpy
import pytest
from conftest import taken

import slipstream


@pytest.fixture(scope="module")
def small():
    return taken("dual-frequency", camera=(160, 120), steps=3, high=16, low=1).scan


@pytest.fixture
def stack(small):
    return numpy.stack(list(small.frames))


@pytest.fixture
def engine(small):
    return slipstream.Engine(small.scanner, small.sequence)


def test_real_numbers_of_any_width(engine, stack):
    right = engine.cloud(stack.astype("f8"))
    for given in [stack.astype("f4"), list(stack.astype("f4")), stack.astype("f2")]:
        assert numpy.array_equal(engine.cloud(given).z, right.z, equal_nan=True)
    mixed = [frame.astype("f4" if n % 2 else "f8") for n, frame in enumerate(stack)]
    assert numpy.array_equal(engine.cloud(mixed).z, right.z, equal_nan=True)


@pytest.mark.parametrize("kind", ["bool", "i1", "i4", "i8", "u4", ">u2", "c16"])
def test_other_types_are_refused_in_one_line(engine, stack, kind):
    with pytest.raises(slipstream.Error) as error:
        engine.cloud(stack.astype(kind))
    name = str(stack.astype(kind).dtype)
    assert str(error.value) == (
        f"frames: type {name}; expected uint8, uint16, float32 or float64")


@pytest.mark.parametrize("change, words", [
    (lambda stack: stack.transpose(1, 2, 0), "shape (120, 160, 6)"),
    (lambda stack: numpy.ascontiguousarray(stack.transpose(1, 2, 0)), "numpy.moveaxis(frames, -1"),
    (lambda stack: numpy.stack([stack] * 3, axis=-1), "frames[..., 1]"),
    (lambda stack: list(numpy.stack([stack] * 3, axis=-1)), "frame[..., 1]"),
    (lambda stack: stack[0], "shape (120, 160) and type uint8; expected frames x rows x columns"),
    (lambda stack: stack[:, numpy.newaxis], "shape (6, 1, 120, 160)"),
    (lambda stack: "scan", "frames: 'scan'; expected arrays: `load_scan()` reads files"),
    (lambda stack: ["frame_00.png"], "`load_scan()` reads files"),
])
def test_the_shape_that_is_wrong_is_named(engine, small, stack, change, words):
    for take in [engine.cloud, lambda frames: slipstream.Scan(frames, small.sequence),
                 lambda frames: slipstream.decode(frames, small.sequence)]:
        with pytest.raises(slipstream.Error) as error:
            take(change(stack))
        assert words in str(error.value)


def test_the_advice_on_shapes_is_right(engine, stack):
    right = engine.cloud(stack).z
    last = stack.transpose(1, 2, 0)
    moved = numpy.ascontiguousarray(numpy.moveaxis(last, -1, 0))
    coloured = numpy.stack([stack] * 3, axis=-1)
    for given in [moved, numpy.ascontiguousarray(coloured[..., 1])]:
        assert numpy.array_equal(engine.cloud(given).z, right, equal_nan=True)


def test_exchanged_width_and_height_are_named(engine, small, stack):
    words = r"160 rows and 120 columns, but the scanner's camera_size is \(160, 120\): .* exchanged"
    turned = numpy.ascontiguousarray(stack.transpose(0, 2, 1))
    with pytest.raises(slipstream.Error, match=words):
        engine.cloud(turned)
    with pytest.raises(slipstream.Error, match=words):
        slipstream.Scan(turned, small.sequence, small.scanner)
    scan = slipstream.Scan(turned, small.sequence)
    with pytest.raises(slipstream.Error, match=words):
        scan.scanner = small.scanner


@pytest.mark.parametrize("change, words", [
    (lambda stack: stack / 255, "from 0 to 1.*multiply the frames by 255"),
    (lambda stack: (stack / 255).astype("f4"), "multiply the frames by 255"),
    (lambda stack: stack.astype("u2") * 16, "12 bits in 16-bit files"),
    (lambda stack: stack.astype("u2"), "8 bits in 16-bit files"),
    (lambda stack: stack * 0, "no pattern in the pictures"),
])
def test_frames_without_a_result_are_warned_of(small, stack, change, words):
    frames = change(stack)
    engine = slipstream.Engine(small.scanner, small.sequence)
    with pytest.warns(UserWarning, match=f"no pixel became a point: .*{words}"):
        assert len(engine.cloud(frames)) == 0
    engine = slipstream.Engine(small.scanner, small.sequence)
    with pytest.warns(UserWarning, match=f"no pixel shows the patterns: .*{words}"):
        engine.maps(frames)
    with pytest.warns(UserWarning, match=f"no pixel shows the patterns: .*{words}"):
        slipstream.decode(frames, small.sequence)
    with pytest.raises(slipstream.Error, match=words):
        slipstream.reconstruct(slipstream.Scan(frames, small.sequence, small.scanner))


def test_an_engine_warns_once_of_dark_frames_and_never_of_others(engine, stack):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for frames in [stack, stack * 0, stack * 0]:
            engine.cloud_and_maps(frames)
    assert len(caught) == 1
    assert caught[0].filename == __file__  # the line of the user


def test_told_bits_give_the_points(engine, stack):
    assert len(engine.cloud(stack.astype("u2") * 16, bits=12)) == len(engine.cloud(stack))
