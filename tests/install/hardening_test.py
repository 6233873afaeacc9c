#!/usr/bin/env python3
"""What `readelf` says of the built programs and the Python module: cmake/hardening.cmake.

tests/install/hardening_test.py FILE...
"""

import subprocess
import sys

WANTED = {
    "read-only relocations": "GNU_RELRO",
    "all symbols resolved at the start": "BIND_NOW",
    "stack protector": "__stack_chk_fail",
    "checked indices": "__glibcxx_assert_fail",
}
WANTED_OF_PROGRAMS = {"fortified functions": "__memcpy_chk"}
WANTED_OF_X86_64 = {"control-flow protection": "x86 feature: IBT, SHSTK"}


def lacks(path):
    told = subprocess.run(["readelf", "-hldnW", "--dyn-syms", path], check=True, text=True,
                          stdout=subprocess.PIPE).stdout
    wanted = dict(WANTED)
    if ".so" not in path:
        wanted.update(WANTED_OF_PROGRAMS)
    if "X86-64" in told:
        wanted.update(WANTED_OF_X86_64)
    return [name for name, mark in wanted.items() if mark not in told]


def main(paths):
    failures = [f"{path}: no {name}" for path in paths for name in lacks(path)]
    print("\n".join(failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
