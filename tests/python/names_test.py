"""Names in backquotes in the library's texts are known to users of the module and the program."""

import ast
import importlib.util
import pathlib
import re
import struct

import numpy
import pytest
from conftest import PROGRAM, SOURCES, as_printed

import slipstream

STUB = ast.parse(pathlib.Path(slipstream.__file__).with_name("__init__.pyi").read_text())
# Help of settings that only C++ has.
ONLY_IN_CPP = {"fewest_neighbours", "largest_doubt"}
# Settings of commands that the module has no function for: hand-eye calibration, calibration from
# lists of points, colours, residual maps, and the shape that `live` follows.
NOT_IN_PYTHON = {"board_convention", "robot_convention", "eye {}", "swap camera", "swap projector",
                 "unit", "grey_patch", "residual", "track"}


def literals_in(source):
    """The string literals of C++, neighbours joined."""
    joined, end = "", 0
    tokens = r'//[^\n]*|/\*.*?\*/|R"\(.*?\)"|\'(?:\\.|[^\'\\])\'|"((?:\\.|[^"\\\n])*)"'
    for token in re.finditer(tokens, source, re.DOTALL):
        if token[1] is None:
            continue
        if source[end:token.start()].strip():
            yield joined
            joined = ""
        joined, end = joined + token[1], token.end()
    yield joined


def names_in_the_library():
    names = set()
    for folder in ["src", "include"]:
        for path in (SOURCES / folder).rglob("*.[ch]*"):
            for literal in literals_in(path.read_text()):
                names |= set(re.findall("`([^`]*)`", literal))
    # Names and values that are filled in stand in the other test, of remedies.
    return sorted(name for name in names if not re.match(r"(no_)?{}", name)
                  and name not in ONLY_IN_CPP)


NAMES = names_in_the_library()


def settings_of_remedies():
    for path in (SOURCES / "src").rglob("*.cpp"):
        text = path.read_text()
        yield from re.findall(r'try_setting\(\s*"(\w+)"', text)
        for settings in re.findall(r"change_settings\((.*?)\)[;,}]", text, re.DOTALL):
            yield from re.findall(r'{"(\w+)",', settings)


@pytest.fixture(scope="module")
def module_names():
    """Keywords, functions and attributes of the module, and the settings of strategies."""
    names = {setting for setting, *_ in slipstream.strategy_settings()}
    for node in ast.walk(STUB):
        if isinstance(node, ast.FunctionDef):
            names |= {node.name, *(one.arg for one in node.args.args + node.args.kwonlyargs)}
    return names


@pytest.fixture(scope="module")
def flags():
    """The flags of each command of the program."""
    spec = importlib.util.spec_from_file_location(
        "command_pages", SOURCES / "packaging" / "command_pages.py")
    pages = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pages)
    return {" ".join(("slipstream", *words)): set(found)
            for words, found, _ in pages.commands_of(PROGRAM)}


def test_names_are_found():
    assert {"order", "calibrate_gamma()", "gamma blind", "camera_bits {}"} <= set(NAMES)
    assert {"order", "camera_bits", "gamma"} <= set(settings_of_remedies())


def require_command(text, flags):
    """Of a text such as `slipstream live --gain {}`."""
    command, _, flag = text.partition(" --")
    assert command in flags
    assert not flag or "--" + flag.split()[0] in flags[command]


@pytest.mark.parametrize("name", sorted({*NAMES, *settings_of_remedies()} - NOT_IN_PYTHON))
def test_the_module_knows_them(name, module_names, flags):
    shown = slipstream._slipstream._with_keywords(f"`{name}`")
    for text in re.findall("`([^`]*)`", shown):
        if text.startswith("slipstream "):
            require_command(text, flags)
        else:
            word = re.match(r"(?:scanner\.)?(\w+)", text)[1]
            assert word in module_names, shown
            assert not text.endswith("()") or hasattr(slipstream, word) or word == "patterns"


@pytest.mark.parametrize("name", [*NAMES, *sorted(set(settings_of_remedies()))])
def test_the_program_knows_them(name, flags):
    shown = as_printed(f"`{name}`")
    if shown.startswith("slipstream "):
        require_command(shown, flags)
    else:
        assert any(shown.split()[0] in of_command for of_command in flags.values()), shown


@pytest.mark.parametrize("text, shown", [
    ("try `camera_bits 12`; or wait", "try `bits 12`; or wait"),
    ("check `board` and `corners`", "check `board` and `columns` and `rows`"),
    ("look with `view()`", "look with `slipstream view`"),
    ("use `print estimated`", "use `print_deviation 0.01`"),
    ("set `ambient_light`", "set `scanner.ambient`"),
    ("`order 2,0,1` it`s `view()`", "`order 2,0,1` it`s `slipstream view`"),
    ("a lone ` here", "a lone ` here"),
    ("", ""),
])
def test_other_names_replace_those_of_the_library(text, shown):
    assert slipstream._slipstream._with_keywords(text) == shown


def test_findings_and_errors_have_the_names_of_the_module(dual):
    wide = [frame.astype("u2") for frame in dual.scan.frames]
    scan = slipstream.Scan(wide, dual.scan.sequence, dual.scan.scanner)
    finding = slipstream.check(scan)[0]
    assert "`bits 8`" in finding.advice and "`bits 8`" in str(finding)
    with pytest.raises(slipstream.Error, match="try `bits 8`") as error:
        slipstream.reconstruct(scan)
    assert "`bits 8`" in error.value.findings[0].advice
    with pytest.warns(UserWarning, match="try `bits 8`"):
        slipstream.decode(wide, dual.scan.sequence)


def test_a_part_of_the_picture_is_loaded(dual, tmp_path):
    part = [frame[10:210, 20:300] for frame in dual.scan.frames]
    slipstream.Scan(part, dual.scan.sequence).save(tmp_path / "part")
    dual.scan.scanner.write(tmp_path / "scanner.yaml")
    right = slipstream.reconstruct(dual.scan).z[10:210, 20:300]
    for scanner in [tmp_path / "scanner.yaml", dual.scan.scanner]:
        scan = slipstream.load_scan(tmp_path / "part", scanner=scanner,
                                    camera_region=(20, 10, 280, 200))
        made = slipstream.reconstruct(scan).z
        assert made.shape == (200, 280)
        assert abs(made - right)[~numpy.isnan(made - right)].max() < 0.01


def test_binned_pictures_take_a_scanner_as_they_take_its_file(tmp_path):
    scan = slipstream.simulate("pmp, steps 4", camera=(160, 120)).scan
    slipstream.Scan(scan.frames, scan.sequence).save(tmp_path / "binned")
    larger = slipstream.example_scanner((320, 240))
    again = slipstream.load_scan(tmp_path / "binned", scanner=larger,
                                 camera_region=(0, 0, 320, 240))
    as_text = slipstream.load_scan(tmp_path / "binned", scanner=larger,
                                   camera_region="320x240+0+0")
    assert again.scanner == as_text.scanner
    assert again.scanner.camera_size == (160, 120)
    assert again.scanner.camera_matrix[0, 0] == pytest.approx(larger.camera_matrix[0, 0] / 2)
    with pytest.raises(slipstream.Error, match="if the camera has joined pixels since"):
        slipstream.load_scan(tmp_path / "binned", scanner=larger)


def test_colour_pictures_are_read_by_the_channel(tmp_path):
    for n in range(4):
        pixels = bytes([7, 100, 200]) * (16 * 12)
        header = b"BM" + struct.pack("<IIIIiiHHIIiiII", 54 + len(pixels), 0, 54, 40, 16, 12, 1, 24,
                                     0, len(pixels), 0, 0, 0, 0)
        (tmp_path / f"frame_{n}.bmp").write_bytes(header + pixels)
    scan = slipstream.load_scan(tmp_path, "pmp, steps 4", channel="blue")
    assert scan.frames[0][5, 5] == 7
    with pytest.raises(slipstream.Error, match="channel 'x': expected one of: auto"):
        slipstream.load_scan(tmp_path, "pmp, steps 4", channel="x")
