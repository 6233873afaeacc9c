"""3-D point clouds from pictures of an object under projected stripes.

Example:
    >>> import numpy, slipstream
    >>> sequence = slipstream.Sequence("dual-frequency, steps 3, high 16")
    >>> scan = slipstream.simulate(sequence, camera=(160, 120)).scan
    >>> engine = slipstream.Engine(scan.scanner, sequence)
    >>> cloud, maps = engine.cloud_and_maps(scan.frames)
    >>> bright = {"scene": "board", "camera": (64, 48)}
    >>> eight = slipstream.Sequence("pmp, steps 8")
    >>> flats = [slipstream.simulate(eight, seed=seed, **bright).scan for seed in (1, 2)]
"""

import atexit as _atexit
import base64 as _base64
import contextlib as _contextlib
import enum as _enum
import html as _html
import pathlib as _pathlib
import tempfile as _tempfile
import types as _types
import weakref as _weakref

import numpy as _numpy

from . import _arguments, _slipstream
from ._slipstream import *  # noqa: F403
from ._slipstream import __version__  # noqa: F401

_arguments.explain(globals())


class Validity(_enum.IntEnum):
    """Why a camera pixel has a point or is invalid: the numbers in Cloud.validity.

    Example:
        >>> int((cloud.validity == slipstream.Validity.VALID).sum()) == len(cloud)
        True
    """

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
    REFLECTED = 13


@_contextlib.contextmanager
def threads(most):
    """Context manager that limits the threads of each call.

    Args:
        most (int): 1 or more.

    Returns:
        AbstractContextManager[None]

    Example:
        >>> with slipstream.threads(1): alone = engine.cloud(scan.frames)
    """
    limit = _slipstream._ThreadLimit(most)
    try:
        yield
    finally:
        del limit


# Short texts: each class's figures in one line.


def _size_text(size):
    width, height = size
    return f"{width}x{height}"


def _sequence_text(sequence):
    return f"{sequence.strategy.label} along {sequence.axis}, {sequence.frames} frames"


def _scanner_text(scanner):
    baseline = _numpy.linalg.norm(scanner.translation)
    return (f"camera {_size_text(scanner.camera_size)}, "
            f"projector {_size_text(scanner.projector_size)}, {baseline:.4g} mm apart")


def _frames_text(frames):
    return f"{len(frames)} of {_size_text(frames.size)}, {frames.bits} bits"


def _cloud_text(cloud):
    text = f"{_size_text(cloud.size)}: {len(cloud)} points of {cloud.z.size} pixels"
    if not cloud:
        return text
    return f"{text}, {_numpy.nanmin(cloud.z):.1f} to {_numpy.nanmax(cloud.z):.1f} mm"


def _maps_text(maps):
    median = _numpy.nanquantile(maps.modulation, 0.5)
    return f"{_size_text(maps.mean.shape[::-1])}: median modulation {median:.3g}"


def _uncertainty_text(uncertainty):
    known = uncertainty.z[uncertainty.z > 0]
    median = _numpy.median(known) if known.size else 0
    return f"{_size_text(uncertainty.z.shape[::-1])}: median {median:.3g} mm of depth"


def _report_text(report):
    errors = ", ".join(
        f"{device} {report.rms[device]:.3g}" for device in ("camera", "projector", "stereo"))
    return f"{len(report.poses)} poses, RMS {errors} pixels"


def _live_text(live):
    return f"{live.statistics['clouds']} clouds, {'running' if live.running else 'stopped'}"


_TEXTS = {
    "Strategy": lambda strategy: strategy.label,
    "Sequence": _sequence_text,
    "Response": lambda of: f"gamma {of.gamma:.4g} +- {of.standard_error:.2g}",
    "Scanner": _scanner_text,
    "Frames": _frames_text,
    "Scan": lambda scan: f"{scan.frames!r}, {scan.sequence!r}",
    "Finding": str,
    "Cloud": _cloud_text,
    "Maps": _maps_text,
    "Uncertainty": _uncertainty_text,
    "Engine": lambda engine: f"{engine.scanner!r}, {engine.sequence!r}",
    "Recording": lambda recording: f"{len(recording)} frames, {recording.sequence!r}",
    "CalibrationReport": _report_text,
    "Live": _live_text,
}


def _text_of(self):
    name = type(self).__name__
    if not _slipstream._is_constructed(self):
        return f"<slipstream.{name} not constructed>"
    return f"<slipstream.{name} {_TEXTS[name](self)}>"


for _name in _TEXTS:
    globals()[_name].__repr__ = _text_of


def _value_text(value):
    if not isinstance(value, _numpy.ndarray):
        return repr(value)
    shape = " x ".join(map(str, value.shape))
    return f"<{shape} {value.dtype}>"


class _Results(_types.SimpleNamespace):
    """Several results by their names, printed in one line: arrays by their shapes."""

    def __repr__(self):
        fields = (f"{name}={_value_text(value)}" for name, value in vars(self).items())
        return f"namespace({', '.join(fields)})"


# Notebooks and other modules.


def _by_file(name, write, read):
    with _tempfile.TemporaryDirectory() as folder:
        write(f"{folder}/{name}")
        return read(f"{folder}/{name}")


def _show_cloud(self):
    png = _base64.b64encode(self.preview()).decode()
    return (f'<figure><img alt="depth" src="data:image/png;base64,{png}">'
            f"<figcaption>{_cloud_text(self)}</figcaption></figure>")


def _show_report(self):
    page = _by_file("report.html", self.write, lambda path: _pathlib.Path(path).read_bytes())
    return (f'<iframe srcdoc="{_html.escape(page.decode())}" '
            'style="width: 100%; height: 40em; border: 0"></iframe>')


def _to_open3d(self):
    """The points as an open3d.geometry.PointCloud: mm, colours (sRGB from 0 to 1), normals.

    Returns:
        Any: open3d.geometry.PointCloud.

    Raises:
        ImportError: if Open3D is not installed.

    Example:
        >>> cloud.to_open3d()  # doctest: +SKIP
    """
    import open3d
    return _by_file("cloud.ply", lambda path: self.write(path, normals=True),
                    open3d.io.read_point_cloud)


def _to_trimesh(self, *, largest_step=8.0):
    """The surface as a trimesh.Trimesh: mm, grey vertex colours.

    Args:
        largest_step (float): in depth along a triangle, in distances between its rays.

    Returns:
        Any: trimesh.Trimesh.

    Raises:
        ImportError: if trimesh is not installed.

    Example:
        >>> cloud.to_trimesh()  # doctest: +SKIP
    """
    import trimesh
    return _by_file("mesh.ply", lambda path: self.write_mesh(path, largest_step=largest_step),
                    lambda path: trimesh.load(path, process=False))


Cloud._repr_html_, CalibrationReport._repr_html_ = _show_cloud, _show_report  # noqa: F405
Cloud.to_open3d, Cloud.to_trimesh = _to_open3d, _to_trimesh  # noqa: F405


# Iteration, and live reconstruction as a context.


def _undamaged_frames(self):
    for n in range(len(self)):
        frame = self[n]
        if frame is not None:
            yield frame


_running = _weakref.WeakSet()


def _start_live(self):
    """Starts it.

    Returns:
        Live: itself.

    Example:
        >>> live = slipstream.Live("virtual", sequence, camera=(64, 48)).start()
    """
    self._start()
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


Recording.__iter__ = _undamaged_frames  # noqa: F405
Live.start, Live.__enter__, Live.__exit__ = _start_live, _start_live, _end_live  # noqa: F405
Live.__iter__ = lambda self: self  # noqa: F405
