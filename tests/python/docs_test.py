"""Each block of Python runs, one after the other, where what it names is there."""

import re
import shutil

from conftest import SOURCES, program, taken

import slipstream


def run_blocks_of(page):
    text = (SOURCES / "docs" / page).read_text()
    names = {}
    for block in re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        exec(compile(block, block.splitlines()[0], "exec"), names)


def test_glossary(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run_blocks_of("reference/glossary.md")
    kept = {path.name for path in (SOURCES / "docs" / "reference" / "glossary").iterdir()}
    assert {path.name for path in tmp_path.glob("*.jpg")} == kept


def test_start(tmp_path, monkeypatch):
    taken("pmp", path=tmp_path / "scan")
    monkeypatch.chdir(tmp_path)
    run_blocks_of("index.md")
    assert (tmp_path / "cloud.ply").exists()


def test_guide(tmp_path, monkeypatch):
    taken("dual-frequency", path=tmp_path / "scan", steps=3, high=16, low=1)
    (tmp_path / "pictures").mkdir()
    for picture in (tmp_path / "scan").glob("frame_*.png"):
        shutil.copy(picture, tmp_path / "pictures")
    shutil.copy(tmp_path / "scan" / "scanner.yaml", tmp_path / "calibration.yaml")
    program("simulate", tmp_path / "poses", "--boards", "4", "--corners", "9x6", "--spacing", "20",
            "--strategy", "dual-frequency", "--steps", "3")
    for n in (1, 2):
        slipstream.simulate(slipstream.Sequence("pmp, steps 8"), tmp_path / f"flat_{n}", seed=n,
                            scene="board", camera=(320, 240))
    monkeypatch.chdir(tmp_path)
    run_blocks_of("tutorials/python.md")
    for written in ["cloud.ply", "described/scan.yaml", "mesh.glb", "own.ply", "scanner.yaml"]:
        assert (tmp_path / written).exists(), written


def test_first_hour(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run_blocks_of("tutorials/first-hour.md")
    assert (tmp_path / "cloud.ply").exists()
