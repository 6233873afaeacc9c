"""Calibrates a rig from scans of boards and a surface: calibrate.py POSES FLAT... SCANNER.yaml

POSES has one folder per pose of a 9x6 chessboard with 20 mm squares, each with scans x and y.
FLAT: scans of the same surface, unmoved, with eight phase steps."""

import sys

import slipstream

poses, *flats, target = sys.argv[1:]
found = slipstream.calibrate_geometry(poses, columns=9, rows=6, spacing=20)
print(found.text)
for finding in found.findings:
    print("warning:", finding)
scanner = found.scanner
noise = slipstream.calibrate_noise(flats)
scanner.noise_variance, scanner.noise_gain = noise.variance, noise.gain
scanner.ambient = slipstream.calibrate_ambient(flats, least_alpha=0.2).mode
scanner.write(target)
print(f"{scanner}, noise variance {scanner.noise_variance:.2f}, ambient {scanner.ambient:.1f}")
