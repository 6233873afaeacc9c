"""Passes a cloud to Open3D and PyVista, if they are installed: hand_over.py SCAN

Install Open3D from Debian (python3-open3d) and PyVista from PyPI; both take plain arrays."""

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
    open3d = importlib.import_module("open3d")
except ImportError:
    print("Open3D is not installed")
else:
    open3d_cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    open3d_cloud.colors = open3d.utility.Vector3dVector(numpy.repeat(grey[:, None], 3, axis=1))
    open3d_cloud.normals = open3d.utility.Vector3dVector(cloud.normals()[valid])
    print(open3d_cloud)

try:
    pyvista = importlib.import_module("pyvista")
except ImportError:
    print("PyVista is not installed")
else:
    surface = pyvista.PolyData(points)
    surface["intensity"] = grey
    print(surface)
