"""Calibration, gamma, noise and what is computed of arrays."""

import html
import math
import re

import numpy
import pytest
from conftest import program, taken

import slipstream

EIGHT = slipstream.Sequence("pmp, steps 8")


def scans(count, **world):
    return [slipstream.simulate(EIGHT, camera=(160, 120), scene="board", seed=n + 1, **world).scan
            for n in range(count)]


def test_gamma_is_found_and_corrected():
    found = slipstream.calibrate_gamma(scans(2, response=slipstream.Response(1.6)))
    assert found.response.gamma == pytest.approx(1.6, abs=0.02)
    blind = slipstream.find_gamma(scans(1, response=slipstream.Response(1.6))[0].frames, 8)
    assert blind.refusal == ""
    assert blind.gamma == pytest.approx(1.6, abs=0.05)
    bent = slipstream.Response(2.0).corrected(numpy.array([0.0, 1.0]), 3)
    assert bent[0] == pytest.approx(0, abs=1e-6) and abs(bent[1] - 1) > 0.01


def test_noise_and_ambient_are_found(tmp_path):
    world = {"world": "ideal", "noise_variance": 2.0, "ambient": 6.0}
    found = slipstream.calibrate_noise(scans(3, **world))
    assert found.variance == pytest.approx(2.0 + 1 / 12, rel=0.1)
    assert found.measurements[0].equation
    ambient = slipstream.calibrate_ambient(scans(2, **world), least_alpha=0.3)
    assert ambient.mode == pytest.approx(6, abs=0.5)
    for n, scan in enumerate(scans(2, **world)):
        scan.save(tmp_path / str(n))
    by_path = slipstream.calibrate_noise([tmp_path / "0", str(tmp_path / "1")])
    assert by_path.variance == pytest.approx(found.variance, rel=0.2)


def test_geometry_as_the_program(tmp_path):
    program("simulate", tmp_path / "poses", "--boards", "4", "--corners", "9x6", "--spacing", "20",
            "--camera", "640x480", "--strategy", "dual-frequency", "--steps", "3")
    program("calibrate", "geometry", tmp_path / "poses", "--corners", "9x6", "--spacing", "20",
            "-o", tmp_path / "scanner.yaml")
    found = slipstream.calibrate_geometry(
        tmp_path / "poses", tmp_path / "report", columns=9, rows=6, spacing=20)
    theirs = slipstream.load_scanner(tmp_path / "scanner.yaml")
    assert found.scanner.translation == pytest.approx(theirs.translation, abs=1e-9)
    assert found.rms["stereo"] < 0.5
    assert found.poses == ["board01", "board02", "board03", "board04"] and found.unused == {}
    page = (tmp_path / "report" / "report.html").read_text()
    assert "RMS" in found.text
    found.write(tmp_path / "again.html")
    assert (tmp_path / "again.html").read_text() == page
    shown = found._repr_html_()
    assert html.unescape(re.fullmatch('<iframe srcdoc="([^"]*)" [^>]*></iframe>', shown)[1]) == page
    assert 'src="data:image/png;base64,' in page and not re.search('(src|href)="(?!data:)', page)
    assert re.fullmatch(r"<slipstream.CalibrationReport 4 poses, RMS camera \S+, projector \S+, "
                        r"stereo \S+ pixels>", repr(found))
    found.scanner.noise_variance = 2.5
    assert found.scanner.noise_variance == 2.5  # its own, no copy


def test_phases_and_unwrapping_of_arrays(dual):
    frames, coordinate = dual.scan.frames, dual.coordinate
    mean, modulation, high = slipstream.phases(frames, 3)
    low = slipstream.phases(frames, 3, first=3)[2]
    ours = slipstream.unwrap(high, 16, low / (2 * math.pi))
    lit = (modulation > 20) & numpy.isfinite(coordinate)
    assert abs(numpy.median((ours - coordinate)[lit])) < 1e-4
    maps = slipstream.decode(frames, dual.scan.sequence)
    assert numpy.median(abs(maps.coordinate - ours)[lit]) < 1e-5
    assert numpy.allclose(maps.mean[lit], mean[lit], atol=1e-3)
    with pytest.raises(slipstream.Error):
        slipstream.phases(frames, 3, first=4)


def test_predicted_noise():
    variance = slipstream.phase_variance(4, 0.5, 255, 1.6)
    assert variance == pytest.approx(8 * 1.6 / (4 * 0.25 * 255**2))
    assert slipstream.coordinate_variance(variance, 16) == pytest.approx(
        variance / (2 * math.pi * 16) ** 2)
    many = slipstream.phase_variance(numpy.array([3, 4]), 0.5, 255, 1.6)
    assert many.shape == (2,)


def test_patterns_and_designs(tmp_path):
    sequence = slipstream.Sequence("dual-frequency, steps 3, high 8", projector=(64, 48))
    patterns = sequence.patterns()
    assert patterns.shape == (6, 48, 64) and patterns.dtype == numpy.uint8
    assert patterns[0].max() > 250 and sequence.patterns(bits=12).dtype == numpy.uint16
    paths = sequence.write_patterns(tmp_path)
    assert len(paths) == 6 and (tmp_path / "scan.yaml").exists()
    best = slipstream.design(frames=6)[0]
    assert best.strategy.frames <= 6 and best.coordinate_sigma > 0


def test_files_go_round(tmp_path):
    scan = taken("pmp", camera=(160, 120), steps=4).scan
    for name in ["scan", "scan.slip"]:
        scan.save(tmp_path / name)
        again = slipstream.load_scan(tmp_path / name)
        assert again.sequence == scan.sequence
        assert numpy.array_equal(again.frames[3], scan.frames[3])
    scan.scanner.write(tmp_path / "scanner.xml")
    assert slipstream.load_scanner(tmp_path / "scanner.xml").camera_size == (160, 120)
    other = slipstream.Sequence("pmp, steps 4, frequency 0.5", axis="x")
    told = slipstream.load_scan(tmp_path / "scan", other, scanner=scan.scanner)
    assert told.sequence.strategy == other.strategy
    by_file = slipstream.load_scan(tmp_path / "scan", scanner=tmp_path / "scanner.xml")
    assert by_file.scanner.translation == pytest.approx(scan.scanner.translation)
    slipstream.write_map(tmp_path / "map.tiff", scan.frames[0])
    assert numpy.array_equal(slipstream.load_map(tmp_path / "map.tiff"), scan.frames[0])
