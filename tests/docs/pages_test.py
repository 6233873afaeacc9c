"""What the pages tell a reader to type is there, and what can run here does.

Comments before a block, which Markdown does not show, say what it needs: <!-- first: COMMANDS -->
runs before it, or stands before C++, where <!-- last: CODE --> stands after it. With
<!-- not run: WHY --> commands and flags must be there, no more.
"""

import dataclasses
import importlib.util
import os
import pathlib
import re
import shlex
import subprocess

import pytest

SOURCES = pathlib.Path(__file__).parents[2]
PROGRAM = os.environ.get("SLIPSTREAM_PROGRAM", str(SOURCES / "build" / "slipstream"))
PAGES = [*SOURCES.glob("*.md"), *SOURCES.glob("packaging/*.md"),
         *SOURCES.glob("ros/*.md"), *sorted(SOURCES.glob("docs/**/*.md"))]
SHELL = ("sh", "bash", "console")

# Lines that ask for more than a program and its files.
NEEDS = {
    "a camera": r"(aravis|v4l2):|slipstream camera",
    "a projector": r"--monitor|slipstream project",
    "a window": r"slipstream (live(?!.*--headless)|view(?!.*shot )|studio)",
    "a screen of its own": r"^xvfb-run",
    "a network, or a build": r"^(apt|apt-get|npm|vcpkg|conan|\./dev|[A-Z_]+=\S* )|ctest|build/tests",
}
WRAPPERS = ("xvfb-run", "timeout", "parallel")
OF_OTHER_PROGRAMS = {"--requeue", "--resume-failed"}


@dataclasses.dataclass
class Block:
    page: pathlib.Path
    language: str
    text: str
    comments: dict

    def runs(self):
        return self.language in SHELL and "not run" not in self.comments


def blocks_of(page):
    fenced = r"^((?: *<!--(?:(?!-->).)*-->\n)*)( *)```(\S*)[^\n]*\n(.*?)^\2```$"
    for before, indent, language, text in re.findall(fenced, page.read_text(), re.M | re.S):
        comments = dict(re.findall(r"<!-- ([a-z ]+):\s(.*?) -->", before, re.S))
        yield Block(page, language, re.sub(rf"^{indent}", "", text, flags=re.M), comments)


def lines_of(text):
    """Of a shell, the continued ones joined; of a console what follows its prompt."""
    lines = re.sub(r" *\\\n *", " ", text).splitlines()
    prompts = [line[2:] for line in lines if line.startswith("$ ")]
    return prompts or [line for line in lines if line and not line.startswith("#")]


def simple_commands(line):
    lexer = shlex.shlex(line, posix=True, punctuation_chars=";|&")
    lexer.whitespace_split = True
    words = []
    for word in [*lexer, ";"]:
        if not set(word) <= set(";|&"):
            words.append(word)
        elif words:
            yield words
            words = []


def inline_code(page):
    prose = re.sub(r"^ *```.*?^ *```", "", page.read_text(), flags=re.M | re.S)
    return re.findall(r"`([^`\n]+)`", prose)


BLOCKS = [block for page in PAGES for block in blocks_of(page)]


@pytest.fixture(scope="module")
def commands():
    spec = importlib.util.spec_from_file_location(
        "command_pages", SOURCES / "packaging" / "command_pages.py")
    pages = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pages)
    return {words: (flags, below) for words, flags, below in pages.commands_of(PROGRAM)}


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


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_flags_and_files_are_there(page, commands, tasks):
    known = {flag for flags, _ in commands.values() for flag in flags} | OF_OTHER_PROGRAMS
    shown = [line for block in blocks_of(page) if block.language in SHELL
             for line in lines_of(block.text)]
    shown += [code for code in inline_code(page)
              if re.match(r"((build/)?slipstream [a-z-]|\./dev)", code)]
    wrong = [(line, named) for line in shown for words in simple_commands(line)
             for named in wrong_in(words, commands, tasks)]
    wrong += [(code, flag) for code in inline_code(page) if code.startswith("--")
              for flag in re.findall(r"(?:^| )(--[a-z][\w-]*)", code) if flag not in known]
    folders = r"(app|bench|cmake|debian|docs|examples|packaging|python|ros|slipstream|tests|tools)/"
    named = [(SOURCES, code) for code in inline_code(page)
             if re.match(folders + r"[\w./-]*$", code)]
    named += [(page.parent, link)
              for link in re.findall(r"\]\((?!https?:|#)([^)#]+)", page.read_text())]
    wrong += [(path, "is not there") for folder, path in named if not (folder / path).exists()]
    assert not wrong


def test_the_index_names_every_command(commands):
    named = re.findall(r"^\| `([a-z]+)` \|", (SOURCES / "docs" / "index.md").read_text(), re.M)
    assert set(named) == set(commands[()][1])


def test_shell_is_called_shell():
    assert not [block for block in BLOCKS if not block.language
                and re.search(r"^(\$ )?(build/)?slipstream [a-z]|^\./dev", block.text, re.M)]


def same_but_for_rounding(told, shown):
    """As the page shows it, up to its "...", with numbers off by what other vectors may change."""
    if shown.endswith("\n...\n"):
        shown = shown.removesuffix("...\n")
        told = "".join(told.splitlines(keepends=True)[:shown.count("\n")])
    number = r"-?\d+(?:\.\d+)?(?:e-?\d+)?"
    words_told, words_shown = (re.sub(number, "#", text).split() for text in (told, shown))
    assert words_told == words_shown
    assert [*map(float, re.findall(number, told))] == pytest.approx(
        [*map(float, re.findall(number, shown))], rel=0.05, abs=0.02)


def run(line, folder):
    environment = dict(os.environ, PATH=f"{folder / 'build'}:{os.environ['PATH']}")
    done = subprocess.run(["bash", "-euc", line], cwd=folder, env=environment,
                          capture_output=True, text=True)
    assert done.returncode == 0, f"{line}\n{done.stderr}"
    return done.stdout


@pytest.mark.parametrize("page", [page for page in PAGES if any(map(Block.runs, blocks_of(page)))],
                         ids=lambda page: page.name)
def test_blocks_run_one_after_the_other(page, tmp_path):
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "slipstream").symlink_to(PROGRAM)
    for folder in ("tests", "tools"):
        (tmp_path / folder).symlink_to(SOURCES / folder)
    for block in blocks_of(page):
        file = re.match(r"# (\S+\.yaml)\n", block.text)
        if file:
            (tmp_path / file[1]).write_text(block.text)
        if not block.runs():
            continue
        if "first" in block.comments:
            run(block.comments["first"], tmp_path)
        for line in lines_of(block.text):
            if any(re.search(pattern, line) for pattern in NEEDS.values()):
                continue
            told = run(line, tmp_path)
            if block.language == "console":
                shown = re.search(re.escape("$ " + line) + r"\n((?:(?!\$ ).*\n)*)", block.text)[1]
                same_but_for_rounding(told if shown else "", shown)


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
                               "-I", SOURCES, "-isystem", "/usr/include/eigen3",
                               tmp_path / "block.cpp"], capture_output=True, text=True)
        assert done.returncode == 0, f"{block.page.name}\n{block.text}\n{done.stderr}"


def test_python_stands_where_it_is_run():
    pages = {block.page.name for block in BLOCKS if block.language == "python"}
    assert pages == {"glossary.md", "index.md", "python.md"}  # tests/python/docs_test.py
