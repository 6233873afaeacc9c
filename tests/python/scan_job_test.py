"""Daily: scans of two cameras and along both axes, and a broken one, give the same from Python as
from the program. Not a case of clouds_test.py, which has one camera and one axis."""

import json
import pickle

import numpy
import pytest
from conftest import as_printed, program, run_program

import slipstream

SCANS = [("--second-camera",), ("--axis", "both"), ("--second-camera", "--axis", "both")]


@pytest.mark.parametrize("flags", SCANS)
def test_clouds_are_those_of_the_program(flags, tmp_path):
    scan = tmp_path / "scan"
    program("simulate", scan, "--camera", "160x120", "--strategy", "dual-frequency", *flags)
    program("reconstruct", scan, "-o", tmp_path / "program.ply")

    slipstream.reconstruct(slipstream.load_scan(scan)).write(tmp_path / "python.ply")
    assert (tmp_path / "python.ply").read_bytes() == (tmp_path / "program.ply").read_bytes()


@pytest.mark.parametrize("cameras", [2, 3])
def test_fused_clouds_are_those_of_the_program(cameras, tmp_path):
    scan = tmp_path / "scan"
    program("simulate", scan, "--camera", "160x120", "--strategy", "dual-frequency",
            *["--second-camera"] * (cameras - 1))
    program("reconstruct", scan, "--fuse", "-o", tmp_path / "program.ply")

    fused = slipstream.reconstruct(scan, fuse=cameras == 2)
    told = slipstream.load_cloud(tmp_path / "program.ply")
    assert len(fused) == len(told) > len(slipstream.load_scan(scan).frames)
    assert numpy.array_equal(fused.points, told.points)
    assert numpy.array_equal(fused.intensity, told.intensity)


def test_matched_cameras_refuse_reflection(tmp_path):
    program("simulate", tmp_path / "scan", "--camera", "160x120", "--second-camera")
    with pytest.raises(slipstream.Error, match="`reflection` and `local_reflection` need one"):
        slipstream.reconstruct(tmp_path / "scan", reflection=3)


def test_a_broken_scan_is_refused_by_both(tmp_path):
    scan = tmp_path / "scan"
    program("simulate", scan, "--camera", "160x120", "--strategy", "dual-frequency")
    (scan / "frame_01.png").rename(tmp_path / "one.png")
    (scan / "frame_02.png").rename(scan / "frame_01.png")
    (tmp_path / "one.png").rename(scan / "frame_02.png")

    refused = run_program("reconstruct", scan, "-o", tmp_path / "program.ply", "--json")
    assert refused.returncode == 2
    with pytest.raises(slipstream.Error) as error:
        slipstream.reconstruct(slipstream.load_scan(scan))
    assert as_printed(error.value) in refused.stderr

    # With the same identifiers and settings.
    told = json.loads(refused.stdout)["findings"]
    findings = error.value.findings
    assert [one.kind for one in findings] == [one["kind"] for one in told]
    assert [one.causes for one in findings] == [
        [cause["kind"] for cause in one["causes"]] for one in told]
    assert findings[0].remedies == [one["settings"] for one in told[0]["remedies"]]
    assert findings[0].remedies[0] == {"order": "0,2,1,3,4,5"}

    # Also out of a process pool.
    copied = pickle.loads(pickle.dumps(error.value))
    assert [str(one) for one in copied.findings] == [str(one) for one in findings]
    assert copied.findings[0].remedies == findings[0].remedies


def test_only_refused_scans_have_findings(tmp_path):
    with pytest.raises(slipstream.Error) as error:
        slipstream.load_scan(tmp_path / "missing")
    assert error.value.findings == []
