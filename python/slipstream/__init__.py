"""slipstream: 3-D point clouds from pictures of an object under projected stripes."""

import atexit as _atexit
import contextlib as _contextlib
import enum as _enum
import weakref as _weakref

from . import _slipstream
from ._slipstream import *  # noqa: F403
from ._slipstream import __version__  # noqa: F401

Validity = _enum.IntEnum(
    "Validity",
    "VALID TOO_DARK SATURATED DOUBTFUL_ORDER NO_POINT OUTSIDE_FIELD OUT_OF_RANGE LOW_TRUST MIXED "
    "OUTLIER SMALL_COMPONENT OUTSIDE_REGION MOVED", start=0, module=__name__)
Validity.__doc__ = "Why a camera pixel has a point or is invalid: the numbers in Cloud.validity."

_SAYS = {
    "Strategy": "{0.label}",
    "Sequence": "{0.strategy.label} along {0.axis}, {0.frames} frames",
    "Response": "gamma {0.gamma:.4g}",
    "Scanner": "camera {0.camera_size}, projector {0.projector_size}",
    "Frames": "{1} of {0.size}, {0.bits} bits",
    "Scan": "{0.frames!r}, {0.sequence!r}",
    "Finding": "{0}",
    "Cloud": "{0.size}, {1} points",
    "Maps": "{0.mean.shape}",
    "Uncertainty": "{0.z.shape}",
    "Engine": "{0.scanner!r}, {0.sequence!r}",
    "Recording": "{1} frames, {0.sequence!r}",
    "Live": "{0.statistics[clouds]} clouds",
}


def _say(self):
    name = type(self).__name__
    count = len(self) if hasattr(self, "__len__") else None
    return f"<slipstream.{name} {_SAYS[name].format(self, count)}>"


@_contextlib.contextmanager
def threads(most):
    """Context manager: `with threads(1):` limits the threads of each call."""
    limit = _slipstream._ThreadLimit(most)
    try:
        yield
    finally:
        del limit


_running = _weakref.WeakSet()


def _start_live(self):
    _start(self)
    _running.add(self)
    return self


def _end_live(self, kind=None, *_):
    try:
        self.stop()
    except BaseException:
        if kind is None:  # otherwise the exception in progress matters more
            raise


@_atexit.register
def _end_all():  # their threads must not call a closed interpreter
    for live in list(_running):
        _end_live(live, "exit")


for _name, _bound in list(vars(_slipstream).items()):
    if isinstance(_bound, type):
        _bound.__module__ = __name__
    if _name in _SAYS:
        _bound.__repr__ = _say
_start, Live.start, Live.__enter__ = Live.start, _start_live, _start_live  # noqa: F405
Live.__exit__ = _end_live  # noqa: F405
Live.__iter__ = lambda self: self  # noqa: F405
Recording.__iter__ = lambda self: filter(  # noqa: F405
    lambda frame: frame is not None, map(self.__getitem__, range(len(self))))
