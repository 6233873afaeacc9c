#!/usr/bin/python3
"""Times Engine.cloud from numpy, from several threads, and the row `engine` of `slipstream bench`.

bench_python.py PROGRAM, with the module on PYTHONPATH. The scan is the row's: 640x480, N = 3.
"""

import json
import statistics
import subprocess
import sys
import threading
import time

import numpy

import slipstream

SCANS = 200


def bench_engine():
    sequence = slipstream.Sequence(slipstream.Strategy("pmp", steps=3))
    taken = slipstream.simulate(sequence, world="ideal", ambient=5, noise_variance=1.55)
    scanner = slipstream.example_scanner()
    scanner.ambient = 5
    frames = numpy.stack(list(taken.scan.frames))
    return slipstream.Engine(scanner, taken.scan.sequence), frames


def milliseconds(work):
    """Median time of SCANS calls."""
    times = []
    for _ in range(SCANS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


def milliseconds_in_program(program):
    finished = subprocess.run(
        [program, "bench", "--threads", "1", "--json"], capture_output=True, check=True)
    rows = json.loads(finished.stdout)["rows"]
    return next(row for row in rows if row["name"] == "engine" and row["steps"] == 3
                and row["threads"] == 1)["ms"]


def clouds_per_second(engine, frames, count):
    def work():
        for _ in range(SCANS):
            engine.cloud(frames)

    threads = [threading.Thread(target=work) for _ in range(count)]
    start = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return count * SCANS / (time.perf_counter() - start)


def main():
    engine, frames = bench_engine()
    with slipstream.threads(1):
        in_python = milliseconds(lambda: engine.cloud(frames))
        alone = clouds_per_second(engine, frames, 1)
        eight = clouds_per_second(engine, frames, 8)
        points = milliseconds(lambda: engine.cloud(frames).points)
    print(f"Engine.cloud from numpy: {in_python:.3f} ms; with .points {points:.3f} ms")
    print(f"8 threads: {eight:.0f} clouds per second, {eight / alone:.2f} times one thread")
    if len(sys.argv) > 1:
        in_program = milliseconds_in_program(sys.argv[1])
        print(f"row engine of slipstream bench: {in_program:.3f} ms; "
              f"Python takes {in_python / in_program:.3f} times that")


if __name__ == "__main__":
    main()
