"""`slipstream serve`: valid and invalid rig files; start, reload and stop of the service."""

import contextlib
import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import time

import numpy
import pytest

from web_test import PATIENCE, PROGRAM, SOURCES, Live, ask_for_page, say, take_message, wait_for

VIRTUAL = "source: virtual\nworld: ideal\ncamera: 64x48\nrate: 60\n"


class Service(Live):
    """A running service, and the status messages it sends to systemd."""

    def __init__(self, folder, rig, *words):
        (folder / "rig.yaml").write_text(rig)
        self.words = folder / "words"
        self.ear = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.ear.bind(str(folder / "ear"))
        self.ear.settimeout(PATIENCE)
        self.process = subprocess.Popen(
            words or [PROGRAM, "serve", "rig.yaml"], cwd=folder, stdout=self.words.open("w"),
            stderr=subprocess.STDOUT, env=dict(os.environ, NOTIFY_SOCKET=str(folder / "ear")))

    def wait_until_ready(self):
        while (told := self.ear.recv(1000)) != b"READY=1":
            assert told.startswith(b"STATUS=")
        self.address = re.findall(r"http://\S+", self.words.read_text())[-1]
        self.port = int(re.search(r":(\d+)/", self.address)[1])
        return self

    def hang_up(self):
        self.process.send_signal(signal.SIGHUP)

    def forget_messages(self):
        """Makes room for more: a full socket would block the service."""
        self.ear.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while self.ear.recv(1000):
                pass
        self.ear.settimeout(PATIENCE)

    def reload(self, rig):
        """Writes the rig file and reloads it. The service must take it."""
        (self.words.parent / "rig.yaml").write_text(rig)
        answers = r"restarting|old settings"
        before = len(re.findall(answers, self.words.read_text()))
        self.hang_up()
        wait_for(lambda: len(re.findall(answers, self.words.read_text())) > before)
        assert "old settings" not in self.words.read_text()
        self.wait_until_ready()

    def shows(self, name, value):
        """Whether the newest page shows this value; False while there is none."""
        assert self.process.poll() is None, self.words.read_text()
        addresses = re.findall(r"http://\S+:(\d+)/", self.words.read_text())
        if not addresses:
            return False
        self.address, self.port = "", int(addresses[-1])
        try:
            return self.settings()[name]["value"] == value
        except (ConnectionError, http.client.HTTPException):
            return False

    def __exit__(self, *_):
        super().__exit__()
        self.ear.close()


# Text appended to the four lines of VIRTUAL, line of the mistake, expected message.
MISTAKES = [
    ("stratgy: pmp", 5, "did you mean strategy?"),
    ("strategy: pmpx", 5, "did you mean pmp?"),
    ("strategy: pmp\nhigh: 16", 6, "has no setting 'high'; it has steps"),
    ("strategy: pmp\nsteps: 2", 6, "takes 3 to 4096"),
    ("steps: many", 5, "'many' is not a number"),
    ("steps: [3, 4]", 5, "steps"),
    ("motion: 1.5", 5, "1.5 is not a whole number"),
    ("minimum-modulation: lots", 5, "'lots' is not a number"),
    ("min_modulation: -3", 5, "0 grey levels or more"),
    ("keep-saturated: perhaps", 5, "expected true or false"),
    ("exposure:", 5, "expected a value or a list of values"),
    ("filters: {deep: {nearest: 5}}", 5, "expected a value or a list of values"),
    ("nearest: 500\nfarthest: 300", 6, "more than the nearest"),
    ("largest-sigma: -1", 5, "out of range"),
    ("rate: 30", 5, "rate is set twice"),
    ("frames: 0", 5, "1 or more"),
    ("indexing: tod", 5, "one of source, counted, marker"),
    ("gamma: bright", 5, "scanner, blind, none or a number"),
    ("box: [1, 2, 3]", 5, "expected 6 numbers in mm, got 3"),
    ("track: cube", 5, "sphere:RADIUS"),
    ("model: model.obj", 5, "use .ply, .pcd, .xyz"),
    ("scene: statute", 5, "did you mean statue?"),
    ("mesh: nowhere.ply", 5, "nowhere.ply: no such file"),
    ("record: nowhere/scan.slip", 5, "No such file or directory"),
    ("record: ../scan.slip", 5, "only to the working folder"),
    ("record: scan.png", 5, "use .slip"),
    ("publish: [web:0, 'tcp:0.0.0.0:0']", 5, "only with --public"),
    ("publish: [web]", 5, "expected web:[ADDRESS:]PORT"),
    ("publish: [web:0, wbe:1]", 5, "did you mean web?"),
    ("publish: [web:0, web:0]", 5, "given twice"),
    ("publish: web:70000", 5, "a port"),
    ("publish: [web:0, mcap:nowhere/x.mcap]", 5, "No such file or directory"),
    ("source: aravis:", 5, "quote values that have a colon, e.g. name: 'a: b'"),
    ("camera: [", 7, "not YAML"),
    ("threads: -2", 5, "0 (all cores) or more"),
]


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake[0].replace("\n", "; "))
def test_a_mistake_is_one_line_that_says_where_and_what_would_be_right(tmp_path, mistake):
    text, line, words = mistake
    sink = "" if "publish" in text else "publish: web:0\n"
    (tmp_path / "rig.yaml").write_text(VIRTUAL + text + "\n" + sink)
    done = subprocess.run([PROGRAM, "serve", "rig.yaml"], cwd=tmp_path, capture_output=True,
                          text=True, timeout=PATIENCE)
    assert done.returncode in (1, 2) and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith(f"slipstream: rig.yaml: line {line}: "), done.stderr
    assert words in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["rig.yaml"], "a run was half begun"


@pytest.mark.parametrize("rig, words", [
    (None, "rig.yaml: no such file"), ("", "rig.yaml: line 1: expected a map of settings"),
    ("- source", "rig.yaml: line 1: expected a map"), (VIRTUAL, "publish: [web:8080]"),
    ("source: replay:scan.slip\npublish: web:0", "rig.yaml: line 1: scan.slip: no such file"),
    ("source: aravis:nobody\nstrategy: pmp\npublish: web:0", "nobody"),
    ("source: v4l2:77\nstrategy: pmp\npublish: web:0", "--monitor"),
    ("source: v4l2:77\nindexing: marker\nstrategy: pmp\npublish: web:0", "video77")])
def test_so_is_a_file_that_says_too_little(tmp_path, rig, words):
    if rig is not None:
        (tmp_path / "rig.yaml").write_text(rig)
    done = subprocess.run([PROGRAM, "serve", "rig.yaml"], cwd=tmp_path, capture_output=True,
                          text=True, timeout=PATIENCE)
    assert done.returncode in (1, 2) and done.stderr.count("\n") == 1, done.stderr
    assert words in done.stderr


def test_it_is_ready_when_it_answers_and_ends_whole_by_sigterm(tmp_path):
    rig = VIRTUAL + "publish: [web:0, mcap:clouds.mcap]\nrecord: frames.slip\nminimum-modulation: 20\n"
    with Service(tmp_path, rig).wait_until_ready() as service:
        wait_for(lambda: service.get("/health") == (200, "ok\n"))
        assert service.settings()["minimum-modulation"]["value"] == "20"
        assert service.change("minimum-modulation=200")[0] == 400
        wait_for(lambda: service.statistics()["clouds"] > 20)
        service.process.send_signal(signal.SIGTERM)
        assert service.process.wait(PATIENCE) == 0, service.words.read_text()
    assert (tmp_path / "clouds.mcap").read_bytes().endswith(b"\x89MCAP0\r\n")
    assert subprocess.run([PROGRAM, "check", tmp_path / "frames.slip"]).returncode == 0
    assert not [*tmp_path.glob("*.part*")]


def test_the_phase_that_a_page_gets_is_that_of_the_frames(tmp_path):
    for words in ("record --source virtual --world ideal --camera 64x48 --strategy pmp --steps 4 "
                  "--frames 4 --rate 0 -o scan.slip",
                  "reconstruct scan.slip -o cloud.ply --phase phase.npy --modulation light.npy"):
        subprocess.run([PROGRAM, *words.split()], cwd=tmp_path, check=True, capture_output=True)
    rig = "source: replay:scan.slip\nloop: true\nrate: 60\npublish: web:0\n"
    with Service(tmp_path, rig).wait_until_ready() as service:
        client, _ = ask_for_page(service.port, origin=f"http://127.0.0.1:{service.port}")
        with client:
            say(client, b"next phase")
            message = take_message(client)[1]
    told = numpy.frombuffer(message, numpy.uint8, offset=24 + 3 * 64 * 48).astype(float)
    step = numpy.load(tmp_path / "phase.npy").ravel() * 255 / (2 * numpy.pi)
    is_lit = numpy.load(tmp_path / "light.npy").ravel() >= 15
    assert 0.1 < is_lit.mean() < 0.99
    assert numpy.array_equal(told > 0, is_lit)
    assert numpy.abs(told - 1 - numpy.floor(step))[is_lit].max() <= 1


def test_sighup_reads_the_file_again_in_the_same_process(tmp_path):
    with Service(tmp_path, VIRTUAL + "publish: web:0\n").wait_until_ready() as service:
        (tmp_path / "rig.yaml").write_text(VIRTUAL + "publish: web:0\nminimum-modulation: 33\n")
        service.process.send_signal(signal.SIGHUP)
        service.wait_until_ready()
        assert service.settings()["minimum-modulation"]["value"] == "33"


def test_each_reload_runs_with_the_strategy_of_the_file(tmp_path):
    def rig(steps, high):
        return f"{VIRTUAL}strategy: dual-frequency\nsteps: {steps}\nhigh: {high}\npublish: web:0\n"

    rigs = [(4, 16), (3, 8), (5, 16)]
    with Service(tmp_path, rig(*rigs[0])).wait_until_ready() as service:
        for n in range(int(os.environ.get("SLIPSTREAM_RELOADS", "20"))):
            steps, high = rigs[n // 2 % len(rigs)]  # every other file is unchanged
            service.reload(rig(steps, high))
            assert set(service.settings()["strategy"]["value"].split(", ")) == {
                "dual-frequency", f"steps {steps}", f"high {high}", "low 1"}, n


def test_sighup_never_ends_it(tmp_path):
    def rig(least):
        return f"{VIRTUAL}publish: web:0\nminimum-modulation: {least}\n"

    def takes_signals(process):
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        return int(re.search(r"SigCgt:\s+(\w+)", status)[1], 16) >> (signal.SIGHUP - 1) & 1

    with Service(tmp_path, rig(20)) as service:
        wait_for(lambda: takes_signals(service.process))
        service.hang_up()
        service.wait_until_ready()
        service.wait_until_ready()  # it has read the file once more

        # During a reload, at once and later.
        for least, pause in enumerate((0, 0.02, 0.1, 0.2, 0.5), 30):
            service.hang_up()
            time.sleep(pause)
            (tmp_path / "rig.yaml").write_text(rig(least))
            service.hang_up()
            wait_for(lambda: service.shows("minimum-modulation", str(least)))
            service.forget_messages()

        service.process.send_signal(signal.SIGTERM)
        service.hang_up()
        assert service.process.wait(PATIENCE) == 0, service.words.read_text()


@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("pause", [0, 0.03, 0.1, 0.3])
def test_a_signal_during_a_reload_ends_it_in_order(tmp_path, pause, end):
    with Service(tmp_path, VIRTUAL + "publish: web:0\n").wait_until_ready() as service:
        service.hang_up()
        time.sleep(pause)
        service.process.send_signal(end)
        assert service.process.wait(PATIENCE) == 0, service.words.read_text()


def test_what_was_written_before_a_reload_or_a_restart_stays(tmp_path):
    rig = VIRTUAL + "publish: [web:0, mcap:clouds.mcap]\nrecord: frames.slip\n"
    with Service(tmp_path, rig).wait_until_ready() as service:
        for name in ("clouds.mcap", "clouds-2.mcap"):
            wait_for(lambda: service.statistics()["clouds"] > 20)
            assert service.statistics()["sinks"][1]["name"] == f"mcap:{name}"
            service.process.send_signal(signal.SIGHUP)
            service.wait_until_ready()
        wait_for(lambda: service.statistics()["clouds"] > 20)
        service.process.send_signal(signal.SIGTERM)
        assert service.process.wait(PATIENCE) == 0
        assert "clouds.mcap already exists; writing clouds-2.mcap" in service.words.read_text()
    (tmp_path / "ear").unlink()
    before = {path: path.read_bytes() for path in tmp_path.glob("*.*") if path.suffix != ".yaml"}
    assert {path.name for path in before} == {
        f"{stem}{copy}{ending}" for stem, ending in (("clouds", ".mcap"), ("frames", ".slip"))
        for copy in ("", "-2", "-3")}
    with Service(tmp_path, rig).wait_until_ready() as service:
        wait_for(lambda: service.statistics()["clouds"] > 20)
        service.process.send_signal(signal.SIGTERM)
        assert service.process.wait(PATIENCE) == 0
    assert (tmp_path / "clouds-4.mcap").exists() and (tmp_path / "frames-4.slip").exists()
    assert all(path.read_bytes() == content for path, content in before.items())


@pytest.mark.parametrize("bad, words, shows_at_once", [
    ("stratgy: pmp\n", "rig.yaml: line 1: no command has a setting 'stratgy'", True),
    (VIRTUAL + "publish: [wbe:1]\n", "rig.yaml: line 5: --publish wbe:1", True),
    (VIRTUAL + "mesh: nowhere.ply\npublish: web:0\n", "line 5: nowhere.ply: no such file", False),
    (VIRTUAL + "publish: [web:0, mcap:nowhere/x.mcap]\n", "line 5: cannot write nowhere/x.mcap", True)])
def test_it_goes_on_with_the_old_file_where_the_new_one_is_no_good(tmp_path, bad, words,
                                                                 shows_at_once):
    with Service(tmp_path, VIRTUAL + "publish: web:0\nminimum-modulation: 33\n") as service:
        service.wait_until_ready()
        wait_for(lambda: service.statistics()["clouds"] > 5)
        (tmp_path / "rig.yaml").write_text(bad)
        service.process.send_signal(signal.SIGHUP)
        wait_for(lambda: "continuing with the old settings" in service.words.read_text())
        if not shows_at_once:
            service.wait_until_ready()
        before = service.statistics()["clouds"]
        assert not shows_at_once or before > 5, "the run was interrupted"
        wait_for(lambda: service.statistics()["clouds"] > before)
        assert service.settings()["minimum-modulation"]["value"] == "33"
        said = [line for line in service.words.read_text().splitlines() if "continuing" in line]
        assert len(said) == 1 and words in said[0], said
        (tmp_path / "rig.yaml").write_text(VIRTUAL + "publish: web:0\n")
        service.process.send_signal(signal.SIGHUP)
        service.wait_until_ready()
        assert service.settings()["minimum-modulation"]["value"] != "33"
        service.process.send_signal(signal.SIGTERM)
        assert service.process.wait(PATIENCE) == 0


def test_a_sink_that_failed_is_told(tmp_path):
    if os.geteuid() != 0:
        pytest.skip("a small tmpfs needs root and the right to mount")
    small = tmp_path / "small"
    small.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "none", small]).returncode != 0:
        pytest.skip("a small tmpfs needs root and the right to mount")
    try:
        rig = VIRTUAL.replace("64x48", "320x240") + "publish: [web:0, mcap:small/clouds.mcap]\n"
        with Service(tmp_path, rig).wait_until_ready() as service:
            wait_for(lambda: service.get("/health")[0] == 503)
            assert "clouds.mcap" in service.get("/health")[1]
            before = service.statistics()["clouds"]
            wait_for(lambda: service.statistics()["clouds"] > before)

            # With room again, a reload begins a new file, though the old one is incomplete.
            for path in small.iterdir():
                path.unlink()
            service.hang_up()
            service.wait_until_ready()
            wait_for(lambda: service.statistics()["clouds"] > 0)
    finally:
        subprocess.run(["umount", small], check=True)


@pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="systemd-analyze is not there")
def test_systemd_takes_the_unit(tmp_path):
    text = (SOURCES / "packaging" / "slipstream@.service.in").read_text()
    program = pathlib.Path(PROGRAM)
    unit = tmp_path / "slipstream@.service"
    unit.write_text(text.replace("@CMAKE_INSTALL_FULL_BINDIR@", str(program.parent)))
    done = subprocess.run(["systemd-analyze", "verify", unit], capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr
