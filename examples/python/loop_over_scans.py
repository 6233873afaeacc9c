"""Reconstructs many scans with one engine: tables are built once, frames are not copied, and memory
of released clouds is reused. Threads share the engine."""

from concurrent.futures import ThreadPoolExecutor

import numpy

import slipstream

sequence = slipstream.Sequence("pmp, steps 3")
scan = slipstream.simulate(sequence, scene="sphere", camera=(320, 240)).scan
assert scan.scanner is not None
engine = slipstream.Engine(scan.scanner, scan.sequence)

ring = numpy.empty((8, 3, 240, 320), numpy.uint8)  # as filled by a camera driver
for frames in ring:
    for n, pixels in enumerate(scan.frames):
        frames[n] = pixels

with ThreadPoolExecutor() as pool:
    points = list(pool.map(lambda frames: len(engine.cloud(frames)), ring))
print(f"{len(points)} clouds of {points[0]} points")
