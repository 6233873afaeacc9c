"""Your own decoder in numpy, compared with slipstream's: two frequencies, three steps each."""

import numpy
from numpy.typing import NDArray

import slipstream

Image = NDArray[numpy.float64]

sequence = slipstream.Sequence("dual-frequency, steps 3, high 16, low 1")
taken = slipstream.simulate(sequence, scene="sphere", camera=(320, 240))
frames = numpy.stack(list(taken.scan.frames)).astype(float)


def phase_of(three: Image) -> tuple[Image, Image]:
    angles = 2 * numpy.pi * numpy.arange(3) / 3
    sine = numpy.tensordot(numpy.sin(angles), three, 1)
    cosine = numpy.tensordot(numpy.cos(angles), three, 1)
    return numpy.arctan2(sine, cosine) % (2 * numpy.pi), numpy.hypot(sine, cosine) * 2 / 3


high, modulation = phase_of(frames[:3])
low, _ = phase_of(frames[3:])
order = numpy.round(16 * low / (2 * numpy.pi) - high / (2 * numpy.pi))
coordinate = (high / (2 * numpy.pi) + order) / 16

maps = slipstream.decode(taken.scan.frames, sequence)
assert maps.coordinate is not None
lit = modulation > 15
difference = numpy.abs(coordinate - maps.coordinate)[lit]
print(f"{lit.sum()} lit pixels; the median difference of the coordinates is "
      f"{numpy.median(difference):.1e} of the field")
