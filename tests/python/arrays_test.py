"""What is an array on one side and frames or a cloud on the other is the same memory."""

import gc

import numpy
import pytest

import slipstream


def address(array):
    return array.__array_interface__["data"][0]


def test_frames_of_a_scan_are_its_memory(dual):
    frames = dual.scan.frames
    assert len(frames) == 6
    assert address(frames[2]) == address(dual.scan.frames[2])
    assert address(frames[-1]) == address(frames[5])
    with pytest.raises(IndexError):
        frames[6]
    with pytest.raises(ValueError):
        frames[0][0, 0] = 1
    pixels = frames[0]
    kept = pixels.copy()
    del frames
    gc.collect()
    assert numpy.array_equal(pixels, kept)


def test_arrays_of_a_cloud_are_its_memory(dual, engine):
    cloud = engine.cloud(dual.scan.frames)
    for name in ["x", "y", "z", "intensity", "validity", "points"]:
        first, again = getattr(cloud, name), getattr(cloud, name)
        assert address(first) == address(again), name
        assert not first.flags.writeable and not first.flags.owndata
    assert cloud.z.shape == (240, 320) and cloud.z.dtype == numpy.float32
    assert cloud.points.shape == (240, 320, 3) and cloud.points.flags.c_contiguous
    assert numpy.array_equal(cloud.points[..., 2], cloud.z, equal_nan=True)


def test_arrays_outlive_cloud_and_engine(dual):
    engine = slipstream.Engine(dual.scan.scanner, dual.scan.sequence)
    z, points = engine.cloud(dual.scan.frames).z, engine.cloud(dual.scan.frames).points
    kept = z.copy()
    for _ in range(4):  # the memory of clouds that nobody holds is used again, and this is held
        engine.cloud(numpy.zeros((6, 240, 320), numpy.uint8))
    del engine
    gc.collect()
    assert numpy.array_equal(z, kept, equal_nan=True)
    assert numpy.array_equal(points[..., 2], kept, equal_nan=True)


def test_memory_of_a_dropped_cloud_is_used_again(dual, engine):
    where = address(engine.cloud(dual.scan.frames).z)
    for _ in range(3):
        assert address(engine.cloud(dual.scan.frames).z) == where
    held = engine.cloud(dual.scan.frames)
    assert address(engine.cloud(dual.scan.frames).z) != address(held.z)


def test_frames_are_borrowed_wherever_they_stand(dual, engine):
    right = engine.cloud(dual.scan.frames).z.copy()
    stack = numpy.stack(list(dual.scan.frames))
    wide = numpy.zeros((6, 300, 400), numpy.uint8)
    wide[:, 20:260, 30:350] = stack
    upside_down = numpy.ascontiguousarray(stack[:, ::-1])
    later = numpy.repeat(stack, 2, axis=0)
    for frames in [stack, list(stack), tuple(stack), wide[:, 20:260, 30:350],
                   upside_down[:, ::-1], later[::2]]:
        assert numpy.array_equal(engine.cloud(frames).z, right, equal_nan=True)


def test_sixteen_bits_and_unquantised():
    sequence = slipstream.Sequence(slipstream.Strategy("pmp", steps=4))
    for bits, dtype in [(12, numpy.uint16), (None, numpy.float64)]:
        taken = slipstream.simulate(sequence, camera=(160, 120), bits=bits)
        engine = slipstream.Engine(taken.scan.scanner, taken.scan.sequence)
        frames = list(taken.scan.frames)
        assert frames[0].dtype == dtype
        ours = engine.cloud(frames, bits=bits)
        assert numpy.array_equal(ours.z, engine.cloud(taken.scan.frames).z, equal_nan=True)


def test_merged_exposures_keep_their_gain(tmp_path):
    sequence = slipstream.Sequence("pmp, steps 4", exposures=[1, 4])
    taken = slipstream.simulate(
        sequence, tmp_path / "scan", camera=(160, 120), scene="contrast")
    scan = slipstream.load_scan(tmp_path / "scan")
    assert scan.frames.bits == 14 and len(scan.frames) == 4
    engine = slipstream.Engine(scan.scanner, scan.sequence)
    assert numpy.array_equal(
        engine.cloud(scan.frames).z, engine.cloud(taken.scan.frames).z, equal_nan=True)


def test_a_recording_gives_frames_to_read(dual, tmp_path):
    dual.scan.save(tmp_path / "scan.slip")
    recording = slipstream.Recording(tmp_path / "scan.slip")
    assert len(recording) == 6 and recording.finished
    assert recording.sequence == dual.scan.sequence
    for n, frame in enumerate(recording):
        assert frame.sequence == n and frame.bits == 8
        assert not frame.pixels.flags.writeable
        assert numpy.array_equal(frame.pixels, dual.scan.frames[n])
    assert n == 5
    with pytest.raises(IndexError):
        recording[6]
    bytes_of = bytearray((tmp_path / "scan.slip").read_bytes())
    bytes_of[len(bytes_of) // 2] ^= 255
    (tmp_path / "damaged.slip").write_bytes(bytes_of)
    damaged = slipstream.Recording(tmp_path / "damaged.slip")
    assert [damaged[n] is None for n in range(6)].count(True) == 1
    assert len(list(damaged)) == 5
