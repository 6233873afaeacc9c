"""What shells are told of the program is what it has."""

import importlib.util
import shutil
import subprocess

import pytest
from conftest import PROGRAM, SOURCES


@pytest.fixture(scope="module")
def pages():
    spec = importlib.util.spec_from_file_location(
        "command_pages", SOURCES / "tools" / "command_pages.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def commands(pages):
    return list(pages.commands_of(PROGRAM))


def test_commands_and_flags_are_found(commands):
    found = {words: flags for words, flags, _ in commands}
    assert ("calibrate", "gamma") in found and ("demo",) in found
    assert "--source" in found[("record",)]
    assert {"--help", "--strategy", "--json", "--output"} <= set(found[("reconstruct",)])
    assert all(said for flags in found.values() for said in flags.values())


@pytest.mark.parametrize("typed, offered", [
    ("slipstream rec", "reconstruct record"),
    ("slipstream calibrate ga", "gamma"),
    ("slipstream reconstruct scan --max-s", "--max-sigma"),
    ("slipstream nothing --ver", "--version"),
])
def test_bash_offers_them(pages, commands, typed, offered):
    words = typed.split()
    asked = (f"COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; "
             f"_slipstream slipstream {words[-1]}; echo ${{COMPREPLY[*]}}")
    told = subprocess.run(["bash", "-c", pages.bash(commands) + asked], capture_output=True,
                          text=True)
    assert told.stdout.split() == offered.split(), told.stderr


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_read_theirs(pages, commands, tmp_path, shell):
    (tmp_path / "script").write_text(getattr(pages, shell)(commands))
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    assert subprocess.run([shell, "-n", tmp_path / "script"]).returncode == 0
