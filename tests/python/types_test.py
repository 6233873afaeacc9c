"""The stubs say what the module has, and the examples keep to them."""

import ast
import pathlib
import subprocess
import sys

from conftest import SOURCES

import slipstream

STUB = pathlib.Path(slipstream.__file__).with_name("__init__.pyi")
WRITTEN = {"__init__", "__len__", "__getitem__", "__iter__", "__next__", "__enter__", "__exit__"}


def names_in(nodes):
    names = set()
    for node in nodes:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, ast.AnnAssign):
            names.add(node.target.id)
    return {name for name in names if not name.startswith("_") or name in WRITTEN}


def public(names):
    return {name for name in names if not name.startswith("_")}


def test_stubs_have_every_name():
    stub = ast.parse(STUB.read_text())
    module = {name for name in public(vars(slipstream)) if name != "slipstream"}
    assert names_in(stub.body) == module
    for node in stub.body:
        if not isinstance(node, ast.ClassDef) or node.name.startswith("_"):
            continue
        if node.name in ("Error", "WorldError", "Validity"):
            continue
        written = vars(getattr(slipstream, node.name))
        told = names_in(node.body)
        assert public(told) == public(written), node.name
        for name in (told & WRITTEN) - {"__iter__"}:
            assert name in written, f"{node.name}.{name}"


def test_everything_has_a_docstring():
    for name in public(vars(slipstream)):
        assert getattr(slipstream, name).__doc__, name


def test_examples_are_typed():
    examples = sorted(map(str, (SOURCES / "examples" / "python").glob("*.py")))
    checked = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir=/dev/null",
         "--no-warn-unused-ignores",  # only older releases of other modules lack types
         str(STUB), *examples],
        capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout
