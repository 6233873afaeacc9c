#!/usr/bin/env python3
"""Share of the code lines that tests have run, for each room, by gcov.

tools/coverage.py BUILD    a build folder of the preset `coverage`, after its tests
"""

import collections
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]


def room_of(path):
    """The folder below src/ or include/, or one of app/ and python/; None for all else."""
    if not path.is_relative_to(ROOT):
        return None
    parts = path.relative_to(ROOT).parts
    if parts[0] == "src" and len(parts) > 2:
        return parts[1]
    if parts[0] == "include":
        return "public headers"
    return parts[0] if parts[0] in ("app", "python") else None


def runs_of(counts):
    """How often each line has run, by file, as one .gcda file counts; gcov may know several."""
    told = subprocess.run(["gcov", "--json-format", "--stdout", counts], check=True, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    lines = []
    for report in map(json.loads, told.splitlines()):
        for source in report["files"]:
            path = pathlib.Path(os.path.normpath(
                pathlib.Path(report["current_working_directory"]) / source["file"]))
            if room_of(path):
                lines += [((path, line["line_number"]), line["count"]) for line in source["lines"]]
    return lines


def main(build):
    runs = collections.Counter()
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for lines in pool.map(runs_of, sorted(pathlib.Path(build).resolve().rglob("*.gcda"))):
            for line, count in lines:
                runs[line] += count

    # A template's line is one, however many instances have it.
    rooms = collections.defaultdict(lambda: [0, 0])
    for (path, _), count in runs.items():
        for name in (room_of(path), "all"):
            rooms[name][0] += count > 0
            rooms[name][1] += 1
    if not rooms:
        sys.exit(f"{build}: no counts; build and test the preset coverage first")

    print("| room | lines | run, % |\n| --- | ---: | ---: |")
    for name, (run, lines) in sorted(rooms.items(), key=lambda room: room[0] == "all"):
        print(f"| {name} | {lines} | {100 * run / lines:.1f} |")


if __name__ == "__main__":
    main(sys.argv[1])
