"""Writes the stub of the built module: /usr/bin/python3 stub.py FOLDER/slipstream

pybind11 begins a docstring with the signature, which has the names and defaults of the arguments.
The docstring has their types: `name (TYPE): text` under Args, `TYPE: text` under Returns and for an
attribute. Keywords that a function takes as **kwargs also have their default there:
`name (TYPE, default VALUE): text`. Fields of a SimpleNamespace are entries below it."""

import ast
import enum
import inspect
import pathlib
import re
import sys
import textwrap

HEADER = '''\
# Made by python/stub.py when the module was built.
import typing
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from enum import IntEnum
from os import PathLike
from types import SimpleNamespace
from typing import Any, Literal

from numpy import float32, float64, uint8
from numpy.typing import ArrayLike, NDArray

__version__: str

class Error(ValueError):
    findings: list[Finding]

class WorldError(OSError): ...

class _Frame(SimpleNamespace):
    pixels: NDArray[Any]
    bits: int
    sequence: int
    device_time: float
    pattern_index: int | None
'''
SPECIAL_METHODS = {
    "Frames": ("def __getitem__(self, n: int) -> NDArray[Any]: ...",
               "def __iter__(self) -> Iterator[NDArray[Any]]: ..."),
    "Recording": ("def __getitem__(self, n: int) -> _Frame | None: ...",
                  "def __iter__(self) -> Iterator[_Frame]: ..."),
    "Live": ("def __next__(self) -> Cloud: ...",
             "def __iter__(self) -> Live: ...",
             "def __enter__(self) -> Live: ...",
             "def __exit__(self, *args: object) -> None: ..."),
}
COMMON_METHODS = {"__len__": "def __len__(self) -> int: ...",
                  "__eq__": "def __eq__(self, other: object) -> bool: ..."}


def in_full(kind):
    """A type of a docstring with the parameters that type checkers require."""
    kind = re.sub(r"\bNDArray\b(?!\[)", "NDArray[Any]", kind)
    return re.sub(r"\bPathLike\b", "PathLike[str]", kind)


def parsed(expression):
    return ast.parse(expression, mode="eval").body


def section(doc, title):
    """The lines below a title of a docstring, without their indentation."""
    found = re.search(rf"^{title}:\n((?:    .*\n|\n)+)", doc + "\n", re.MULTILINE)
    return textwrap.dedent(found[1]).strip() if found else ""


def entries(text):
    """Type, default and the lines below each `name (TYPE, default VALUE): text`."""
    found = {}
    for block in re.split(r"\n(?=\S)", text):
        first, _, below = block.partition("\n")
        if entry := re.match(r"(\*{0,2}\w+) \((.*?)(?:, default (.*?))?\):(?: |$)", first):
            name, kind, default = entry.groups()
            found[name] = in_full(kind), default, textwrap.dedent(below)
    return found


def with_docstring(line, doc):
    return [line, *textwrap.indent(f'"""{doc}"""', "    ").splitlines()]


class Stub:
    def __init__(self):
        self.results = []  # classes of results with fields
        self.lines = []

    def result(self, name, kind, below):
        """The type of a result; fields below it become a class."""
        fields = entries(below)
        if "SimpleNamespace" not in kind or not fields:
            return kind

        title = "_" + name.title().replace("_", "")
        lines = [f"{field}: {self.result(field, one, more)}"
                 for field, (one, _, more) in fields.items()]
        self.results += ["", f"class {title}(SimpleNamespace):", *(f"    {line}" for line in lines)]
        return kind.replace("SimpleNamespace", title)

    def returned(self, name, doc):
        first, _, below = section(doc, "Returns").partition("\n")
        kind = in_full(first.partition(":")[0]) or "None"
        return self.result(name, kind, textwrap.dedent(below))

    def head(self, place, signature, doc):
        """`def name(...) -> ...:` from pybind11's signature and the types in the docstring."""
        function = ast.parse(f"def {signature}: ...").body[0]
        arguments = function.args
        told = entries(section(doc, "Args"))

        for one in arguments.args + arguments.kwonlyargs:
            one.annotation = None
            if one.arg != "self":
                if one.arg not in told:
                    sys.exit(f"{place}: Args of its docstring lack `{one.arg} (TYPE): text`")
                one.annotation = parsed(told.pop(one.arg)[0])

        if "**settings" in told:
            arguments.kwarg = ast.arg("settings", parsed(told["**settings"][0]))
        elif arguments.kwarg:
            arguments.kwarg = None
            for name, (kind, default, _) in told.items():
                arguments.kwonlyargs.append(ast.arg(name, parsed(kind)))
                arguments.kw_defaults.append(default and parsed(default))

        kind = self.returned(function.name, doc)
        return f"def {function.name}({ast.unparse(arguments)}) -> {kind}:"

    def function(self, place, member):
        name, doc = place.rpartition(".")[2], inspect.cleandoc(member.__doc__)
        if doc.startswith(f"{name}("):  # written by pybind11
            signature, _, doc = doc.partition("\n")
        else:
            signature = f"{name}{inspect.signature(member)}"
        lines = with_docstring(self.head(place, signature, doc.strip()), doc.strip())
        return ["@staticmethod", *lines] if isinstance(member, staticmethod) else lines

    def attribute(self, name, member):
        kind = in_full(member.__doc__.partition(":")[0])
        yield "@property"
        yield from with_docstring(f"def {name}(self) -> {kind}:", member.__doc__)
        if member.fset:
            yield from (f"@{name}.setter", f"def {name}(self, value: {kind}) -> None: ...")

    def members(self, owner, bound):
        for name, member in vars(bound).items():
            doc = getattr(member, "__doc__", None) or ""
            if isinstance(member, property):
                yield from self.attribute(name, member)
            elif name == "__init__" and doc.startswith("__init__("):
                yield self.head(owner, doc.partition("\n")[0], inspect.getdoc(bound)) + " ..."
            elif name in COMMON_METHODS:
                yield COMMON_METHODS[name]
            elif not name.startswith("_"):
                yield from self.function(f"{owner}.{name}", member)
        yield from SPECIAL_METHODS.get(owner, ())

    def add(self, name, bound):
        """Adds a function or a class."""
        if not isinstance(bound, type):
            self.lines += ["", *self.function(name, bound)]
            return

        if issubclass(bound, enum.Enum):
            title = f"class {name}(IntEnum):"
            members = (f"{one.name} = {one.value}" for one in bound)
        else:
            title = f"class {name}:"
            members = self.members(name, bound)
        self.lines += ["", *with_docstring(title, inspect.getdoc(bound))]
        self.lines += [f"    {line}" for line in members]


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1]).resolve()
    sys.path.insert(0, str(folder.parent))
    import slipstream

    stub = Stub()
    for name, bound in vars(slipstream).items():
        in_header = name in ("Error", "WorldError")
        if not (name.startswith("_") or in_header or inspect.ismodule(bound)):
            stub.add(name, bound)

    lines = [*HEADER.splitlines(), *stub.results, *stub.lines]
    (folder / "__init__.pyi").write_text("\n".join(line.rstrip() for line in lines) + "\n")
