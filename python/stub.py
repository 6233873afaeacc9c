"""Writes stub and docstrings of the built module: /usr/bin/python3 stub.py FOLDER/slipstream

Names, arguments, defaults and most types come from the module: from the signatures that pybind11
writes and the keywords that its functions describe. The texts are in docstrings.txt."""

import contextlib
import pathlib
import re
import sys
import textwrap
import types

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

class Error(ValueError):
    findings: _List[Finding]
class WorldError(OSError): ...
'''
PYTHON = {  # what __init__.py adds
    "Frames": ["__iter__(self) -> Iterator[NDArray[Any]]"],
    "Recording": ["__iter__(self) -> Iterator[_Frame]"],
    "Live": ["start(self) -> Live", "__enter__(self) -> Live", "__iter__(self) -> Live",
             "__exit__(self, *args: object) -> None"],
    "Cloud": ["to_open3d(self) -> Any", "to_trimesh(self, *, largest_step: float = 8.0) -> Any"],
    "": ["threads(most: int) -> AbstractContextManager[None]"],
}
WORDS = (  # for the stub's types in docstrings
    (r"Union\[(.*), None\]", r"\1 or None"), (r"Union\[(\w+), (\w+)\]", r"\1 or \2"),
    (r"Literal\[(.*)\]", r"{\1}"),
    ("_Frames", "Frames or array_like"), ("_Scans", "iterable of Scan or path"),
    ("_Float", "ndarray of float32"), ("_Double", "ndarray of float64"),
    ("_Path", "str or PathLike"), (r"NDArray\[(numpy\.)?(\w+)\]", r"ndarray of \2"),
    ("_Setting", "bool, int, float, str or sequence"), (r" of Any|\[Any\]", ""),
    ("ArrayLike", "array_like"), ("_Size", "(int, int)"), (r"_List\[", "sequence["),
    (r"\b_[A-Z]\w+", "SimpleNamespace"))


def typed(text, given):
    """The type of an argument or a return value, from pybind11's name to type checkers'."""
    text = re.sub(r"slipstream(\._slipstream)?(\.|::)", "", text)
    text = re.sub(r"numpy\.ndarray(\[numpy\.\w+(\[[^]]*\])?\])?",
                  lambda array: "ArrayLike" if not given else
                  "_Double" if "float64" in array[0] else "NDArray[Any]", text)
    for pattern, name in (
            (r"\blist\[", "List["), (r"Annotated\[(\S+), FixedSize\(\d+\)\]", r"\1"),
            (r"List\[(\w+)\[\d+\]\]", r"List[\1]"), (r"\bList\[", "list[" if given else "_List["),
            (r"os\.PathLike", "PathLike[str]" if given else "_Path"), (r"Tuple\[", "tuple["),
            (r"tuple\[int, int\]", "_Size"), (r"^dict$", "dict[str, Any]"),
            (r"^tuple$", "tuple[Any, ...]"), (r"^object$", "Any"),
            (r"Optional\[(.*)\]", r"Union[\1, None]")):
        text = re.sub(pattern, name, text)
    return text


def in_words(kind):
    for pattern, name in WORDS:
        kind = re.sub(pattern, name, kind)
    return kind


def parts(text):
    """Split at the commas outside brackets."""
    part = r"(?:[^,\[\](]|\[(?:[^\[\]]|\[[^\]]*\])*\]|\([^)]*\))+"
    return [found.strip() for found in re.findall(part, text)]


def described(call, *given):
    """Name, type, default and help of each keyword of a call, which raises TypeError."""
    keywords = []
    with contextlib.suppress(TypeError):
        call(*given, _describe=keywords)
    assert keywords
    told = [(name, re.search(r"arg0: (.*)\) -> ", doc)[1],
             "" if default is ... else repr(default), told)
            for name, doc, default, told in keywords]
    return sorted(told, key=lambda one: one[2] != "")


def with_docstring(line, text):
    return [line, *(f"    {one}" for one in f'"""{text}"""'.split("\n"))]


def sections_in(path):
    """The sections of docstrings.txt by name; entries and fields are (type or None, text)."""
    sections = {}
    text = re.sub(r"^#.*\n", "", path.read_text(), flags=re.MULTILINE)
    text = re.sub(r"^(\S.*?) \| ", r"\1\n  ", text, flags=re.MULTILINE)
    for line in re.sub(r"(?<=\S) (?=>>> )", "\n", text).splitlines():
        if line.lstrip().startswith((">>>", "...")):
            code, *output = line.strip().split(" -> ")
            section.example += [*code.replace("; ", "\n>>> ").split("\n"), *output]
        elif line.startswith("  "):
            for entry in line.strip().split(" | "):
                names, *told = re.fullmatch(r"([\w., ]+?)(?: \((.*?)\))?: (.*)", entry).groups()
                for name in names.split(", "):
                    (section.fields if name[0] == "." else section.entries)[name] = told
        else:
            name, summary = re.match(r"([\w.*]+):\s*(.*)", line).groups()
            section = types.SimpleNamespace(summary=summary, entries={}, fields={}, example=[])
            sections[name] = section
    return sections


class Stub:
    """Writes the lines of the stub, and collects signatures and docstrings by name."""

    def __init__(self, slipstream, sections):
        self.sections = sections
        self.results = {self.result_of(name): section.fields
                        for name, section in sections.items() if section.fields}
        sequence = slipstream.Sequence("pmp")
        engine = described(slipstream.Engine, slipstream.example_scanner(), sequence)
        first_of_cleaning = [one[0] for one in engine].index("largest_sigma")
        self.keywords = {
            "Sequence.__init__": described(slipstream.Sequence, "pmp"),
            "Scanner.__init__": described(slipstream.Scanner),
            "Cloud.cleaned": engine[first_of_cleaning:],
            "Engine.__init__": engine, "reconstruct": engine, "decode": engine,
            "Live.__init__": described(slipstream.Live, "virtual"),
            "design": described(slipstream.design),
            "simulate": described(slipstream.simulate, sequence),
            "calibrate_geometry": described(slipstream.calibrate_geometry, ""),
        }
        self.docs = {name: (None, self.docstring(section)) for name, section in (
            ("", "*"), *zip(*[("Error", "WorldError", "Validity")] * 2))}

    def entry(self, place, name):
        """Type and text of a name there; either may be empty."""
        return place in self.sections and self.sections[place].entries.get(name) or (None, "")

    def result_of(self, place):
        """The class of its types.SimpleNamespace, if it returns one."""
        named = re.search(r"\b_[A-Z]\w+", self.entry(place, "Returns")[0] or place)
        title = f"_{place.title().replace('_', '')}"
        return place in self.sections and self.sections[place].fields and (
            named[0] if named else title)

    def lines(self, slipstream):
        yield HEADER
        yield "class Validity(IntEnum):"
        yield from (f"    {one.name} = {one.value}" for one in slipstream.Validity)
        for name, fields in self.results.items():
            yield f"\nclass {name}(SimpleNamespace):"
            yield from (f"    {field[1:]}: {kind}" for field, (kind, _) in fields.items())
        functions = []
        for name, bound in vars(slipstream._slipstream).items():
            if isinstance(bound, type) and hasattr(slipstream, name) and name not in self.docs:
                self.docs[name] = None, self.docstring(name)
                members = list(self.members(name, bound))
                yield from with_docstring(f"\nclass {name}:", self.docs[name][1])
                yield from (f"    {line}" for line in members)
            elif not isinstance(bound, type) and not name.startswith("_"):
                functions += self.function("", name, bound.__doc__)
        yield from ("", *functions, *self.function("", "threads", PYTHON[""][0]))

    def members(self, owner, bound):
        for name, member in vars(bound).items():
            doc = getattr(member, "__doc__", None) or ""
            if isinstance(member, property):
                yield from self.attribute(owner, name, member)
            elif re.match(rf"{name}\(", doc) and not re.match("_[^_]", name):
                yield from self.function(owner, name, doc)
        for line in PYTHON.get(owner, []):
            yield from self.function(owner, line.split("(")[0], line)

    def attribute(self, owner, name, member):
        got = re.search(r"-> (.*)", member.fget.__doc__)[1]
        kind = self.entry(owner, name)[0] or (
            "_Float" if got == "object" else typed(got, given=True))
        told = self.entry(owner, name)[1] or self.entry("*", name)[1]
        text = f"{in_words(kind)}: {told}"
        self.docs[f"{owner}.{name}"] = None, text
        yield "@property"
        yield from with_docstring(f"def {name}(self) -> {kind}:", text)
        if member.fset:
            setter = re.search(r", arg\d: (.*)\) -> ", member.fset.__doc__)
            yield f"@{name}.setter"
            yield f"def {name}(self, {name}: {typed(setter[1], given=False)}) -> None: ..."

    def function(self, owner, name, doc):
        """`def name(...) -> ...` with its docstring, from pybind11's first line."""
        signature, result = re.match(r"\w+\((.*)\) -> (.*)", doc.splitlines()[0]).groups()
        place = f"{owner}.{name}" if owner else name
        section = owner if name == "__init__" else place
        arguments = []
        for part in parts(signature):
            one, _, kind = part.partition(": ")
            kind, _, default = kind.partition(" = ")
            if part == "**kwargs":
                named = {one[0] for one in arguments}
                more = [one for one in self.keywords.get(place, []) if one[0] not in named]
                star = [] if "*" in named else [("*", "", "", "")]
                arguments += star + more if more else [("**settings", "_Setting", "", "")]
            else:
                arguments.append((one.replace("arg0", "n"), one != "self" and kind, default, ""))
        if name == "__eq__":
            arguments[1:] = [("other", "object", "", "")]
        arguments = [(one, kind and (self.entry(section, one)[0] or self.entry("*", one)[0]
                      or typed(kind, given=False)),
                      default, told) for one, kind, default, told in arguments]
        result = (self.entry(place, "Returns")[0] or self.result_of(place)
                  or typed(result, given=True))
        hinted, bare = [], []
        for one, kind, default, _ in arguments:
            simple = re.fullmatch(r"None|True|False|-?[\d.]+(e-?\d+)?|'[^']*'", default)
            value = default if simple else "..."
            if default == "None" and "None" not in kind:
                kind = f"Union[{kind}, None]"
            hinted.append(one + (kind and f": {kind}" or "") + (default and f" = {value}"))
            bare.append(one + (default and f"={value}"))
        head = f"def {name}({', '.join(hinted)}) -> {result}:"
        if name.startswith("_") and name != "__init__":
            yield head + " ..."
            return
        text = self.docstring(section, arguments, result)
        self.docs[place] = f"{name}({', '.join(bare)})", text
        if name == "__init__":
            self.docs[owner] = None, text
            yield head + " ..."
        else:
            yield from with_docstring(head, text)

    def docstring(self, place, arguments=(), result="None"):
        section = self.sections[place]
        own = [one for one in arguments if one[1]]
        names = ["", *(name for name, kind, *_ in own if kind != "int")]
        names += ["settings"] * any(told for *_, told in own)
        raises = {}
        for key, (_, told) in {**self.sections["*"].entries, **section.entries}.items():
            kind, _, name = key.partition(" of ")
            if kind.endswith("Error") and name in names:
                raises.setdefault(kind, []).append(told)
        returned = [(in_words(result), self.entry(place, "Returns")[1])]
        fields = re.search(r"\b_[A-Z]\w+|$", result)[0]
        returned += [(f"    {name} : {in_words(kind)}", f"    {told}")
                     for name, (kind, told) in self.results.get(fields, {}).items()]
        parameters = [
            (f"{name} : {in_words(kind)}" + (default and f", default {default}"),
             self.entry(place, name.strip("*"))[1] or told or self.entry("*", name)[1])
            for name, kind, default, told in own]
        lines = [section.summary]
        for title, rows in (("Parameters", parameters),
                            ("Returns", returned if result != "None" else []),
                            ("Raises", [(kind, "; ".join(told)) for kind, told in raises.items()]),
                            ("Examples", [(line, "") for line in section.example])):
            if rows:
                lines += ["", title, "-" * len(title)]
            for name, told in rows:
                lines += [name, *textwrap.wrap(told, 88, initial_indent="    ",
                                               subsequent_indent="    ")]
        return "\n".join(lines)


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1]).resolve()
    sys.path.insert(0, str(folder.parent))
    sys.modules["slipstream._docstrings"] = types.SimpleNamespace(DOCSTRINGS={})
    import slipstream as built

    stub = Stub(built, sections_in(pathlib.Path(__file__).with_name("docstrings.txt")))
    (folder / "__init__.pyi").write_text("\n".join(stub.lines(built)) + "\n")
    (folder / "_docstrings.py").write_text(f"DOCSTRINGS = {stub.docs!r}\n")
