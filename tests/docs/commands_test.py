"""Runs every command that the pages print and that needs no device, page by page.

Tier: pages that the last commit changed and a fifth of all in each ./dev test, all in ./dev test all.
Unlike pages_test.py, which compares commands with the program's help, this runs them in the order in
which a reader would.

    python3 -m pytest -s tests/docs/commands_test.py   # all pages, with counts and times
"""

import os
import pathlib
import re
import resource
import signal
import subprocess
import sys
import time

import pytest
from pages import (PAGES, PROGRAM, SOURCES, blocks_of, command_pages, inline_commands, lines_of,
                   name_of)

DATA = SOURCES.parent / "shared" / "data"

# Lines that need more than the program, its files, a display and this machine's network.
NEEDS = {
    "a camera": r"aravis:(?!127)|v4l2:|slipstream (assist --source|capture --poses( 1)?`?$)",
    "a DLP projector": r"--dlp",
    "a second monitor": r"--monitor [1-9]",
    "a GPU": r"bench --gpu",
    "several machines": r"slipstream batch (?!plan archive)",
    "photographs": r"calibrate gamma --uniform|verify artefacts",
    "downloads, or builds": r"^(apt|apt-get|npm|vcpkg|conan|\./dev|[A-Z_]+=\S* )|ctest|build/tests",
}

# Parts of commands, printed within sentences.
FRAGMENTS = ("slipstream calibrate geometry poses", "slipstream project --colour")

# What a reader has after a command that is not run: the same folder, from the virtual world.
STAND_INS = {
    r"\./dev demo$": "slipstream demo",
    r"slipstream capture .*--steps 8 .*-o scan$":
        "slipstream simulate scan --strategy dual-frequency --steps 8 --virtual-gamma 2.2",
}

# Commands that repeat others of the pages.
REPEATED = {"slipstream reproduce all": "each item has its own line on another page"}

# They run until Ctrl-C or until their window is closed.
ENDLESS = (r"slipstream ((camera )?serve(?!.*(--frames|--duration))|studio|project(?!.*--list)"
           r"|view(?!.*(--snapshot|--screenshot|shot ))"
           r"|live(?!.*(--frames|--duration|--screenshot|replay:(?!.*--loop).*--headless)))")

# These complete what they have begun on Ctrl-C and exit with 0; others just end.
COMPLETED = r"slipstream (camera serve|serve|project|live)"

# Later commands of a page need these.
SERVING = r"slipstream (camera )?serve|--publish"

# Seconds that an endless command runs at least: enough for a first cloud under load.
ENDLESS_SECONDS = 15


@pytest.fixture(scope="session")
def display(tmp_path_factory):
    """A display for windows."""
    log = tmp_path_factory.mktemp("display") / "log"
    with log.open("w") as errors:
        server = subprocess.Popen(
            ["Xvfb", "-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset"],
            stdout=subprocess.PIPE, stderr=errors, text=True)
    yield f":{server.stdout.readline().strip()}"
    server.terminate()
    server.wait()


class Page:
    """Commands of one page, in one folder."""

    def __init__(self, name, folder, display):
        self.name = name
        self.folder = folder
        self.environment = dict(os.environ, DISPLAY=display,
                                PATH=f"{folder / 'build'}:{os.environ['PATH']}")
        self.endless = []
        self.ran = []
        self.not_run = []

    def run(self, line):
        used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        done = subprocess.run(["bash", "-euc", line], cwd=self.folder, env=self.environment,
                              capture_output=True, text=True)
        used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - used
        print(f"{used:6.1f} s of processor time: {line}")
        assert done.returncode == 0, f"{self.name}: {line}\n{done.stderr}"
        return done.stdout

    def begin(self, line):
        """Starts an endless command. A camera goes on until the next one, what publishes until the
        next endless command; others end once they have run for a while."""
        if "camera serve" in line:
            self.end_all()
        else:
            self.end_all(lambda running: "camera serve" not in running.args[-1])

        log = (self.folder / f"endless-{len(self.ran)}.log").open("w+")
        running = subprocess.Popen(["bash", "-euc", line], cwd=self.folder, env=self.environment,
                                   stdout=log, stderr=log, start_new_session=True)
        running.log = log
        self.endless.append(running)

        # A camera answers once it prints its address.
        until = time.monotonic() + (120 if "camera serve" in line else ENDLESS_SECONDS)
        while time.monotonic() < until and running.poll() is None:
            time.sleep(0.1)
            if "camera serve" in line and "127.0.0.1" in self.text_of(running):
                break
        assert running.poll() is None, f"{self.name}: {line} ended by itself\n{self.text_of(running)}"
        if not re.search(SERVING, line):
            self.end_all(lambda other: other is running)

    @staticmethod
    def text_of(running):
        running.log.flush()
        with open(running.log.name) as log:
            return log.read()

    def end_all(self, which=lambda running: True):
        """Ends endless commands as Ctrl-C does."""
        for running in [running for running in self.endless if which(running)]:
            self.endless.remove(running)
            if running.poll() is None:
                os.killpg(running.pid, signal.SIGINT)
            try:
                code = running.wait(60)
            except subprocess.TimeoutExpired:
                os.killpg(running.pid, signal.SIGKILL)
                code = "none within 60 s of Ctrl-C"
            allowed = [0] if re.search(COMPLETED, running.args[-1]) else [0, -signal.SIGINT]
            assert code in allowed, f"{self.name}: {running.args[-1]}: exit code {code}\n{self.text_of(running)}"

    def kill_all(self):
        for running in self.endless:
            if running.poll() is None:
                os.killpg(running.pid, signal.SIGKILL)
                running.wait()

    def obey(self, line):
        """Runs a line, unless it needs what a test does not have. Returns its output, or None."""
        why = next((need for need, pattern in NEEDS.items() if re.search(pattern, line)),
                   next((why for begin, why in REPEATED.items() if begin in line), None))
        if why:
            self.not_run.append((why, line))
            stand_in = next((other for one, other in STAND_INS.items() if re.search(one, line)), None)
            if stand_in:
                self.run(stand_in)
            return None

        self.ran.append(line)
        if re.search(ENDLESS, line):
            self.begin(line)
            return None
        return self.run(line)


def same_except_rounding(printed, shown):
    """Compares output with the page's, up to its "...", allowing for rounding by other vectors."""
    if shown.endswith("\n...\n"):
        shown = shown.removesuffix("...\n")
        printed = "".join(printed.splitlines(keepends=True)[:shown.count("\n")])

    number = r"-?\d+(?:\.\d+)?(?:e-?\d+)?"
    printed_text, shown_text = (re.sub(number, "#", text).split() for text in (printed, shown))
    assert printed_text == shown_text
    assert [*map(float, re.findall(number, printed))] == pytest.approx(
        [*map(float, re.findall(number, shown))], rel=0.05, abs=0.02)


def run_block(block, page):
    """Runs a block's lines; compares what a console shows."""
    why = block.comments.get("not run")
    data = block.comments.get("data")
    if data and not (DATA / data).exists():
        why = f"data set {data}"
    if why:
        page.not_run += [(why, line) for line in lines_of(block.text)]
        return

    if data:
        for file in (DATA / data).iterdir():
            if not (page.folder / file.name).exists():
                (page.folder / file.name).symlink_to(file)
    for line in lines_of(block.text):
        printed = page.obey(line)
        if block.language == "console" and printed is not None:
            shown = re.search(re.escape("$ " + line) + r"\n((?:(?!\$ ).*\n)*)", block.text)[1]
            same_except_rounding(printed if shown else "", shown)


def run_inline(command, page):
    """Runs a command of a sentence; the scan that it names is the one of the page, if any."""
    if command in FRAGMENTS or command in page.ran:
        return
    if re.search(r"\bscan\b", command) and not (page.folder / "scan").exists():
        page.run("slipstream simulate scan --camera 320x240")
    page.obey(command)


def has_commands(page):
    return any(block.is_shell() for block in blocks_of(page)) or any(inline_commands(page))


def run_page(page, folder, display):
    # 1. A folder as a reader has it: the built program, the interpreter that has Debian's modules,
    # and the folders that pages name.
    (folder / "build").mkdir()
    (folder / "build" / "slipstream").symlink_to(PROGRAM)
    (folder / "build" / "python3").symlink_to(sys.executable)
    (folder / "build" / "examples").symlink_to(pathlib.Path(PROGRAM).parent / "examples")
    for name in ("bench", "tests", "tools"):
        (folder / name).symlink_to(SOURCES / name)

    # 2. Blocks in their order, then commands within sentences.
    commands, began = Page(name_of(page), folder, display), time.monotonic()
    try:
        for block in blocks_of(page):
            file = re.match(r"# (\S+\.yaml)\n", block.text)
            if file:
                (folder / file[1]).write_text(block.text)
            if block.is_shell():
                run_block(block, commands)
        for command in inline_commands(page):
            run_inline(command, commands)
        commands.end_all()
    finally:
        commands.kill_all()

    # 3. The account.
    print(f"\n{name_of(page)}: {len(commands.ran)} commands ran in "
          f"{time.monotonic() - began:.0f} s, {len(commands.not_run)} did not")
    for why, line in commands.not_run:
        print(f"  not run, {why}: {line}")


@pytest.mark.parametrize("page", [*filter(has_commands, PAGES)], ids=name_of)
def test_commands_run(page, tmp_path, display):
    run_page(page, tmp_path, display)


def changed_pages():
    """Pages that the last commit or the working tree changed, or None if git knows no commit before
    the last."""
    try:
        done = subprocess.run(["git", "diff", "--name-only", "HEAD~1", "--", "*.md"], cwd=SOURCES,
                              capture_output=True, text=True)
    except FileNotFoundError:
        return None
    return done.stdout.split() if done.returncode == 0 else None


def test_commands_of_changed_pages_run(tmp_path_factory, display):
    changed = changed_pages()
    if changed is None:
        pytest.skip("no commit before this one is known")

    for page in filter(has_commands, PAGES):
        if name_of(page) in changed:
            run_page(page, tmp_path_factory.mktemp("page"), display)


# A pose file.
BASE = ("printf 'from: camera\\nto: base\\nunit: mm\\ntranslation: [900, 0, 1400]\\n"
        "rotation_vector: [3.1, 0, 0]\\n' > base.yaml;")

# A scanner file of the projector of the examples.
LARGE = ("slipstream simulate s; sed 's/projector_width: .*/projector_width: 1824/;"
         " s/projector_height: .*/projector_height: 1140/' s/scanner.yaml > large.yaml;")

# What the examples of --help start from, by how they begin; the first entry that fits.
STARTS = {
    "live --source replay": "slipstream record --source virtual --world ideal --camera 160x120"
                            " --strategy pmp --frames 6 --rate 0 -o scan.slip",
    "serve": "slipstream simulate example --camera 160x120; cp example/scanner.yaml .;"
             " printf 'source: virtual\\nworld: ideal\\npublish: [web:8080]\\n' > rig.yaml",
    "calibrate height": "for n in 0 10 20; do slipstream simulate plane_$n --scene board"
                        " --camera 160x120 --seed $n; done",
    "height": "for n in 0 10 20; do slipstream simulate plane_$n --scene board --camera 160x120"
              " --seed $n; done; slipstream calibrate height plane_0 plane_10 plane_20"
              " --heights 0,10,20 -o heights.npy; slipstream simulate scan --camera 160x120",
    "calibrate hand-eye": "slipstream calibrate virtual-robot rehearsal; cp rehearsal/* .",
    "calibrate touch": "slipstream calibrate virtual-robot rehearsal; cp rehearsal/* .;"
                       " mv truth.yaml camera.yaml",
    "calibrate virtual-robot": "true",
    "calibrate verify": "slipstream simulate poses --boards 6 --corners 13x9 --spacing 10"
                        " --camera 320x240; cp poses/scanner.yaml .",
    "calibrate geometry": LARGE + " slipstream simulate poses --boards 8 --corners 13x9"
                          " --spacing 10 --strategy dual-frequency --steps 3 --high 16 --low 1"
                          " --scanner large.yaml",
    "calibrate colour scan": "slipstream simulate scan --colour --paint 0.5 --strategy"
                             " dual-frequency --steps 3",
    "calibrate points": "slipstream simulate poses --boards 6 --corners 13x9 --spacing 15"
                        " --camera 640x480; slipstream calibrate geometry poses --corners 13x9"
                        " --spacing 15 -o first.yaml --save-points points.csv",
    "calibrate residual": "slipstream simulate scan --scene board --axis both;"
                          " sed '/projector_distortion/,/data/ s/-0.06/-0.065/'"
                          " scan/scanner.yaml > scanner.yaml",
    "calibrate colour": "slipstream simulate white --scene board --primaries --camera 128x96;"
                        " slipstream simulate scan --camera 128x96; cp scan/scanner.yaml .",
    "calibrate": "for n in 1 2 3; do slipstream simulate scan_$n --scene board --strategy pmp"
                 " --steps 8 --camera 320x240 --seed $n; done",
    "reconstruct frames": LARGE + " slipstream simulate frames --strategy dual-frequency"
                          " --steps 3 --high 16 --low 1 --scanner large.yaml;"
                          " mv frames/scanner.yaml .; rm frames/scan.yaml",
    "reconstruct phase.tiff": "slipstream simulate scan --strategy pmp --frequency 16"
                              " --camera 320x240; cp scan/scanner.yaml .;"
                              " slipstream reconstruct scan --nearest 366 --farthest 416"
                              " --coordinate phase.tiff",
    "check frames": "slipstream simulate frames --strategy pmp --steps 4 --camera 320x240;"
                    " rm frames/scan.yaml",
    "batch plan": "slipstream simulate day --camera 160x120; echo day > archive.txt",
    "measure scan": "slipstream simulate scan",
    "measure cloud": "slipstream simulate s --scene sphere; slipstream reconstruct s -o cloud.ply;"
                     " slipstream reconstruct s -o cloud.pcd",
    "frame convert": BASE,
    "frame compose": BASE + " printf 'from: camera\\nto: flange\\nunit: mm\\ntranslation:"
                            " [0, 50, 90]\\nrotation_vector: [0, 0, 0]\\n' > flange.yaml;"
                            " sed -i s/camera/flange/ base.yaml",
    "frame points": "slipstream simulate plate --scene board",
    "frame board": "slipstream simulate boards --boards 1 --corners 13x9 --spacing 15"
                   " --camera 320x240; cp boards/scanner.yaml .",
    "frame marker": "slipstream simulate boards --boards 1 --board charuco --corners 4x3"
                    " --spacing 40; cp boards/scanner.yaml .",
    "merge view1": "for n in 1 2 3; do slipstream simulate s$n --scene statue --camera 320x240"
                   " --steps 8 --seed $n; slipstream reconstruct s$n -o view$n.ply; done",
    "merge scan1": "for n in 1 2; do slipstream simulate scan$n --scene statue --camera 320x240"
                   " --seed $n; done",
    "unwrap wrapped": "slipstream simulate scan --strategy pmp --frequency 8 --steps 4;"
                      " for f in tiff npy; do slipstream reconstruct scan --phase wrapped.$f; done",
    "view cloud": "slipstream simulate s; slipstream reconstruct s -o cloud.ply",
    "convert scan.slip": "slipstream record --source virtual --world ideal --camera 160x120"
                         " --strategy pmp --frames 6 --rate 0 -o scan.slip",
    "convert scanner.yaml": "slipstream simulate s --camera 160x120; cp s/scanner.yaml .",
    "convert clouds.mcap": "slipstream record --source virtual --world ideal --camera 160x120"
                           " --strategy pmp --frames 6 --rate 0 -o first.slip; mkdir clouds;"
                           " slipstream live --source replay:first.slip --headless"
                           " --publish mcap:clouds.mcap",
    "": "slipstream simulate scan --camera 320x240",
}


def examples_of_help():
    """Commands of the section Examples of each --help."""
    of_program = command_pages()
    for words, _, _ in of_program.commands_of(PROGRAM):
        text = of_program.output_of(PROGRAM, *words, "--help-all")
        text = re.sub(r" \\\n\s+", " ", text)  # continued lines
        section = re.search(r"^Examples?:\n((?:  slipstream .*\n?)+)", text, re.M)
        yield from section[1].splitlines() if section else []


def test_examples_of_help_run(tmp_path, display):
    wrong, count = [], 0
    for number, example in enumerate(map(str.strip, examples_of_help())):
        folder = tmp_path / str(number)
        (folder / "build").mkdir(parents=True)
        (folder / "build" / "slipstream").symlink_to(PROGRAM)
        start = next(start for begin, start in STARTS.items()
                     if example.removeprefix("slipstream ").startswith(begin))

        commands = Page(f"example {number} of --help", folder, display)
        try:
            if not any(re.search(need, example) for need in NEEDS.values()):
                commands.run(start)
            commands.obey(example)
            commands.end_all()
        except AssertionError as error:
            wrong.append(f"{example}\n{error}")
        finally:
            commands.kill_all()
        count += len(commands.ran)
    print(f"\n--help: {count} examples ran")
    assert not wrong, "\n\n".join(wrong)
