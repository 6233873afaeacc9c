#!/usr/bin/env python3
"""Memory of `live` with four sinks, each with a quick and a slow client, beside busy processes.

tests/live/soak.py PROGRAM LISTENER [MINUTES [BUSY]]    2 minutes and 8 processes by default

LISTENER is soak_listener; without Cyclone DDS, "none". Exits with 1 if memory is more than 10 %
larger in the second half of the run than in the first.
"""

import multiprocessing
import os
import pathlib
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "publish"))
import gi
gi.require_version("Aravis", "0.8")
from gi.repository import Aravis
import web_test
from web_test import Live, ask_for_page, say, take_message

# With noise, sinks also publish uncertainties.
LIVE = ("live --source virtual --world ideal --virtual-noise 1.5 --rate 60 --camera 320x240 "
        "--strategy pmp --steps 4 --headless --json --limit 200MB,ring").split()
ADDRESS, NAMESPACE = "127.0.0.1", "soak"
DDS = ("<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast><Interfaces>"
       "<NetworkInterface address=\"127.0.0.1\"/></Interfaces></General><Discovery>"
       "<ParticipantIndex>auto</ParticipantIndex><Peers><Peer Address=\"127.0.0.1\"/></Peers>"
       "</Discovery></Domain></CycloneDDS>")


def spin():
    while True:
        pass


def read_pages(port, pause):
    """A page that takes a cloud, then rests; reconnects after it has been disconnected."""
    while True:
        try:
            client, _ = ask_for_page(port, origin=f"http://127.0.0.1:{port}")
            with client:
                while True:
                    say(client, b"next phase")
                    time.sleep(pause)
                    take_message(client)
        except (AssertionError, OSError):
            time.sleep(0.1)


def read_genicam():
    """The one client: 20 s quick, then 20 s slow."""
    camera = Aravis.Camera.new(ADDRESS)
    stream = camera.create_stream(None, None)
    for _ in range(4):
        stream.push_buffer(Aravis.Buffer.new_allocate(camera.get_payload()))
    camera.start_acquisition()
    while True:
        buffer = stream.timeout_pop_buffer(1_000_000)
        if buffer:
            stream.push_buffer(buffer)
        if time.monotonic() % 40 > 20:
            time.sleep(2)


def memories(live, minutes):
    """Memory every 2 s, MB, while a setting changes; prints one in 30 s."""
    samples, begin = [], time.monotonic()
    while (passed := time.monotonic() - begin) < 60 * minutes:
        if live.process.poll() is not None:
            sys.exit(f"live has ended: {live.words.read_text()}")
        if len(samples) % 15 == 0:
            sinks = ", ".join("{name} {published}".format(**sink)
                              for sink in live.statistics()["sinks"])
            print(f"{passed / 60:5.1f} min: {live.memory():6.1f} MB; load {os.getloadavg()[0]:.1f}; "
                  f"{sinks}", flush=True)
        live.change(f"min-modulation={5 + len(samples) % 2}")
        samples.append(live.memory())
        time.sleep(2)
    return samples


def main():
    program, listener, *given = sys.argv[1:]
    minutes, busy = [*given, *("2", "8")[len(given):]]
    web_test.PROGRAM = program
    os.environ.update(ROS_DOMAIN_ID=str(1 + os.getpid() % 200), CYCLONEDDS_URI=DDS)
    sinks = ["web:0", f"genicam:{ADDRESS}", "mcap:clouds.mcap"]
    sinks += [] if listener == "none" else [f"ros2:{NAMESPACE}"]
    command = [*LIVE, *(word for sink in sinks for word in ("--publish", sink))]
    listeners, clients = [], []
    with tempfile.TemporaryDirectory() as folder, \
            Live(pathlib.Path(folder), command=command) as live:
        work = [(spin, ())] * int(busy) + [(read_genicam, ())]
        work += [(read_pages, (live.port, pause)) for pause in (0, 3)]
        try:
            for target, arguments in work:
                clients.append(multiprocessing.Process(target=target, args=arguments, daemon=True))
                clients[-1].start()
            if listener != "none":
                listeners += [subprocess.Popen([listener, NAMESPACE, pause], stdout=subprocess.DEVNULL)
                              for pause in ("1", "3000")]
            samples = memories(live, float(minutes))
        finally:
            for process in clients + listeners:
                process.kill()
    half = len(samples) // 2
    before, after = max(samples[:half]), max(samples[half:])
    print(f"largest: {before:.1f} MB in the first half, {after:.1f} MB in the second")
    return 0 if after <= 1.1 * before else 1


if __name__ == "__main__":
    sys.exit(main())
