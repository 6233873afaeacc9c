"""Each example runs on data that the program makes."""

import json
import os
import subprocess
import sys

import pytest
from conftest import SOURCES, program, run_program, taken

import slipstream

EXAMPLES = SOURCES / "examples" / "python"


def run(name, *arguments):
    done = subprocess.run([sys.executable, EXAMPLES / (name + ".py"), *map(str, arguments)],
                          capture_output=True, text=True, env=os.environ)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    folder = tmp_path_factory.mktemp("example") / "scan"
    taken("dual-frequency", path=folder, steps=3, high=16, low=1)
    return folder


def test_every_example_is_run():
    tested = {name.removeprefix("test_") for name in globals() if name.startswith("test_")}
    assert {path.stem for path in EXAMPLES.glob("*.py")} <= tested


def test_folder_to_cloud(scan, tmp_path):
    assert " points of 76800 pixels" in run("folder_to_cloud", scan, tmp_path / "cloud.ply")
    program("reconstruct", scan, "-o", tmp_path / "program.ply")
    assert (tmp_path / "cloud.ply").read_bytes() == (tmp_path / "program.ply").read_bytes()


def test_loop_over_scans():
    assert run("loop_over_scans").startswith("8 clouds of ")


def test_plot_depth(scan, tmp_path):
    assert "points drawn" in run("plot_depth", scan, tmp_path / "depth.png")
    assert (tmp_path / "depth.png").read_bytes().startswith(b"\x89PNG")


def test_own_decoder():
    said = run("own_decoder")
    assert float(said.split(" is ")[1].split()[0]) < 1e-5


def test_calibrate(tmp_path):
    program("simulate", tmp_path / "poses", "--boards", "4", "--corners", "9x6", "--spacing", "20",
            "--strategy", "dual-frequency", "--steps", "3")
    flats = [tmp_path / f"flat_{n}" for n in range(2)]
    for n, flat in enumerate(flats):
        slipstream.simulate(slipstream.Sequence("pmp, steps 8"), flat, scene="board", seed=n + 1,
                            camera=(320, 240))
    said = run("calibrate", tmp_path / "poses", *flats, tmp_path / "scanner.yaml")
    assert "RMS" in said and "noise variance" in said
    assert slipstream.load_scanner(tmp_path / "scanner.yaml").noise_variance > 0


def test_live():
    assert run("live").startswith("57 clouds")


def test_hand_over(scan):
    assert "float32, 3 columns" in run("hand_over", scan)


def test_other_folder(scan, tmp_path):
    pictures = tmp_path / "pictures"
    pictures.mkdir()
    for path in scan.glob("frame_*.png"):
        (pictures / path.name).write_bytes(path.read_bytes())
    slipstream.load_scanner(scan / "scanner.yaml").write(tmp_path / "calibration.xml")
    assert run_program("reconstruct", pictures).returncode == 2  # it does not say what it shows
    said = run("other_folder", pictures, tmp_path / "calibration.xml", tmp_path / "scan")
    assert " points of 76800 pixels" in said and "warning" not in said


def test_choose_patterns():
    assert run("choose_patterns").count("median error") == 3


def test_read_recording(tmp_path):
    taken("pmp", path=tmp_path / "scan.slip", steps=4)
    said = run("read_recording", tmp_path / "scan.slip")
    assert "frame 2: uint8 (240, 320)" in said and "its first cycle" in said


def test_notebook():
    """In Jupyter's kernel where that is there, else cell by cell."""
    path = EXAMPLES / "notebook.ipynb"
    cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
    assert not any(cell["outputs"] or cell["execution_count"] for cell in cells)
    try:
        import ipykernel  # noqa: F401
        import nbclient
        import nbformat
    except ImportError:
        import matplotlib
        matplotlib.use("Agg")
        names = {}
        for cell in cells:
            exec("".join(cell["source"]), names)
    else:
        done = nbclient.NotebookClient(nbformat.read(path, as_version=4)).execute()
        pictures = [output for cell in done.cells for output in cell.get("outputs", [])
                    if "image/png" in output.get("data", {})]
        assert len(pictures) == 3
