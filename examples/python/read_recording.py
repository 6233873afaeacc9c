"""Reads the frames of a recording, one by one and as scans: read_recording.py SCAN.slip"""

import sys

import slipstream

recording = slipstream.Recording(sys.argv[1])
print(recording)
for frame in recording:
    if frame.sequence < 3:
        print(f"frame {frame.sequence}: {frame.pixels.dtype} {frame.pixels.shape}, "
              f"brightest {frame.pixels.max()}")
scan = slipstream.load_scan(sys.argv[1], window=0)
print(f"its first cycle: {len(slipstream.reconstruct(scan))} points")
