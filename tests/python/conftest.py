"""What the tests of the Python module share."""

import os
import pathlib
import re
import subprocess

import pytest

import slipstream

SOURCES = pathlib.Path(__file__).parents[2]
PROGRAM = os.environ.get("SLIPSTREAM_PROGRAM", str(SOURCES / "build" / "slipstream"))


def run_program(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)


def program(*arguments):
    """What the program prints; it must succeed."""
    done = run_program(*arguments)
    assert done.returncode == 0, done.stderr
    return done.stdout


def as_printed(error):
    """The message of a refused scan as the program prints it: with flags and commands."""
    other_names = {"excluded": "exclude", "bits": "camera-bits",
                   "least_alpha": "least-reflectivity"}

    def flag(match):
        name, value = match.groups("")
        return "--" + other_names.get(name, name).replace("_", "-") + value

    def command(match):
        return "slipstream " + match[1].replace("_", " ")

    message = re.sub(r"`(slipstream [^`]*)`", r"\1", str(error).removeprefix("scan: "))
    message = re.sub(r"`([a-z][a-z0-9_]*)\(\)`", command, message)
    return re.sub(r"`([a-z][a-z0-9_]*)( [^`]+)?`", flag, message)


def taken(name, camera=(320, 240), scene="sphere", path=None, **settings):
    sequence = slipstream.Sequence(slipstream.Strategy(name, **settings))
    return slipstream.simulate(sequence, path, scene=scene, camera=camera)


@pytest.fixture(scope="session")
def dual():
    """A virtual scan of two frequencies."""
    return taken("dual-frequency", steps=3, high=16, low=1)


@pytest.fixture
def engine(dual):
    return slipstream.Engine(dual.scan.scanner, dual.scan.sequence)
