"""Promises of SECURITY.md and the page on limits name the tests that hold them, and these exist."""

import re

import pytest
from pages import SOURCES

LIMITS = "docs/reference/limits.md"


def held_by(text):
    """Files and names of tests: `tests/app/x_test.cpp` (Suite, Case)."""
    for line in re.findall(r"Held by: (.*)", text):
        for file, names in re.findall(r"`(tests/[^`]+)`(?: \(([^)]*)\))?", line):
            yield file, re.findall(r"\w+", names)


def is_test(name, text):
    return re.search(rf"\b(?:TEST(?:_[FP])?\((?:\w+, )?|def |class ){name}\b", text)


@pytest.mark.parametrize("page", ["SECURITY.md", LIMITS])
def test_the_tests_that_hold_a_promise_exist(page):
    named = list(held_by((SOURCES / page).read_text()))
    assert len(named) > 5
    for file, names in named:
        text = (SOURCES / file).read_text()
        missing = [name for name in names if not is_test(name, text)]
        assert not missing, f"{file} has no test {missing}"


def test_every_promise_about_untrusted_input_names_its_test():
    text = (SOURCES / "SECURITY.md").read_text()
    section = re.search(r"## Not trusted\n(.*?)\n## ", text, re.S)[1]
    promises = re.findall(r"^- .*", section, re.M)
    assert len(promises) > 5
    assert not [promise for promise in promises if "Held by: `tests/" not in promise]


@pytest.mark.parametrize("heading", ["## Inputs", "## Outputs", "### Recordings", "## Terminal"])
def test_every_section_of_limits_names_its_tests(heading):
    text = (SOURCES / LIMITS).read_text()
    section = re.search(rf"^{heading}\n(.*?)(?=^##)", text, re.S | re.M)[1]
    assert "Held by: `tests/" in section
