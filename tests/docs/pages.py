"""Reads the pages: their blocks of code, and the commands that they print.

Comments before a block, which Markdown does not show, say what it needs:

    <!-- first: CODE -->       C++ that stands before it; commands stand in the block itself
    <!-- last: CODE -->        C++ that stands after it
    <!-- data: SET -->         runs in a folder with this set of ../shared/data; not without it
    <!-- not run: WHY -->      commands and flags must exist, no more
"""

import dataclasses
import importlib.util
import os
import pathlib
import re
import shlex

SOURCES = pathlib.Path(__file__).parents[2]
PAGES = [*SOURCES.glob("*.md"), *SOURCES.glob("packaging/*.md"),
         *SOURCES.glob("ros/*.md"), *sorted(SOURCES.glob("docs/**/*.md"))]
PROGRAM = os.environ.get("SLIPSTREAM_PROGRAM", str(SOURCES / "build" / "slipstream"))
SHELL = ("sh", "bash", "console")


def command_pages():
    """The module that reads commands and flags from the program's help."""
    spec = importlib.util.spec_from_file_location(
        "command_pages", SOURCES / "packaging" / "command_pages.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def name_of(page):
    return str(page.relative_to(SOURCES))


@dataclasses.dataclass
class Block:
    page: pathlib.Path
    language: str
    text: str
    comments: dict

    def is_shell(self):
        return self.language in SHELL


def blocks_of(page):
    fenced = r"^((?: *<!--(?:(?!-->).)*-->\n)*)( *)```(\S*)[^\n]*\n(.*?)^\2```$"
    for before, indent, language, text in re.findall(fenced, page.read_text(), re.M | re.S):
        comments = dict(re.findall(r"<!-- ([a-z ]+):\s(.*?) -->", before, re.S))
        yield Block(page, language, re.sub(rf"^{indent}", "", text, flags=re.M), comments)


def lines_of(text):
    """Commands of a block: continued lines joined; in a console only the lines with a prompt. A
    block with a here-document is one command."""
    if re.search(r"<<'?\w", text):
        return [text]
    lines = re.sub(r" *\\\n *", " ", text).splitlines()
    prompts = [line[2:] for line in lines if line.startswith("$ ")]
    return prompts or [line for line in lines if line and not line.startswith("#")]


def simple_commands(line):
    """Words of each command of a line such as `a | b; c`."""
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


def inline_commands(page):
    """Commands within sentences that are complete: at least one argument, no placeholder."""
    for code in inline_code(page):
        command = re.match(r"(?:build/)?slipstream ((?:[a-z]+ )*)(.+)$", code)
        if command and not re.search(r"\b[A-Z]{3,}\b|\.\.\.", code):
            words = code.split()[1:]
            if any(not re.fullmatch(r"[a-z]+", word) for word in words) or len(words) > 2:
                yield code
