"""Plots depth and rejected pixels with matplotlib: plot_depth.py SCAN PICTURE.png"""

import sys

import matplotlib  # type: ignore[import]

import slipstream

matplotlib.use("Agg")  # draws to a file, without a window
from matplotlib import pyplot  # noqa: E402

scan = slipstream.load_scan(sys.argv[1])
cloud = slipstream.reconstruct(scan)
figure, (left, right) = pyplot.subplots(1, 2, figsize=(12, 4.5))
depth = left.imshow(cloud.z, cmap="viridis_r")
left.set_title("depth, mm")
figure.colorbar(depth, ax=left)
counts = {name: count for name, count in cloud.counts.items() if count > 0}
right.barh(list(counts), list(counts.values()))
right.set_title("pixels")
figure.tight_layout()
figure.savefig(sys.argv[2])
print(f"{len(cloud)} points drawn")
