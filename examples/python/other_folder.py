"""Imports pictures taken by other software: other_folder.py PICTURES CALIBRATION.xml SCAN

For SLStudio and Fringes: pictures sorted by name, with no description of the patterns, and a
calibration in an OpenCV file of either program's layout."""

import sys

import slipstream

pictures, calibration, target = sys.argv[1:]
shown = slipstream.Sequence("dual-frequency, steps 3, high 16, low 1", projector=(1280, 800))
scan = slipstream.load_scan(pictures, shown, scanner=calibration)
for finding in slipstream.check(scan):
    print("warning:", finding)
scan.save(target)  # with a scan.yaml, which describes the patterns
print(slipstream.reconstruct(slipstream.load_scan(target)))
