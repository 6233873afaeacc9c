"""Pictures that other software took, brought over: other_folder.py PICTURES CALIBRATION.xml SCAN

As SLStudio and Fringes leave them: pictures in the order of their names, without a word of what they
show, and a calibration in an OpenCV file of its own layout."""

import sys

import slipstream

pictures, calibration, target = sys.argv[1:]
shown = slipstream.Sequence("dual-frequency, steps 3, high 16, low 1", projector=(1280, 800))
scan = slipstream.load_scan(pictures, shown, scanner=calibration)
for finding in slipstream.check(scan):
    print("mind:", finding)
scan.save(target)  # with a scan.yaml: from here on the folder says it itself
print(slipstream.reconstruct(slipstream.load_scan(target)))
