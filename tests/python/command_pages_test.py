"""What shells are told of the program is what it has."""

import importlib.util
import re
import shutil
import subprocess

import pytest
from conftest import PROGRAM, SOURCES


@pytest.fixture(scope="module")
def pages():
    spec = importlib.util.spec_from_file_location(
        "command_pages", SOURCES / "packaging" / "command_pages.py")
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
    named = {flag for file in (SOURCES / "app").glob("*.cpp")
             for flag in re.findall(r'add\w*(?:<[^"]*>)?\(\s*"(--[\w-]+)"', file.read_text())}
    assert len(named) > 150 and named <= {flag for flags in found.values() for flag in flags}


OFFERED = pytest.mark.parametrize("typed, offered", [
    ("slipstream rec", "reconstruct record"),
    ("slipstream calibrate ga", "gamma"),
    ("slipstream reconstruct scan --largest-s", "--largest-sigma"),
    ("slipstream nothing --ver", "--version"),
])


def answer_of(shell, script, asked):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    told = subprocess.run([shell], input=script + asked, capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    return told.stdout.split("\n")


@OFFERED
def test_bash_offers_them(pages, commands, typed, offered):
    words = typed.split()
    told = answer_of("bash", pages.bash(commands), (
        f"COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; "
        f"_slipstream slipstream {words[-1]}; printf '%s\\n' ${{COMPREPLY[*]}}"))
    assert told[:-1] == offered.split()


@OFFERED
def test_fish_offers_them(pages, commands, typed, offered):
    told = answer_of("fish", pages.fish(commands), f"complete -C '{typed}'")
    assert [line.split("\t")[0] for line in told[:-1]] == offered.split()


@OFFERED
def test_zsh_offers_them(pages, commands, typed, offered):
    """All that may follow: zsh itself looks which begin as the word does."""
    given = (f"words=({typed}); CURRENT={len(typed.split())}; _files() {{ }}; "
             "_describe() { print -l -- ${(P)2} }\n")
    told = answer_of("zsh", given + pages.zsh(commands), "")
    begun = typed.split()[-1]
    assert [line.split(":")[0] for line in told if line.startswith(begun)] == offered.split()


def test_a_man_page_has_the_name_of_its_file(pages):
    """As lintian wants it, which only a release runs."""
    made = ('.TH SLIPSTREAM CALIBRATE HAND-EYE "1" "May 2026" "slipstream calibrate hand-eye 1.0"\n'
            ".SH NAME\nslipstream calibrate hand-eye \\- find a robot's hand\n")
    words, name = ("calibrate", "hand-eye"), "slipstream-calibrate-hand-eye"
    assert pages.with_name_of_file(made, words, name).split("\n")[:3] == [
        '.TH SLIPSTREAM-CALIBRATE-HAND-EYE "1" "May 2026" "slipstream calibrate hand-eye 1.0"',
        ".SH NAME", "slipstream-calibrate-hand-eye \\- find a robot's hand"]
