"""Pages agree with the program: commands, flags, files and links that they name exist.

Tier: every change; seconds. commands_test.py runs the commands.
"""

import os
import re
import subprocess

import pytest
from pages import (PAGES, PROGRAM, SHELL, SOURCES, blocks_of, command_pages, inline_code, lines_of,
                   name_of, simple_commands)

WRAPPERS = ("xvfb-run", "timeout", "parallel")
OF_OTHER_PROGRAMS = {"--requeue", "--resume-failed"}
BLOCKS = [block for page in PAGES for block in blocks_of(page)]


@pytest.fixture(scope="module")
def commands():
    return {words: (flags, below) for words, flags, below in command_pages().commands_of(PROGRAM)}


@pytest.fixture(scope="module")
def tasks():
    return set(re.findall(r"^  ([a-z]+)(?= \||\))", (SOURCES / "dev").read_text(), re.M))


def wrong_in(words, commands, tasks):
    """What is not there of what a command names."""
    while words and re.match(r"[A-Z_]+=", words[0]):
        words = words[1:]
    if words and words[0] in WRAPPERS:
        words = words[next((at for at, word in enumerate(words) if word == "slipstream"), 0):]
    if not words:
        return []
    if words[0] == "./dev":
        return [word for word in words[1:2] if word not in tasks]
    if words[0] not in ("slipstream", "build/slipstream"):
        return [word for word in words[:1] if "/" in word and not word.startswith("build/")
                and not (SOURCES / word).exists()]
    path, words = (), words[2:] if words[1:2] == ["help"] else words[1:]
    while words and words[0] in commands[path][1]:
        path, words = (*path, words[0]), words[1:]
    flags, below = commands[path]
    if below and words and re.match(r"[a-z]+$", words[0]):
        return words[:1]
    short = {"-h": "--help", "-o": "--output"}
    asked = [word.split("=")[0] for word in words if re.match(r"--?[a-zA-Z]", word)]
    return [flag for flag in asked if short.get(flag, flag) not in flags]


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_flags_and_files_are_there(page, commands, tasks):
    known = {flag for flags, _ in commands.values() for flag in flags} | OF_OTHER_PROGRAMS
    shown = [line for block in blocks_of(page) if block.language in SHELL
             for line in lines_of(block.text) if "\n" not in line]
    shown += [code for code in inline_code(page)
              if re.match(r"((build/)?slipstream [a-z-]|\./dev)", code)]
    wrong = [(line, named) for line in shown for words in simple_commands(line)
             for named in wrong_in(words, commands, tasks)]
    wrong += [(code, flag) for code in inline_code(page) if code.startswith("--")
              for flag in re.findall(r"(?:^| )(--[a-z][\w-]*)", code) if flag not in known]
    folders = (r"(app|bench|cmake|debian|docs|examples|include|packaging|python|ros|src|tests|tools)/"
               r"(?!slipstream_ros)")  # src/ of a ROS workspace
    named = [(SOURCES, code) for code in inline_code(page)
             if re.match(folders + r"[\w./-]*$", code)]
    named += [(SOURCES / "include", code) for code in inline_code(page)
              if re.match(r"slipstream/[\w./-]*$", code)]
    named += [(page.parent, link)
              for link in re.findall(r"\]\((?!https?:|#)([^)#]+)", page.read_text())]
    wrong += [(path, "is not there") for folder, path in named if not (folder / path).exists()]
    assert not wrong


def test_the_index_names_every_command(commands):
    named = re.findall(r"^\| `([a-z]+)` \|", (SOURCES / "docs" / "index.md").read_text(), re.M)
    assert set(named) == set(commands[()][1])


def test_readers_see_all_commands_of_a_block():
    assert not [block for block in BLOCKS if block.is_shell() and "first" in block.comments]


def test_shell_is_called_shell():
    assert not [block for block in BLOCKS if not block.language
                and re.search(r"^(\$ )?(build/)?slipstream [a-z]|^\./dev", block.text, re.M)]


def test_cpp_compiles(tmp_path):
    whole = {}
    for block in BLOCKS:
        if block.language != "cpp" or "not run" in block.comments:
            continue
        text = "\n".join([whole.get(block.page, ""), block.comments.get("first", ""), block.text,
                          block.comments.get("last", "")])
        if not block.comments:
            whole[block.page] = text
        (tmp_path / "block.cpp").write_text(text)
        done = subprocess.run([os.environ.get("CXX", "c++"), "-std=c++20", "-fsyntax-only",
                               "-I", SOURCES / "include", "-isystem", "/usr/include/eigen3",
                               tmp_path / "block.cpp"], capture_output=True, text=True)
        assert done.returncode == 0, f"{block.page.name}\n{block.text}\n{done.stderr}"


def test_python_stands_where_it_is_run():
    pages = {block.page.name for block in BLOCKS if block.language == "python"}
    assert pages == {"first-hour.md", "glossary.md", "index.md", "python.md"}  # tests/python/docs_test.py
