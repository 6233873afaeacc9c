"""A scan that is saved and loaded is the same, also along both axes, guarded or of two cameras."""

import numpy
import pytest
from conftest import program

import slipstream


def assert_same(scan, other):
    assert scan.sequence == other.sequence
    for one, two in zip(scan.frames, other.frames, strict=True):
        assert numpy.array_equal(one, two)
    for one, two in zip(scan.other_axis, other.other_axis, strict=True):
        assert_same(one, two)
    for one, two in zip(scan.guard, other.guard, strict=True):
        assert_same(one, two)
    for one, two in zip(scan.further_cameras, other.further_cameras, strict=True):
        assert_same(one, two)
    assert (scan.scanner is None) == (other.scanner is None)


@pytest.mark.parametrize("name", ["saved", "saved.slip"])
@pytest.mark.parametrize("label", ["pmp, steps 4", "gray-phase, steps 4, periods 16"])
def test_both_axes_are_saved(name, label, tmp_path):
    both = slipstream.Sequence(label, axis="both")
    scan = slipstream.simulate(both, camera=(160, 120)).scan
    scan.save(tmp_path / name)
    again = slipstream.load_scan(tmp_path / name)
    assert len(again.other_axis) == 1
    assert_same(again, scan)
    assert numpy.array_equal(slipstream.reconstruct(again).z, slipstream.reconstruct(scan).z,
                             equal_nan=True)


def test_unquantised_frames_along_both_axes_are_saved(tmp_path):
    both = slipstream.Sequence("pmp, steps 3", axis="both")
    scan = slipstream.simulate(both, camera=(64, 48), bits=None).scan
    scan.save(tmp_path / "saved")
    again = slipstream.load_scan(tmp_path / "saved")
    assert again.frames[0].dtype == numpy.float64
    assert len(again.frames) == len(again.other_axis[0].frames) == 3


def test_a_second_camera_is_saved(tmp_path):
    program("simulate", tmp_path / "two", "--second-camera", "--camera", "160x120")
    scan = slipstream.load_scan(tmp_path / "two")
    scan.save(tmp_path / "saved")
    again = slipstream.load_scan(tmp_path / "saved")
    assert len(again.further_cameras) == 1
    assert_same(again, scan)
    assert numpy.array_equal(slipstream.reconstruct(again).z, slipstream.reconstruct(scan).z,
                             equal_nan=True)
    with pytest.raises(slipstream.Error, match="a recording holds one camera"):
        scan.save(tmp_path / "saved.slip")


def test_a_guard_is_saved(tmp_path):
    program("simulate", tmp_path / "scan", "--guard", "--camera", "160x120")
    scan = slipstream.load_scan(tmp_path / "scan")
    scan.save(tmp_path / "saved")
    again = slipstream.load_scan(tmp_path / "saved")
    assert len(again.guard) == 1
    assert_same(again, scan)
    with pytest.raises(slipstream.Error, match="a recording holds no guard"):
        scan.save(tmp_path / "saved.slip")


def test_merged_exposures_are_not_saved(tmp_path):
    """Their grey levels mean nothing without the gain of each pixel."""
    sequence = slipstream.Sequence("pmp, steps 4", exposures=[1, 4])
    scan = slipstream.simulate(sequence, tmp_path / "scan", camera=(64, 48)).scan
    with pytest.raises(slipstream.Error, match="merged of 2 exposures.*copy the original scan"):
        scan.save(tmp_path / "saved")
    assert slipstream.load_scan(tmp_path / "scan").exposures == [1, 4]


def test_a_cloud_warns_if_32_bits_are_too_few(tmp_path, recwarn):
    (tmp_path / "near.xyz").write_text("1.5 2.5 3.5\n")
    slipstream.load_cloud(tmp_path / "near.xyz")
    assert not recwarn.list
    (tmp_path / "far.xyz").write_text("4500000.123 2.5 3.5\n4500001.456 2 3\n")
    with pytest.warns(UserWarning, match="far.xyz: its coordinates are rounded to 32 bits"):
        slipstream.load_cloud(tmp_path / "far.xyz")
