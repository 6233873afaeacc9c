#!/usr/bin/python3
"""Unwraps phases with scikit-image: run spatial_table --npy FOLDER, then this with FOLDER."""

import pathlib
import sys
import time

import numpy
from skimage.restoration import unwrap_phase

for path in sorted(pathlib.Path(sys.argv[1]).glob("*-wrapped.npy")):
    wrapped = numpy.load(path)
    truth = numpy.load(str(path).replace("wrapped", "truth"))
    regions = numpy.load(str(path).replace("wrapped", "regions"))
    start = time.perf_counter()
    masked = numpy.ma.masked_array(numpy.nan_to_num(wrapped), numpy.isnan(wrapped))
    unwrapped = unwrap_phase(masked if masked.mask.any() else wrapped)
    took = time.perf_counter() - start
    off = numpy.rint((numpy.asarray(unwrapped) - truth) / (2 * numpy.pi))
    right = sum(numpy.unique(off[regions == region], return_counts=True)[1].max()
                for region in numpy.unique(regions[regions >= 0]))
    print(f"skimage       {path.name.removesuffix('-wrapped.npy'):20}  "
          f"right {100 * right / (regions >= 0).sum():8.4f} %  {took:8.3f} s", flush=True)
