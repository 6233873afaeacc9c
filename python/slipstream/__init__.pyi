from collections.abc import Callable, Iterable, Iterator, Sequence as _List
from contextlib import AbstractContextManager
from enum import IntEnum
from os import PathLike
from types import SimpleNamespace
from typing import Any, Literal, Union

import numpy
from numpy.typing import ArrayLike, NDArray

__version__: str

_Path = Union[str, PathLike[str]]
_Size = tuple[int, int]
_Float = NDArray[numpy.float32]
_Double = NDArray[numpy.float64]
_Setting = Union[bool, int, float, str, _List[float], _List[int], None]
_Frames = Union[Frames, NDArray[Any], _List[NDArray[Any]]]
_Box = tuple[tuple[float, float, float], tuple[float, float, float]]

class Error(ValueError): ...
class WorldError(OSError): ...

class Validity(IntEnum):
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

class Strategy:
    def __init__(self, name: str, **settings: _Setting) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def settings(self) -> dict[str, str]: ...
    @property
    def label(self) -> str: ...
    @property
    def frames(self) -> int: ...
    @property
    def has_coordinate(self) -> bool: ...
    def __eq__(self, other: object) -> bool: ...

class Sequence:
    def __init__(
        self,
        strategy: Union[Strategy, str],
        axis: Literal["x", "y", "both"] = "x",
        *,
        projector: Union[_Size, None] = None,
        alpha_p: float = 255.0,
        beta_p: float = 0.0,
        marker: bool = False,
        exposures: _List[float] = ...,
        binary: bool = False,
        motion: int = 0,
    ) -> None: ...
    @property
    def strategy(self) -> Strategy: ...
    @property
    def axis(self) -> str: ...
    @property
    def projector(self) -> _Size: ...
    @property
    def alpha_p(self) -> float: ...
    @property
    def beta_p(self) -> float: ...
    @property
    def marker(self) -> bool: ...
    @property
    def exposures(self) -> list[float]: ...
    @property
    def binary(self) -> bool: ...
    @property
    def motion(self) -> int: ...
    @property
    def frames(self) -> int: ...
    def patterns(self, bits: int = 8) -> NDArray[Any]: ...
    def write_patterns(self, folder: _Path, bits: int = 8) -> list[PathLike[str]]: ...
    def __eq__(self, other: object) -> bool: ...

class _StrategyDesign(SimpleNamespace):
    strategy: Strategy
    success: float
    coordinate_sigma: float

class Response:
    def __init__(self, gamma: float) -> None: ...
    @property
    def gamma(self) -> float: ...
    @property
    def standard_error(self) -> float: ...
    def corrected(self, phases: ArrayLike, steps: int) -> Any: ...
    def __eq__(self, other: object) -> bool: ...

class Scanner:
    def __init__(
        self,
        *,
        camera_matrix: ArrayLike,
        camera_size: _Size,
        projector_matrix: ArrayLike,
        projector_size: _Size,
        rotation: ArrayLike,
        translation: ArrayLike,
        camera_distortion: _List[float] = ...,
        projector_distortion: _List[float] = ...,
    ) -> None: ...
    ambient: Union[float, None]
    noise_variance: Union[float, None]
    noise_gain: float
    response: Union[Response, None]
    measured: str
    @property
    def camera_matrix(self) -> _Double: ...
    @property
    def camera_distortion(self) -> list[float]: ...
    @property
    def camera_size(self) -> _Size: ...
    @property
    def projector_matrix(self) -> _Double: ...
    @property
    def projector_distortion(self) -> list[float]: ...
    @property
    def projector_size(self) -> _Size: ...
    @property
    def rotation(self) -> _Double: ...
    @property
    def translation(self) -> _Double: ...
    def write(self, path: _Path) -> None: ...
    def __eq__(self, other: object) -> bool: ...

class Frames:
    def __len__(self) -> int: ...
    def __getitem__(self, n: int) -> NDArray[Any]: ...
    def __iter__(self) -> Iterator[NDArray[Any]]: ...
    @property
    def bits(self) -> int: ...
    @property
    def size(self) -> _Size: ...

class Scan:
    def __init__(
        self,
        frames: _Frames,
        sequence: Sequence,
        scanner: Union[Scanner, None] = None,
        *,
        bits: Union[int, None] = None,
    ) -> None: ...
    @property
    def scanner(self) -> Union[Scanner, None]: ...
    @scanner.setter
    def scanner(self, scanner: Scanner) -> None: ...
    @property
    def frames(self) -> Frames: ...
    @property
    def sequence(self) -> Sequence: ...
    @property
    def exposures(self) -> list[float]: ...
    @property
    def other_axis(self) -> list[Scan]: ...
    @property
    def further_cameras(self) -> list[Scan]: ...
    @property
    def warnings(self) -> list[str]: ...
    def save(self, path: _Path) -> None: ...

class Finding:
    @property
    def wrong(self) -> bool: ...
    @property
    def what(self) -> str: ...
    @property
    def likely(self) -> str: ...
    @property
    def advice(self) -> str: ...
    @property
    def evidence(self) -> dict[str, float]: ...

class Cloud:
    def __init__(self, points: ArrayLike, intensity: Union[ArrayLike, None] = None) -> None: ...
    @property
    def x(self) -> _Float: ...
    @property
    def y(self) -> _Float: ...
    @property
    def z(self) -> _Float: ...
    @property
    def intensity(self) -> _Float: ...
    @property
    def validity(self) -> NDArray[numpy.uint8]: ...
    @property
    def points(self) -> _Float: ...
    @property
    def size(self) -> _Size: ...
    @property
    def counts(self) -> dict[str, int]: ...
    @property
    def remarks(self) -> list[str]: ...
    def __len__(self) -> int: ...
    def normals(self) -> _Float: ...
    def cleaned(
        self,
        *,
        largest_sigma: Union[float, None] = None,
        drop_mixed: bool = True,
        drop_outliers: bool = True,
        smallest_component: int = 200,
        box: Union[_Box, None] = None,
        outline: _List[tuple[float, float]] = (),
        widest_gap: int = 0,
        smoothing: int = 0,
    ) -> Cloud: ...
    def write(
        self, path: _Path, uncertainty: Union[Uncertainty, None] = None, *, normals: bool = False
    ) -> None: ...
    def write_mesh(self, path: _Path, *, largest_step: float = 8.0) -> None: ...
    def write_preview(self, path: _Path) -> None: ...

class Maps:
    @property
    def mean(self) -> _Float: ...
    @property
    def modulation(self) -> _Float: ...
    @property
    def wrapped_phase(self) -> _Float: ...
    @property
    def fringe_order_doubt(self) -> Union[_Float, None]: ...
    @property
    def coordinate(self) -> Union[_Float, None]: ...
    @property
    def motion(self) -> Union[_Float, None]: ...

class Uncertainty:
    @property
    def coordinate(self) -> _Float: ...
    @property
    def x(self) -> _Float: ...
    @property
    def y(self) -> _Float: ...
    @property
    def z(self) -> _Float: ...

# What Engine, reconstruct, decode and Live take beside their own: the fields of ReconstructSettings,
# FringeOrderConsensus and CleanSettings: backend, minimum_modulation, drop_saturated,
# largest_doubt, fewest_neighbours, fewest_if_doubtful, cue_rule, least_voting_share, field_margin,
# nearest, farthest, raw, and those of Cloud.cleaned. Another name is a TypeError.
class Engine:
    def __init__(self, scanner: Scanner, sequence: Sequence, **settings: Any) -> None: ...
    def cloud(self, frames: _Frames, *, bits: Union[int, None] = None) -> Cloud: ...
    def maps(self, frames: _Frames, *, bits: Union[int, None] = None) -> Maps: ...
    def cloud_and_maps(
        self, frames: _Frames, *, bits: Union[int, None] = None
    ) -> tuple[Cloud, Maps]: ...
    def uncertainty(
        self, cloud: Cloud, maps: Maps, frames: _Frames, *, bits: Union[int, None] = None
    ) -> Uncertainty: ...
    def backend_for(self, frames: _Frames, *, bits: Union[int, None] = None) -> str: ...
    @property
    def scanner(self) -> Scanner: ...
    @property
    def sequence(self) -> Sequence: ...

class _VirtualScan(SimpleNamespace):
    scan: Scan
    depth: _Double
    coordinate: _Double
    reflectivity: _Double

class _BlindGamma(SimpleNamespace):
    gamma: float
    standard_error: float
    pixels: int
    refusal: str

class _GammaCalibration(SimpleNamespace):
    response: Response
    gamma: float
    standard_error: float
    steps: int
    misfit: float

class _NoiseMeasurement(SimpleNamespace):
    equation: str
    method: str
    variance: float
    standard_error: float
    reason: str

class _NoiseCalibration(SimpleNamespace):
    variance: float
    gain: float
    measurements: list[_NoiseMeasurement]

class _AmbientEstimate(SimpleNamespace):
    mode: float
    median: float
    mean: float
    variance: float
    pixels: int

class _GeometryCalibration(SimpleNamespace):
    scanner: Scanner
    poses: list[str]
    unused: dict[str, str]
    rms: dict[str, float]
    findings: list[Finding]
    text: str

class _Frame(SimpleNamespace):
    pixels: NDArray[Any]
    bits: int
    sequence: int
    pattern_index: Union[int, None]
    device_time: float

class Recording:
    def __init__(self, path: _Path) -> None: ...
    def __len__(self) -> int: ...
    def __getitem__(self, n: int) -> Union[_Frame, None]: ...
    def __iter__(self) -> Iterator[_Frame]: ...
    @property
    def sequence(self) -> Union[Sequence, None]: ...
    @property
    def scanner(self) -> Union[Scanner, None]: ...
    @property
    def frame_rate(self) -> float: ...
    @property
    def finished(self) -> bool: ...
    @property
    def in_colour(self) -> bool: ...

class Live:
    def __init__(
        self,
        source: str,
        sequence: Union[Sequence, None] = None,
        scanner: Union[Scanner, None] = None,
        on_cloud: Union[Callable[[Cloud], object], None] = None,
        *,
        rate: Union[float, None] = None,
        loop: bool = False,
        indexing: Literal["told", "counted", "marker"] = ...,
        gamma: str = "scanner",
        most_frames: Union[int, None] = None,
        **settings: Any,
    ) -> None: ...
    def start(self) -> Live: ...
    def stop(self) -> None: ...
    def __enter__(self) -> Live: ...
    def __exit__(self, *args: object) -> None: ...
    def __iter__(self) -> Live: ...
    def __next__(self) -> Cloud: ...
    @property
    def running(self) -> bool: ...
    @property
    def statistics(self) -> dict[str, Any]: ...
    @property
    def findings(self) -> list[Finding]: ...

def threads(most: int) -> AbstractContextManager[None]: ...
def strategy_names() -> list[str]: ...
def strategy_settings() -> list[tuple[str, str, str]]: ...
def design(
    *,
    frames: int = 10,
    coordinate_sigma: Union[float, None] = None,
    alpha: float = 0.5,
    noise_variance: float = 1.6,
    success: float = 0.999,
    most_periods: int = 64,
) -> list[_StrategyDesign]: ...
def load_scanner(path: _Path) -> Scanner: ...
def example_scanner(camera: _Size = ...) -> Scanner: ...
def load_scan(
    path: _Path,
    sequence: Union[Sequence, None] = None,
    scanner: Union[Scanner, _Path, None] = None,
    *,
    bits: Union[int, None] = None,
    order: str = "",
    window: Union[int, None] = None,
) -> Scan: ...
def check(
    scan: Scan, *, minimum_modulation: float = 15.0, moving: bool = False, gamma: str = "scanner"
) -> list[Finding]: ...
def load_cloud(path: _Path) -> Cloud: ...
def write_map(path: _Path, map: ArrayLike) -> None: ...
def load_map(path: _Path) -> _Double: ...
def unwrap_in_space(
    phase: ArrayLike, quality: Union[ArrayLike, None] = None, method: str = "flow"
) -> SimpleNamespace: ...
def reconstruct(
    scan: Scan, *, gamma: str = "scanner", anyway: bool = False, **settings: Any
) -> Cloud: ...
def decode(
    frames: _Frames, sequence: Sequence, *, bits: Union[int, None] = None, **settings: Any
) -> Maps: ...
def simulate(
    sequence: Sequence,
    path: Union[_Path, None] = None,
    *,
    scene: str = "statue",
    mesh: Union[_Path, None] = None,
    world: str = "bench",
    scanner: Union[Scanner, None] = None,
    camera: _Size = ...,
    ambient: Union[float, None] = None,
    noise_variance: Union[float, None] = None,
    reflectivity: Union[float, None] = None,
    response: Union[Response, None] = None,
    bits: Union[int, None] = 8,
    seed: int = 1,
    rays: int = ...,
    step: tuple[float, float, float] = ...,
    turn: float = 0.0,
) -> _VirtualScan: ...
def scene_names() -> list[str]: ...
def world_names() -> list[str]: ...
def find_gamma(
    frames: _Frames, steps: int, first: int = 0, *, bits: Union[int, None] = None
) -> _BlindGamma: ...
def calibrate_gamma(
    scans: Iterable[Union[Scan, _Path]], *, minimum_modulation: float = 0.0
) -> _GammaCalibration: ...
def calibrate_noise(scans: Iterable[Union[Scan, _Path]]) -> _NoiseCalibration: ...
def calibrate_ambient(
    scans: Iterable[Union[Scan, _Path]],
    *,
    least_alpha: float = 0.5,
    response: Union[Response, None] = None,
) -> _AmbientEstimate: ...
def calibrate_geometry(
    folder: _Path,
    report: Union[_Path, None] = None,
    *,
    board: Literal["chessboard", "circles", "charuco"] = "chessboard",
    columns: int = 13,
    rows: int = 9,
    spacing: float = 10.0,
    row_spacing: Union[float, None] = None,
    circle_diameter: float = 0.8,
    marker_side: float = 0.75,
    marker_bits: int = 4,
    sequence: Union[Sequence, None] = None,
    first_axis: Literal["x", "y"] = "x",
    excluded: _List[str] = (),
    minimum_modulation: float = 5.0,
    neighbourhood: float = 0.7,
    response: Union[Response, None] = None,
    camera_coefficients: Union[int, None] = None,
    projector_coefficients: Union[int, None] = None,
    print_deviation: Union[float, None] = 0.01,
) -> _GeometryCalibration: ...
def phases(
    frames: _Frames, steps: int, first: int = 0, *, bits: Union[int, None] = None
) -> tuple[_Double, _Double, _Double]: ...
def unwrap(wrapped_phase: ArrayLike, frequency: ArrayLike, coarse_coordinate: ArrayLike) -> Any: ...
def phase_variance(
    steps: ArrayLike, alpha: ArrayLike, alpha_p: ArrayLike, noise_variance: ArrayLike
) -> Any: ...
def coordinate_variance(phase_variance: ArrayLike, frequency: ArrayLike) -> Any: ...
