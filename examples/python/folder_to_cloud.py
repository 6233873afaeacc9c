"""Reconstructs a scan folder: folder_to_cloud.py SCAN CLOUD.ply"""

import sys

import slipstream

cloud = slipstream.reconstruct(slipstream.load_scan(sys.argv[1]))
cloud.write(sys.argv[2])
print(cloud)
