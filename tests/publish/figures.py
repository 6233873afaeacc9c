"""Measures the cost of sinks and page for docs/how-to/publish.md: figures.py sinks or figures.py page."""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

from chromium import Chromium
from web_test import PROGRAM, Live, wait_for

FRAMES = ["--source", "virtual", "--world", "ideal", "--rate", "120", "--strategy", "pmp", "--steps", "4"]
SINKS = ["web:0", "mcap:clouds.mcap", "genicam:127.0.0.1", "ros2:scanner"]


def sinks(folder):
    for turn in range(3):
        for chosen in [], *([sink] for sink in SINKS), SINKS:
            flags = [word for sink in chosen for word in ("--publish", sink)]
            done = subprocess.run([PROGRAM, "live", *FRAMES, "--headless", "--json", "--duration", "8",
                                   *flags], cwd=folder, capture_output=True, text=True)
            if done.returncode != 0:
                print(done.stderr.splitlines()[-1])
                continue
            told = json.loads(done.stdout)
            capture = told["stages"][0]["latency_ms"]
            print(f"{' '.join(chosen) or 'none'}: {told['frames']['lost']} lost,"
                  f" {told['frames']['overwritten']} overwritten of {told['frames']['captured']},"
                  f" {told['clouds']} clouds, capture 99th percentile {capture['p99']:.2f} ms, longest"
                  f" {capture['max']:.2f} ms;",
                  ", ".join(f"{sink['published']}, {sink['dropped']} dropped" for sink in told["sinks"]))


def page(folder):
    with Live(folder, size="640x480", rate=30) as live:
        for turn in range(3):
            with Chromium() as browser:
                browser.look_like(1280, 800)
                browser.value("new Promise(done => setTimeout(done, 3000))")  # wait until Chromium has started
                begin = time.monotonic()
                browser.ask("Page.navigate", url=live.address)
                wait_for(lambda: browser.value("typeof cloud !== 'undefined' && !!cloud"))
                first = time.monotonic() - begin
                browser.value("new Promise(done => setTimeout(done, 5000))")
                rate = browser.value("seen.filter(time => time > performance.now() - 2000).length / 2")
                drawing = browser.value("(() => { const begin = performance.now(); draw();"
                                        " return performance.now() - begin; })()")
                print(f"first cloud after {first:.1f} s, then {rate:.0f} per second, drawn in {drawing:.0f} ms")


with tempfile.TemporaryDirectory() as name:
    {"sinks": sinks, "page": page}[sys.argv[1]](pathlib.Path(name))
