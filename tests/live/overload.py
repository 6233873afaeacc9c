#!/usr/bin/env python3
"""Clouds that `live` makes beside busy processes, against those of a free machine.

tests/live/overload.py PROGRAM [BUSY [SECONDS]]    8 processes and 20 s by default

Exits with 1 if a window is neither made nor counted, or if under 60 % of the clouds are made.
"""

import json
import subprocess
import sys

LIVE = ("live --source virtual --world ideal --rate 120 --camera 640x480 --strategy dual-frequency "
        "--steps 3 --high 16 --low 1 --headless --json").split()
FRAMES_PER_WINDOW = 6


def clouds_of(program, seconds, busy):
    spinning = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(busy)]
    try:
        run = subprocess.run([program, *LIVE, "--duration", str(seconds)], check=True, text=True,
                             stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    finally:
        for process in spinning:
            process.kill()
    told = json.loads(run.stdout)
    frames, latency = told["frames"], told["latency_ms"]
    print(f"{busy} busy: {told['clouds']} clouds, {told['windows_skipped']} windows skipped, "
          f"{told['windows_lost']} lost; frames: {frames['captured']} captured, {frames['lost']} "
          f"lost, {frames['overwritten']} overwritten; latency p50 {latency['p50']:.1f}, "
          f"p99 {latency['p99']:.1f} ms")
    windows = frames["captured"] + frames["lost"] - FRAMES_PER_WINDOW + 1
    counted = told["clouds"] + told["windows_skipped"] + told["windows_lost"]
    return told["clouds"], windows - counted


def main():
    program, *given = sys.argv[1:]
    busy, seconds = [*given, *("8", "20")[len(given):]]
    free, uncounted = clouds_of(program, seconds, 0)
    loaded, uncounted_loaded = clouds_of(program, seconds, int(busy))
    share = loaded / free
    print(f"{100 * share:.0f} % of the clouds; windows not counted: {uncounted}, {uncounted_loaded}")
    return 0 if share >= 0.6 and uncounted == uncounted_loaded == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
