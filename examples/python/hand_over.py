"""Passes a cloud to Open3D and PyVista, if they are installed: hand_over.py SCAN

Install Open3D from Debian (python3-open3d) and PyVista from PyPI, which takes plain arrays."""

import importlib
import sys

import numpy

import slipstream

cloud = slipstream.reconstruct(slipstream.load_scan(sys.argv[1]))
valid = cloud.validity == slipstream.Validity.VALID
points = cloud.points[valid]  # N x 3
grey = numpy.clip(cloud.intensity[valid] / 255, 0, 1)
print(f"{len(points)} points, {points.dtype}, {points.shape[1]} columns")

try:
    print(cloud.to_open3d())
except ImportError:
    print("Open3D is not installed")

try:
    pyvista = importlib.import_module("pyvista")
except ImportError:
    print("PyVista is not installed")
else:
    surface = pyvista.PolyData(points)
    surface["intensity"] = grey
    print(surface)
