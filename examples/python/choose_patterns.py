"""Proposes patterns of at most twelve frames, and simulates a scan with each of the best three."""

import numpy

import slipstream

for choice in slipstream.design(frames=12, noise_variance=2.0)[:3]:
    sequence = slipstream.Sequence(choice.strategy, projector=(1280, 800))
    taken = slipstream.simulate(sequence, scene="statue", camera=(320, 240))
    cloud = slipstream.reconstruct(taken.scan)
    error = numpy.nanmedian(numpy.abs(cloud.z - taken.depth))
    print(f"{choice.strategy.label}: {sequence.frames} frames, sigma "
          f"{choice.coordinate_sigma:.1e}, median error {error:.3f} mm of {len(cloud)} points")
print(f"patterns: {sequence.patterns().shape}")
