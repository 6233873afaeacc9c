"""Summarises a ctest run: the slowest tests, failures and their files, skips, and counts.

    python3 tests/report.py build/tests

Tests of GoogleTest and pytest count once per case (results/*.xml), others once each (report.xml).
A skipped test fails the run unless may_skip.txt allows it. night.json, in the folder above, keeps
the day on which each nightly test last ran.
"""

import collections
import datetime
import fnmatch
import json
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree

SOURCES = pathlib.Path(__file__).resolve().parents[1]
SLOWEST = 10
DAYS = 7  # that a nightly test may wait for its turn

Test = collections.namedtuple("Test", "name seconds outcome words")


def file_of(case):
    """The file of a case of pytest: tests.python.docs_test is tests/python/docs_test.py."""
    return (case.get("classname") or "").replace(".", "/") + ".py"


def cases_of(file, room):
    """Yields each case of one suite of GoogleTest or file of pytest."""
    for case in xml.etree.ElementTree.parse(file).iter("testcase"):
        suite, name = case.get("classname") or "", case.get("name")
        of_pytest = case.get("file") is None
        outcome, words = "passed", ""
        for kind, told in (("failure", "failed"), ("error", "failed"), ("skipped", "skipped")):
            found = case.find(kind)
            if found is not None:
                outcome, words = told, found.get("message") or ""
                if of_pytest:
                    words = f"{file_of(case)}: {words}"
                break
        full = f"{file.stem}.{name}" if of_pytest else f"{room}.{suite}.{name}"
        yield Test(full, float(case.get("time")), outcome, words)


def first_complaint(test):
    """The lines of a test's output that say what is wrong: CMake tells the file first, then why."""
    lines = (test.findtext("system-out") or "").splitlines()
    for sign in (r"error:|CMake Error", r"error|fail|not ok|skipped"):
        for at, line in enumerate(lines):
            if re.search(sign, line, re.I):
                return " ".join(lines[at:at + 4])
    return " ".join(lines[-1:])


def tests_of(folder):
    for test in xml.etree.ElementTree.parse(folder / "report.xml").iter("testcase"):
        name, status = test.get("name"), test.get("status")
        results = folder / "results" / (name.replace("/", "_") + ".xml")
        if results.exists():
            cases = [*cases_of(results, name.split(".")[0])]
            yield from cases
            if status != "fail" or any(case.outcome == "failed" for case in cases):
                continue
        outcome = {"run": "passed", "fail": "failed"}.get(status, "skipped")
        yield Test(name, float(test.get("time")), outcome, first_complaint(test))


def allowed_skips():
    """Yields what a skipped test's name or words must match, and what stays unproved without it."""
    for line in (pathlib.Path(__file__).parent / "may_skip.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            pattern, _, unproved = line.partition(": ")
            yield pattern, unproved


def judge_skips(tests):
    """Turns skips that are not allowed into failures; prints what the others leave unproved."""
    allowed = [*allowed_skips()]
    left = collections.Counter()
    for test in tests:
        if test.outcome == "skipped":
            unproved = next((entry for entry in allowed if fnmatch.fnmatch(test.name, entry[0])
                             or entry[0] in test.words), None)
            if unproved:
                left[unproved] += 1
            else:
                test = test._replace(outcome="failed", words=f"skipped, {test.words}")
        yield test
    for (pattern, unproved), count in sorted(left.items()):
        print(f"{count} skipped, {pattern}: {unproved}")


def late_at_night(folder):
    """Notes the nightly tests of this run; prints which have not run for long."""
    report = xml.etree.ElementTree.parse(folder / "report.xml")
    ran = {test.get("name") for test in report.iter("testcase")
           if test.get("status") in ("run", "fail")}
    file = folder.parent / "night.json"
    known = json.loads(file.read_text()) if file.exists() else None
    shown = subprocess.run(["ctest", "--show-only=json-v1"], cwd=folder.parent, check=True,
                           capture_output=True, text=True).stdout
    today, last = datetime.date.today(), {}
    for test in json.loads(shown)["tests"]:
        if any(entry["name"] == "LABELS" and entry["value"][0].startswith("night")
               for entry in test["properties"]):
            name = test["name"]
            last[name] = str(today) if name in ran else (known or {}).get(name, "never")
    file.write_text(json.dumps(last, indent=1) + "\n")
    if known is None:
        print(f"{len(ran & last.keys())} of {len(last)} nightly tests ran; no earlier run is known")
        return

    late = {name: day for name, day in last.items()
            if day == "never" or (today - datetime.date.fromisoformat(day)).days > DAYS}
    for day, count in sorted(collections.Counter(late.values()).items()):
        one = next(name for name in late if late[name] == day)
        print(f"{count} nightly tests last ran: {day} ({one}{' and others' if count > 1 else ''})")


def main(folder):
    folder = pathlib.Path(folder)
    tests = [*tests_of(folder)]
    print(f"slowest {SLOWEST}:")
    for test in sorted(tests, key=lambda test: -test.seconds)[:SLOWEST]:
        print(f"{test.seconds:8.1f} s  {test.name}")

    tests = [*judge_skips(tests)]
    if folder.parent.name == "build":
        late_at_night(folder)
    for test in tests:
        if test.outcome == "failed":
            words = test.words.replace(f"{SOURCES}/", "")
            print(f"failed: {' '.join(words.split())[:200]} ({test.name})")
    count = collections.Counter(test.outcome for test in tests)
    print(f"{count['passed']} passed, {count['failed']} failed, {count['skipped']} skipped")
    return 1 if count["failed"] else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
