"""Summarises a ctest run: the slowest tests, failed and skipped tests, and counts.

    python3 tests/report.py build/tests

GoogleTest suites count once per case (results/*.json), other tests once each (report.xml).
"""

import json
import pathlib
import sys
import xml.etree.ElementTree

SLOWEST = 10


def cases_of(file):
    """Yields name, seconds and outcome of each case of one suite."""
    for suite in json.loads(file.read_text())["testsuites"]:
        for case in suite["testsuite"]:
            outcome = ("failed" if "failures" in case else
                       "skipped" if case["result"] == "SKIPPED" else "passed")
            yield f"{suite['name']}.{case['name']}", float(case["time"].rstrip("s")), outcome


def tests_of(folder):
    for test in xml.etree.ElementTree.parse(folder / "report.xml").iter("testcase"):
        name, status = test.get("name"), test.get("status")
        results = folder / "results" / (name.replace("/", "_") + ".json")
        room = name.split(".")[0]
        if results.exists():
            cases = [(f"{room}.{case}", *rest) for case, *rest in cases_of(results)]
            yield from cases
            if status != "fail" or any(outcome == "failed" for *_, outcome in cases):
                continue
        outcome = {"run": "passed", "fail": "failed"}.get(status, "skipped")
        yield name, float(test.get("time")), outcome


def main(folder):
    tests = list(tests_of(pathlib.Path(folder)))
    print(f"slowest {SLOWEST}:")
    for name, seconds, _ in sorted(tests, key=lambda test: -test[1])[:SLOWEST]:
        print(f"{seconds:8.1f} s  {name}")
    count = {}
    for name, _, outcome in tests:
        count[outcome] = count.get(outcome, 0) + 1
        if outcome != "passed":
            print(f"{outcome}: {name}")
    print(f"{count.get('passed', 0)} passed, {count.get('failed', 0)} failed, "
          f"{count.get('skipped', 0)} skipped")


if __name__ == "__main__":
    main(*sys.argv[1:])
