"""slipstream: 3-D point clouds from pictures of an object under projected stripes."""

import atexit as _atexit
import base64 as _base64
import contextlib as _contextlib
import enum as _enum
import html as _html
import pathlib as _pathlib
import tempfile as _tempfile
import weakref as _weakref

import numpy as _numpy

from . import _slipstream
from ._docstrings import DOCSTRINGS as _DOCSTRINGS
from ._slipstream import *  # noqa: F403
from ._slipstream import __version__  # noqa: F401

Validity = _enum.IntEnum(
    "Validity",
    "VALID TOO_DARK SATURATED DOUBTFUL_ORDER NO_POINT OUTSIDE_FIELD OUT_OF_RANGE LOW_TRUST MIXED "
    "OUTLIER SMALL_COMPONENT OUTSIDE_REGION MOVED", start=0, module=__name__)


_SAYS = {
    "Strategy": lambda of: of.label,
    "Sequence": lambda of: f"{of.strategy.label} along {of.axis}, {of.frames} frames",
    "Response": lambda of: f"gamma {of.gamma:.4g} +- {of.standard_error:.2g}",
    "Scanner": lambda of: "camera {0[0]}x{0[1]}, projector {1[0]}x{1[1]}, {2:.4g} mm apart".format(
        of.camera_size, of.projector_size, _numpy.linalg.norm(of.translation)),
    "Frames": lambda of: "{1} of {0[0]}x{0[1]}, {2} bits".format(of.size, len(of), of.bits),
    "Scan": lambda of: f"{of.frames!r}, {of.sequence!r}",
    "Finding": str,
    "Cloud": lambda of: "{0[0]}x{0[1]}: {1} points of {2} pixels".format(
        of.size, len(of), of.z.size) + (
        f", {_numpy.nanmin(of.z):.1f} to {_numpy.nanmax(of.z):.1f} mm" if of else ""),
    "Maps": lambda of: "{0[1]}x{0[0]}: median modulation {1:.3g}".format(
        of.mean.shape, _numpy.nanquantile(of.modulation, 0.5)),
    "Uncertainty": lambda of: "{0[1]}x{0[0]}: median {1:.3g} mm of depth".format(
        of.z.shape, _numpy.median(of.z[of.z > 0]) if (of.z > 0).any() else 0),
    "Engine": lambda of: f"{of.scanner!r}, {of.sequence!r}",
    "Recording": lambda of: f"{len(of)} frames, {of.sequence!r}",
    "CalibrationReport": lambda of: "{1} poses, RMS camera {0[camera]:.3g}, projector "
    "{0[projector]:.3g}, stereo {0[stereo]:.3g} pixels".format(of.rms, len(of.poses)),
    "Live": lambda of: "{0[clouds]} clouds, {1}".format(
        of.statistics, "running" if of.running else "stopped"),
}


def _say(self):
    name = type(self).__name__
    return f"<slipstream.{name} {_SAYS[name](self)}>"


def _by_file(name, write, read):
    with _tempfile.TemporaryDirectory() as folder:
        write(f"{folder}/{name}")
        return read(f"{folder}/{name}")


def _show_cloud(self):
    png = _base64.b64encode(self.preview()).decode()
    return (f'<figure><img alt="depth" src="data:image/png;base64,{png}">'
            f"<figcaption>{_SAYS['Cloud'](self)}</figcaption></figure>")


def _show_report(self):
    page = _by_file("report.html", self.write, lambda path: _pathlib.Path(path).read_bytes())
    return (f'<iframe srcdoc="{_html.escape(page.decode())}" '
            'style="width: 100%; height: 40em; border: 0"></iframe>')


def _to_open3d(self):
    import open3d
    return _by_file("cloud.ply", lambda path: self.write(path, normals=True),
                    open3d.io.read_point_cloud)


def _to_trimesh(self, *, largest_step=8.0):
    import trimesh
    return _by_file("mesh.ply", lambda path: self.write_mesh(path, largest_step=largest_step),
                    lambda path: trimesh.load(path, process=False))


@_contextlib.contextmanager
def threads(most):
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
Cloud._repr_html_, CalibrationReport._repr_html_ = _show_cloud, _show_report  # noqa: F405
Cloud.to_open3d, Cloud.to_trimesh = _to_open3d, _to_trimesh  # noqa: F405

__doc__ = _DOCSTRINGS.pop("", (None, __doc__))[1]
for _name, (_signature, _text) in _DOCSTRINGS.items():
    _owner, _, _name = _name.rpartition(".")
    _bound = vars(globals()[_owner])[_name] if _owner else globals()[_name]
    if hasattr(_bound, "fget") or not _signature or hasattr(_bound, "__code__"):
        _bound.__doc__ = _text
    else:
        _slipstream._document(getattr(_bound, "__func__", _bound), f"{_signature}\n--\n\n{_text}")
