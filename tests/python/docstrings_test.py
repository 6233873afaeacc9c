"""Docstrings are numpydoc, complete, and their examples run; the stub has every type."""

import ast
import doctest
import inspect
import pathlib

import numpy
import pytest

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


def test_all_names_are_seen():
    assert {"Cloud", "Cloud.z", "Cloud.to_open3d", "decode", "threads"} <= set(PUBLIC)
    assert len(CALLS) > 40


@pytest.mark.parametrize("name", PUBLIC)
def test_it_has_a_docstring(name):
    doc = PUBLIC[name].__doc__
    assert doc and len(doc) > 4, name
    assert not doc.startswith(name.split(".")[-1] + "("), "pybind11's signature"
    if isinstance(PUBLIC[name], property):
        assert ": " in doc and not doc.endswith(": ")
    elif name not in ("Error", "WorldError"):
        assert "\nExamples\n--------\n>>> " in doc


@pytest.mark.parametrize("name", CALLS)
def test_arguments_results_and_sections(name):
    doc = inspect.getdoc(CALLS[name])
    arguments = [one for one in inspect.signature(CALLS[name]).parameters if one != "self"]
    assert ("\nParameters\n----------\n" in doc) == bool(arguments)
    lines = doc.split("\n")
    for one in arguments:
        at = [n for n, line in enumerate(lines) if line.startswith(f"{one} : ")]
        assert len(at) == 1 and lines[at[0] + 1].startswith("    "), one
    returns = ast.unparse(dict(stubs())[name].returns)
    assert ("\nReturns\n-------\n" in doc) == (returns != "None")
    order = [doc.find(f"\n{title}\n---") for title in
             ("Parameters", "Returns", "Raises", "Examples")]
    found = [place for place in order if place >= 0]
    assert found == sorted(found)


@pytest.mark.parametrize("name", [name for name, bound in PUBLIC.items()
                                  if isinstance(bound, type) and name not in EXCEPTIONS
                                  and any(f"{name}.__init__" == one for one, _ in stubs())])
def test_arguments_of_constructors_are_described(name):
    arguments = dict(stubs())[f"{name}.__init__"].args
    for one in arguments.args[1:] + arguments.kwonlyargs:
        assert f"\n{one.arg} : " in PUBLIC[name].__doc__, one.arg


@pytest.mark.parametrize("name", dict(stubs()))
def test_everything_has_type_hints(name):
    function = dict(stubs())[name]
    assert function.returns is not None
    first = 1 if "." in name else 0
    for one in function.args.args[first:] + function.args.kwonlyargs:
        assert one.annotation is not None, one.arg


def test_settings_are_described_as_on_the_command_line():
    for function in (slipstream.decode, slipstream.reconstruct, slipstream.Cloud.cleaned):
        assert "\n    fill gaps in a surface up to this width, pixels\n" in function.__doc__


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
                                  if "\n>>> " in bound.__doc__])
def test_examples_run(name, names, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if name == "Live.stop":
        names["live"] = slipstream.Live("virtual", names["sequence"], camera=(64, 48)).start()
    test = doctest.DocTestParser().get_doctest(PUBLIC[name].__doc__, dict(names), name, None, 0)
    assert test.examples
    result = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test)
    assert result.failed == 0
