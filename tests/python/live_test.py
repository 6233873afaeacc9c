"""Live: frames to clouds as they come."""

import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from conftest import taken

import slipstream

SEQUENCE = slipstream.Sequence("pmp, steps 4")
SMALL = {"camera": (160, 120), "scene": "sphere"}


def test_newest_clouds_of_the_virtual_camera():
    with slipstream.Live("virtual", SEQUENCE, rate=200, most_frames=60, **SMALL) as live:
        clouds = list(live)
    assert 1 <= len(clouds) <= 60
    assert all(len(cloud) > 1000 for cloud in clouds)
    assert live.statistics["captured"] == 60 and not live.running
    assert live.statistics["clouds"] == 57
    assert live.findings == []


def test_every_cloud_to_a_function():
    counts = []
    with slipstream.Live("virtual", SEQUENCE, on_cloud=lambda cloud: counts.append(len(cloud)),
                         rate=0, most_frames=40, **SMALL) as live:
        for _ in live:
            pass
    assert len(counts) == 37 and min(counts) > 1000


def test_a_recording_is_a_source(tmp_path):
    taken("pmp", camera=(160, 120), steps=4, path=tmp_path / "scan.slip")
    with slipstream.Live(f"replay:{tmp_path / 'scan.slip'}", rate=0) as live:
        assert len(list(live)[-1]) > 1000


def test_threads_share_the_clouds_of_one_stream():
    with slipstream.Live("virtual", SEQUENCE, rate=200, most_frames=100, **SMALL) as live:
        with ThreadPoolExecutor(4) as pool:
            shares = [pool.submit(lambda: [len(cloud) for cloud in live]) for _ in range(4)]
            while not all(share.done() for share in shares):
                pass  # busy, so that several threads see a cloud before one takes it
    counts = [count for share in shares for count in share.result()]
    assert 1 <= len(counts) <= 97 and min(counts) > 1000


def test_what_a_function_throws_comes_out():
    def fail(cloud):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        with slipstream.Live("virtual", SEQUENCE, on_cloud=fail, rate=0, **SMALL) as live:
            for _ in live:
                pass


def test_what_is_raised_within_is_not_hidden():
    with pytest.raises(ZeroDivisionError):
        with slipstream.Live("virtual", SEQUENCE, rate=0, **SMALL):
            raise ZeroDivisionError


def test_it_ends_when_nobody_asks_any_more():
    live = slipstream.Live("virtual", SEQUENCE, rate=0, on_cloud=lambda cloud: None, **SMALL)
    live.start()
    time.sleep(0.05)
    del live  # while its thread calls Python
    held = []
    with slipstream.Live("virtual", SEQUENCE, rate=0, most_frames=40, **SMALL) as live:
        for cloud in live:
            held.append(cloud)  # as many as there are: each is a copy
    assert held


def test_it_ends_with_the_interpreter():
    script = """import slipstream, time
live = slipstream.Live("virtual", slipstream.Sequence("pmp, steps 4"), rate=0, camera=(160, 120),
                       on_cloud=lambda cloud: None).start()
time.sleep(0.2)"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_sources_are_refused_as_the_program_does():
    with pytest.raises(slipstream.Error, match="source"):
        slipstream.Live("nothing:3", SEQUENCE)
    with pytest.raises(slipstream.Error, match="no such file"):
        slipstream.Live("replay:nowhere", SEQUENCE)
    with pytest.raises(TypeError, match="did you mean rate"):
        slipstream.Live("virtual", SEQUENCE, ratte=3)
