"""Docstrings are complete, and their examples run; the stub has every type."""

import ast
import doctest
import inspect
import pathlib
import re

import numpy
import pytest
from conftest import SOURCES

import slipstream

STUB = ast.parse(pathlib.Path(slipstream.__file__).with_name("__init__.pyi").read_text())
EXCEPTIONS = {"Error", "WorldError", "Validity"}  # no examples of their members


def members_of(name, bound):
    for member in vars(bound):
        if not member.startswith("_") and name not in EXCEPTIONS:
            yield f"{name}.{member}", vars(bound)[member]


def public():
    """Each public name with its object, members of classes included."""
    for name, bound in vars(slipstream).items():
        if name.startswith("_") or inspect.ismodule(bound):
            continue
        yield name, bound
        if isinstance(bound, type):
            yield from members_of(name, bound)


PUBLIC = dict(public())
CALLS = {name: bound for name, bound in PUBLIC.items()
         if not isinstance(bound, (type, property))}


def stubs():
    """Functions and methods of the stub by name."""
    for node in STUB.body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, node
        elif isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for member in node.body:
                if isinstance(member, ast.FunctionDef):
                    yield f"{node.name}.{member.name}", member


def described(name):
    """The docstring without the signature that pybind11 writes before it."""
    doc = inspect.getdoc(PUBLIC[name])
    begins_with_signature = re.match(rf"{name.split('.')[-1]}\(.*\) -> .*\n+", doc)
    return doc[begins_with_signature.end():] if begins_with_signature else doc


def entries_of(doc, title):
    """The lines below a title, without their indentation."""
    found = re.search(rf"^{title}:\n((?:    .*\n|\n)+)", doc + "\n", re.MULTILINE)
    return inspect.cleandoc("\n" + found[1]) if found else ""


def arguments_of(function):
    every = [*function.args.args, *function.args.kwonlyargs]
    return [one.arg for one in every if one.arg != "self"]


def test_all_names_are_seen():
    assert {"Cloud", "Cloud.z", "Cloud.to_open3d", "decode", "threads"} <= set(PUBLIC)
    assert len(CALLS) > 40


@pytest.mark.parametrize("name", PUBLIC)
def test_it_has_a_docstring(name):
    doc = described(name)
    assert len(doc) > 4, name
    assert not doc.startswith(name.split(".")[-1] + "(")
    if isinstance(PUBLIC[name], property):
        assert re.match(r"[^:]+: .", doc)
    elif name not in ("Error", "WorldError"):
        assert entries_of(doc, "Example").startswith(">>> ")


@pytest.mark.parametrize("name", CALLS)
def test_arguments_results_and_sections(name):
    doc, stub = described(name), dict(stubs())[name]
    arguments = arguments_of(stub)
    entries = entries_of(doc, "Args")
    for one in arguments:
        assert len(re.findall(rf"^{one} \(.+\):\s+\S", entries, re.MULTILINE)) == 1, one
    assert len(re.findall(r"^\w+ \(", entries, re.MULTILINE)) == len(arguments)
    assert bool(entries_of(doc, "Returns")) == (ast.unparse(stub.returns) != "None")
    order = [doc.find(f"\n{title}:\n") for title in ("Args", "Returns", "Raises", "Example")]
    found = [place for place in order if place >= 0]
    assert found == sorted(found)


@pytest.mark.parametrize("name", [name for name, bound in PUBLIC.items()
                                  if isinstance(bound, type) and name not in EXCEPTIONS
                                  and any(f"{name}.__init__" == one for one, _ in stubs())])
def test_arguments_of_constructors_are_described(name):
    entries = entries_of(described(name), "Args")
    for one in arguments_of(dict(stubs())[f"{name}.__init__"]):
        assert len(re.findall(rf"^{one} \(.+\):\s+\S", entries, re.MULTILINE)) == 1, one


def stated_defaults(name):
    """The keywords with a default that the docstring states."""
    arguments = dict(stubs())[name].args
    return {one.arg: ast.literal_eval(default)
            for one, default in zip(arguments.kwonlyargs, arguments.kw_defaults)}


def test_stated_defaults_are_those_of_the_module(tmp_path):
    stated = slipstream.Sequence("pmp", **stated_defaults("Sequence.__init__"))
    assert stated == slipstream.Sequence("pmp")
    designs = slipstream.design(**stated_defaults("design"))
    assert [one.strategy for one in designs] == [one.strategy for one in slipstream.design()]
    with pytest.raises(slipstream.Error):  # not a TypeError: only the poses are missing
        slipstream.calibrate_geometry(tmp_path, **stated_defaults("calibrate_geometry"))


def test_the_module_takes_every_stated_keyword(dual):
    scan, scanner = dual.scan, dual.scan.scanner
    members = arguments_of(dict(stubs())["Scanner.__init__"])
    slipstream.Scanner(**{name: getattr(scanner, name) for name in members})

    slipstream.Engine(scanner, scan.sequence, **stated_defaults("Engine.__init__"))
    slipstream.decode(scan.frames, scan.sequence, **stated_defaults("decode"))
    slipstream.reconstruct(scan, **stated_defaults("reconstruct")).cleaned(
        **stated_defaults("Cloud.cleaned"))
    slipstream.simulate(scan.sequence, **stated_defaults("simulate"))
    slipstream.Live("virtual", scan.sequence, **stated_defaults("Live.__init__"))


def test_every_keyword_is_described():
    taken = {name for source in (SOURCES / "python" / "bindings").glob("*.cpp")
             for call in re.findall(r"\bkeywords\.(?:take|need)\((.*?)\);",
                                    source.read_text(), re.DOTALL)
             for name in re.findall(r'"([a-z]\w*)"', call)}
    stated = {one.arg for function in dict(stubs()).values() for one in function.args.kwonlyargs}
    assert len(taken) > 40
    assert not taken - stated


@pytest.mark.parametrize("name", dict(stubs()))
def test_everything_has_type_hints(name):
    function = dict(stubs())[name]
    assert function.returns is not None
    first = 1 if "." in name else 0
    for one in function.args.args[first:] + function.args.kwonlyargs:
        assert one.annotation is not None, one.arg


def test_settings_are_described_as_on_the_command_line():
    for function in (slipstream.decode, slipstream.reconstruct, slipstream.Cloud.cleaned):
        assert re.search(r"widest_gap \(int, default 0\):\n +fill gaps in a surface up to this "
                         r"width, pixels\n", function.__doc__)


@pytest.fixture(scope="module")
def names():
    """What the module's own example makes, which all others start from."""
    names = {}
    for example in doctest.DocTestParser().get_examples(slipstream.__doc__):
        exec(example.source, names)
    assert set(names) >= {"scan", "sequence", "engine", "cloud", "maps"}
    return {**names, "numpy": numpy}


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", [name for name, bound in PUBLIC.items()
                                  if ">>> " in bound.__doc__])
def test_examples_run(name, names, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if name == "Live.stop":
        names["live"] = slipstream.Live("virtual", names["sequence"], camera=(64, 48)).start()
    test = doctest.DocTestParser().get_doctest(PUBLIC[name].__doc__, dict(names), name, None, 0)
    assert test.examples
    result = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test)
    assert result.failed == 0
