"""Writes the stub of the built module beside it: /usr/bin/python3 stub.py FOLDER/slipstream

Names, arguments, defaults and most types come from the module: from the signatures that pybind11
writes, and from the keywords that its functions describe themselves. The rest is listed here."""

import contextlib
import pathlib
import re
import sys

HEADER = '''\
# Made by python/stub.py when the module was built.
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
_Scans = Iterable[Union[Scan, _Path]]

class Error(ValueError): ...
class WorldError(OSError): ...
'''

# What functions return as a types.SimpleNamespace, by the function's name.
RESULTS = {
    "design": "strategy: Strategy; success: float; coordinate_sigma: float",
    "simulate": "scan: Scan; depth: _Double; coordinate: _Double; reflectivity: _Double",
    "find_gamma": "gamma: float; standard_error: float; pixels: int; refusal: str",
    "calibrate_gamma": "response: Response; gamma: float; standard_error: float; steps: int; "
                       "misfit: float",
    "measurements": "equation: str; method: str; variance: float; standard_error: float; "
                    "reason: str",
    "calibrate_noise": "variance: float; gain: float; measurements: list[_Measurements]",
    "calibrate_ambient": "mode: float; median: float; mean: float; variance: float; pixels: int",
    "calibrate_geometry": "scanner: Scanner; poses: list[str]; unused: dict[str, str]; "
                          "rms: dict[str, float]; findings: list[Finding]; text: str",
    "frame": "pixels: NDArray[Any]; bits: int; sequence: int; pattern_index: Union[int, None]; "
             "device_time: float",
    "unwrap_in_space": "phase: _Float; region: NDArray[Any]",
}
RETURNS = {
    "design": "list[_Design]", "Frames.__getitem__": "NDArray[Any]",
    "Recording.__getitem__": "Union[_Frame, None]", "Cloud.validity": "NDArray[numpy.uint8]",
    "Cloud.normals": "_Float", "Cloud.counts": "dict[str, int]", "load_map": "_Double",
    "Maps.fringe_order_doubt": "Union[_Float, None]", "Maps.coordinate": "Union[_Float, None]",
    "Maps.motion": "Union[_Float, None]", "phases": "tuple[_Double, _Double, _Double]",
    "Strategy.settings": "dict[str, str]", "Finding.evidence": "dict[str, float]",
    "Scan.scanner": "Union[Scanner, None]", "strategy_settings": "list[tuple[str, str, str]]",
}
ARGUMENTS = {
    "frames": "_Frames", "scans": "_Scans", "strategy": "Union[Strategy, str]",
    "axis": 'Literal["x", "y", "both"]', "first_axis": 'Literal["x", "y"]',
    "indexing": 'Literal["told", "counted", "marker"]',
    "board": 'Literal["chessboard", "circles", "charuco"]',
    "on_cloud": "Union[Callable[[Cloud], object], None]",
    "projector": "Union[_Size, None]",
}
PYTHON = {  # what __init__.py adds
    "Frames": ["def __iter__(self) -> Iterator[NDArray[Any]]: ..."],
    "Recording": ["def __iter__(self) -> Iterator[_Frame]: ..."],
    "Live": ["def start(self) -> Live: ...", "def __enter__(self) -> Live: ...",
             "def __exit__(self, *args: object) -> None: ...", "def __iter__(self) -> Live: ..."],
    "": ["def threads(most: int) -> AbstractContextManager[None]: ..."],
}


def typed(text, given):
    """The type of an argument or a return value, from pybind11's name to type checkers'."""
    text = re.sub(r"slipstream(\._slipstream)?(\.|::)", "", text)
    text = re.sub(r"numpy\.ndarray(\[numpy\.\w+(\[[^]]*\])?\])?",
                  lambda array: "ArrayLike" if not given else
                  "_Double" if "float64" in array[0] else "NDArray[Any]", text)
    for pattern, name in (
            (r"List\[(\w+)\[\d+\]\]", r"List[\1]"), (r"\bList\[", "list[" if given else "_List["),
            (r"os\.PathLike", "PathLike[str]" if given else "_Path"), (r"Tuple\[", "tuple["),
            (r"tuple\[int, int\]", "_Size"), (r"^dict$", "dict[str, Any]"), (r"^object$", "Any"),
            (r"Optional\[(.*)\]", r"Union[\1, None]")):
        text = re.sub(pattern, name, text)
    return text


def parts(text):
    """Split at the commas outside brackets."""
    part = r"(?:[^,\[\](]|\[(?:[^\[\]]|\[[^\]]*\])*\]|\([^)]*\))+"
    return [found.strip() for found in re.findall(part, text)]


def argument(name, kind, default):
    kind = kind != "int" and ARGUMENTS.get(name) or typed(kind, given=False)
    if default is None:
        return f"{name}: {kind}"
    if default == "None" and "None" not in kind:
        kind = f"Union[{kind}, None]"
    simple = re.fullmatch(r"None|True|False|-?[\d.]+(e-?\d+)?|'[^']*'", default)
    return f"{name}: {kind} = {default if simple else '...'}"


def described(call):
    """The keywords of a call, which raises TypeError after describing them."""
    keywords = []
    with contextlib.suppress(TypeError):
        call(keywords)
    assert keywords
    told = [argument(name, re.search(r"arg0: (.*)\) -> ", doc)[1],
                     None if default is ... else repr(default))
            for name, doc, default in keywords]
    return sorted(told, key=lambda one: " = " in one)


def function(owner, name, doc, keywords):
    """`def name(...) -> ...: ...` from pybind11's first line."""
    signature, result = re.match(r"\w+\((.*)\) -> (.*)", doc.splitlines()[0]).groups()
    place = f"{owner}.{name}" if owner else name
    arguments = []
    for part in parts(signature):
        found = re.fullmatch(r"(\w+): (.*?)(?: = (.*))?", part)
        if part == "**kwargs":
            named = {one.split(":")[0] for one in arguments}
            more = [one for one in keywords.get(place, []) if one.split(":")[0] not in named]
            star = [] if "*" in named else ["*"]
            arguments += star + more if more else ["**settings: _Setting"]
        elif found is None:
            arguments.append(part)
        elif found[1] == "self":
            arguments.append("self")
        else:
            arguments.append(argument(found[1].replace("arg0", "n"), *found.groups()[1:]))
    if name == "__eq__":
        arguments = ["self", "other: object"]
    told = RETURNS.get(place) or (f"_{name.title().replace('_', '')}" if name in RESULTS
                                  else typed(result, given=True))
    return f"def {name}({', '.join(arguments)}) -> {told}: ..."


def members(owner, bound, keywords):
    for name, member in vars(bound).items():
        doc = getattr(member, "__doc__", None) or ""
        if isinstance(member, property):
            got = re.search(r"-> (.*)", member.fget.__doc__)[1]
            kind = RETURNS.get(f"{owner}.{name}") or (
                "_Float" if got == "object" else typed(got, given=True))
            yield "@property"
            yield f"def {name}(self) -> {kind}: ..."
            if member.fset:
                setter = re.search(r", arg\d: (.*)\) -> ", member.fset.__doc__)
                taken = typed(setter[1], given=False)
                yield f"@{name}.setter"
                yield f"def {name}(self, {name}: {taken}) -> None: ..."
        elif re.match(rf"{name}\(", doc):
            yield function(owner, name, doc, keywords)
    yield from PYTHON.get(owner, [])


def stub(slipstream):
    strategy, scanner = slipstream.Strategy("pmp"), slipstream.example_scanner()
    sequence = slipstream.Sequence(strategy)
    settings = described(lambda told: slipstream.Engine(scanner, sequence, _describe=told))
    first_of_cleaning = [one.split(":")[0] for one in settings].index("largest_sigma")
    keywords = {
        "Sequence.__init__": described(lambda told: slipstream.Sequence(strategy, _describe=told)),
        "Scanner.__init__": described(lambda told: slipstream.Scanner(_describe=told)),
        "Cloud.cleaned": settings[first_of_cleaning:],
        "Engine.__init__": settings, "reconstruct": settings, "decode": settings,
        "Live.__init__": described(lambda told: slipstream.Live("virtual", _describe=told)),
        "design": described(lambda told: slipstream.design(_describe=told)),
        "simulate": described(lambda told: slipstream.simulate(sequence, _describe=told)),
        "calibrate_geometry": described(
            lambda told: slipstream.calibrate_geometry("", _describe=told)),
    }
    yield HEADER
    yield "class Validity(IntEnum):"
    yield from (f"    {one.name} = {one.value}" for one in slipstream.Validity)
    for name, fields in RESULTS.items():
        yield f"\nclass _{name.title().replace('_', '')}(SimpleNamespace):"
        yield from (f"    {field}" for field in fields.split("; "))
    functions = []
    for name, bound in vars(slipstream._slipstream).items():
        if name.startswith("_") or name in ("Error", "WorldError"):
            continue
        if isinstance(bound, type):
            yield f"\nclass {name}:"
            yield from (f"    {line}" for line in members(name, bound, keywords))
        else:
            functions.append(function("", name, bound.__doc__, keywords))
    yield ""
    yield from functions + PYTHON[""]


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1]).resolve()
    sys.path.insert(0, str(folder.parent))
    import slipstream as built

    (folder / "__init__.pyi").write_text("\n".join(stub(built)) + "\n")
