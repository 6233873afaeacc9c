"""The page on the dissertation has each of its numbers, in order, with a command that is there."""

import os
import pathlib
import re
import subprocess

SOURCES = pathlib.Path(__file__).parents[2]
PROGRAM = os.environ.get("SLIPSTREAM_PROGRAM", str(SOURCES / "build" / "slipstream"))


def dissertation_rows():
    """The rows of the dissertation's page: what the print has, and the command for it."""
    page = (SOURCES / "docs" / "background" / "dissertation.md").read_text()
    return re.findall(r"^\| ((?:Section|Figure|Table|Experiment)[^|]*) \|.*\| (.*) \|$", page, re.M)


def test_the_dissertation_has_each_number_once_and_in_order():
    figures, tables = {1: 56, 2: 5, 3: 24, 4: 26}, {2: 2, 3: 7, 4: 1}
    sections = {1: 4, 2: 2, 3: 3, 4: 5, 5: 3}
    rows = [print_has for print_has, _ in dissertation_rows()]
    for kind, numbers in (("Figure", figures), ("Table", tables), ("Section", sections)):
        printed = [f"{kind} {chapter}.{number}" for chapter, last in numbers.items()
                   for number in range(1, last + 1)]
        assert [row for row in rows if row.startswith(kind)] == printed


def test_the_dissertation_has_a_command_or_says_why_not():
    without = [row for row in dissertation_rows()
               if not re.search(r"`slipstream |not a figure of data|\]\(|^no numbers|^Chapters",
                                row[1])]
    assert not without


def test_the_dissertation_names_each_item_of_reproduce_in_its_row():
    listed = subprocess.run([PROGRAM, "reproduce", "--list"], capture_output=True, text=True,
                            check=True).stdout
    items = {line.split()[0] for line in listed.splitlines() if line}
    named = {}
    for print_has, command in dissertation_rows():
        for item in re.findall(r"slipstream reproduce ([a-z]+-[\w.]+)", command):
            named.setdefault(item, []).append(print_has.lower().replace(" ", "-"))
    assert items == set(named)
    misplaced = {item: rows for item, rows in named.items()
                 if not item.startswith("experiment") and rows != [item]}
    assert not misplaced
