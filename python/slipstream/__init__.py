"""slipstream: pictures of an object under projected stripes to a measured 3-D point cloud."""

import enum as _enum

from . import _slipstream
from ._slipstream import *  # noqa: F403
from ._slipstream import __version__  # noqa: F401


class Validity(_enum.IntEnum):
    """Why a camera pixel has a point or none: the numbers in Cloud.validity."""

    VALID = 0
    TOO_DARK = 1
    SATURATED = 2
    DOUBTFUL_ORDER = 3
    NO_POINT = 4
    OUTSIDE_FIELD = 5
    OUT_OF_RANGE = 6
    LOW_TRUST = 7
    MIXED = 8
    OUTLIER = 9
    SMALL_COMPONENT = 10
    OUTSIDE_REGION = 11
    MOVED = 12


for _thing in list(vars(_slipstream).values()):
    if isinstance(_thing, type):
        _thing.__module__ = __name__
