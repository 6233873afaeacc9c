"""`slipstream live --publish genicam:127.0.0.1`, read with Aravis, a generic GenICam client."""

import ctypes
import re
import signal
import struct
import subprocess
import sys
import time

import gi
import numpy as np
import pytest

from web_test import PATIENCE, Live, wait_for

gi.require_version("Aravis", "0.8")
from gi.repository import Aravis  # noqa: E402

ADDRESS = "127.0.0.1"
SIZE = (160, 120)


@pytest.fixture
def live(tmp_path):
    with Live(tmp_path, "--publish", f"genicam:{ADDRESS}", "--publish", "mcap:clouds.mcap",
              size="{}x{}".format(*SIZE), rate=10) as running:
        yield running


@pytest.fixture
def camera(live):
    return Aravis.Camera.new(ADDRESS)


def buffers(camera, count):
    """The next complete buffers; skips incomplete ones, which occur on a busy machine."""
    stream = camera.create_stream(None, None)
    for _ in range(8):
        stream.push_buffer(Aravis.Buffer.new_allocate(camera.get_payload()))
    camera.start_acquisition()
    taken = []
    end = time.monotonic() + PATIENCE
    while len(taken) < count:
        assert time.monotonic() < end, "no clouds come"
        buffer = stream.timeout_pop_buffer(1_000_000)
        if buffer and buffer.get_status() == Aravis.BufferStatus.SUCCESS:
            taken.append(buffer)
        elif buffer:
            stream.push_buffer(buffer)
        if len(taken) < count:
            stream.push_buffer(Aravis.Buffer.new_allocate(camera.get_payload()))
    camera.stop_acquisition()
    return taken


def points_in_file(path):
    """The points of each cloud in an MCAP file, metres."""
    zstd = ctypes.CDLL("libzstd.so.1")
    zstd.ZSTD_decompress.restype = ctypes.c_size_t
    count = SIZE[0] * SIZE[1]
    clouds = []

    def read(data):
        at = 0
        while at + 9 <= len(data):
            opcode, length = struct.unpack_from("<BQ", data, at)
            record = data[at + 9:at + 9 + length]
            at += 9 + length
            if opcode == 6 and len(record) == length:
                unpacked, = struct.unpack_from("<Q", record, 16)
                name, = struct.unpack_from("<I", record, 28)
                packed = record[32 + name + 8:]
                into = ctypes.create_string_buffer(unpacked)
                assert zstd.ZSTD_decompress(into, ctypes.c_size_t(unpacked), packed,
                                            ctypes.c_size_t(len(packed))) == unpacked
                read(into.raw)
            elif opcode == 5 and length > 16 * count:
                step = length // count  # bytes per point, with or without sigma; the fields before are short
                points = np.frombuffer(record[-1 - step * count:-1], "<f4").reshape(count, step // 4)
                clouds.append(points[:, :3])
    read(path.read_bytes()[8:])
    return clouds


def test_points_are_those_of_the_pipeline(live, camera):
    assert (camera.get_vendor_name(), camera.get_model_name()) == ("slipstream", "Scanner")
    assert camera.get_pixel_format_as_string() == "Coord3D_ABC32f"
    camera.set_frame_rate(1000)
    taken = set()

    def file_has_some():  # the file gets only clouds that share no frame
        for buffer in buffers(camera, 20):
            points = np.frombuffer(buffer.get_data(), "<f4").reshape(-1, 3)
            assert np.isfinite(points[:, 2]).sum() > 1000
            assert (np.isnan(points).any(axis=1) == np.isnan(points).all(axis=1)).all()
            taken.add((points / np.float32(1000)).tobytes())
        in_file = points_in_file(live.words.parent / "clouds.mcap")
        return sum(cloud.tobytes() in taken for cloud in in_file) >= 5

    wait_for(file_has_some)
    code, document = live.finish()
    assert code == 0
    assert document["sinks"][1]["name"] == f"genicam:{ADDRESS}"
    assert document["sinks"][1]["published"] >= len(taken)


def test_the_tool_of_aravis_finds_and_sets_it(live):
    def ask(*words):
        return subprocess.run(["arv-tool-0.8", "-a", ADDRESS, *words], capture_output=True, text=True,
                              timeout=PATIENCE).stdout

    # On a busy machine the tool may time out and print nothing.
    wait_for(lambda: "slipstream" in ask("values", "DeviceVendorName"))
    wait_for(lambda: "40" in ask("control", "MinimumModulation=40") + ask("control", "MinimumModulation"))
    wait_for(lambda: live.settings()["minimum-modulation"]["value"] == "40")
    wait_for(lambda: "Scan3dCoordinateScale" in ask("features"))


def test_depth_intensity_and_confidence_are_of_the_same_cloud(camera):
    camera.set_string("PixelFormat", "Coord3D_C16")
    assert camera.get_string("Scan3dOutputMode") == "ProjectedC"
    camera.set_string("Scan3dCoordinateSelector", "CoordinateC")
    camera.set_float("Scan3dCoordinateScale", 0.02)
    camera.set_float("Scan3dCoordinateOffset", 100)
    assert camera.get_float("Scan3dInvalidDataValue") == 0
    assert camera.get_boolean("Scan3dInvalidDataFlag")
    scale = camera.get_float("Scan3dCoordinateScale")
    depth = np.frombuffer(buffers(camera, 1)[0].get_data(), "<u2")
    assert 400 < (100 + scale * depth[depth > 0]).mean() < 1000

    camera.set_string("Scan3dOutputMode", "CalibratedABC_Grid")
    assert np.isnan(camera.get_float("Scan3dInvalidDataValue"))
    assert camera.dup_available_components() == ["Range", "Intensity", "Confidence"]
    camera.gv_set_multipart(True)
    for component in ("Intensity", "Confidence"):
        camera.select_component(component, Aravis.ComponentSelectionFlags.ENABLE)
    buffer = buffers(camera, 1)[0]
    ids = [buffer.get_part_component_id(part) for part in range(buffer.get_n_parts())]
    assert ids == [4, 1, 6]
    points, grey, confidence = (np.frombuffer(buffer.get_part_data(part), kind) for part, kind
                                in enumerate(("<f4", "u1", "u1")))
    assert ((confidence == 255) == np.isfinite(points[2::3])).all()
    assert grey[confidence == 255].mean() > grey[confidence == 0].mean()

    camera.gv_set_multipart(False)
    camera.select_component("Intensity", Aravis.ComponentSelectionFlags.EXCLUSIVE_ENABLE)
    camera.set_region(16, 8, 96, 64)
    buffer = buffers(camera, 1)[0]
    assert buffer.get_image_pixel_format() == Aravis.PIXEL_FORMAT_MONO_8
    assert buffer.get_image_region() == (16, 8, 96, 64)
    assert len(buffer.get_data()) == 96 * 64


def read(device, address, size):
    into = ctypes.create_string_buffer(size)
    device.read_memory(address, size, ctypes.addressof(into))  # raises on failure
    return into.raw


def description(device):
    """The camera's XML. Device.get_genicam_xml reads past its end, up to the next zero byte."""
    url = read(device, 0x200, 512).split(b"\0")[0].decode()
    _, address, size = url.split(";")
    return read(device, int(address, 16), int(size, 16)).decode()


def test_a_trigger_takes_the_next_cloud(camera):
    camera.set_trigger("Software")
    stream = camera.create_stream(None, None)
    for _ in range(3):
        stream.push_buffer(Aravis.Buffer.new_allocate(camera.get_payload()))
    camera.start_acquisition()
    assert stream.timeout_pop_buffer(500_000) is None
    for _ in range(2):
        camera.software_trigger()
        assert stream.timeout_pop_buffer(20_000_000)
        assert stream.timeout_pop_buffer(300_000) is None
    camera.stop_acquisition()


def test_packets_are_as_long_as_the_network_takes(camera):
    wait_for(lambda: camera.gv_auto_packet_size() > 60_000)  # loopback, once all test packets are answered
    assert len(buffers(camera, 3)) == 3
    camera.gv_set_packet_size(1500)
    assert len(buffers(camera, 3)) == 3


def test_every_feature_can_be_read_and_settings_change_the_run(live, camera, tmp_path):
    device, tree = camera.get_device(), camera.get_device().get_genicam()
    xml = description(device)
    (tmp_path / "camera.xml").write_text(xml)
    try:
        subprocess.run(["xmllint", "--noout", tmp_path / "camera.xml"], check=True)
    except FileNotFoundError:
        pass
    kinds = {"Enumeration": device.get_string_feature_value, "Boolean": device.get_boolean_feature_value,
             "StringReg": device.get_string_feature_value, "Integer": device.get_integer_feature_value,
             "Float": device.get_float_feature_value, "Command": lambda name: name}
    features = set(re.findall(r"<pFeature>(\w+)</pFeature>", xml))
    assert len(features) > 50
    for name in features:
        kind = re.search(rf'<(\w+) Name="{name}"', xml)[1]
        assert tree.get_node(name)
        if kind != "Category":
            assert kinds[kind](name) is not None
    wait_for(lambda: device.get_string_feature_value("Strategy").startswith("Pmp"))
    camera.set_float("MinimumModulation", 12.5)
    assert '"name":"minimum-modulation"' in live.get("/settings")[1].replace(" ", "")
    assert "12.5" in live.get("/settings")[1]
    with pytest.raises(Exception):
        device.set_integer_feature_value("Width", 10_000)


PROGRAM_OF_A_CLIENT = f"""
import gi, time
gi.require_version("Aravis", "0.8")
from gi.repository import Aravis
camera = Aravis.Camera.new("{ADDRESS}")
print(camera.get_device().is_controller(), camera.get_region(), flush=True)
stream = camera.create_stream(None, None)
camera.start_acquisition()
print("runs", flush=True)
time.sleep(100)
"""


def test_a_client_that_is_gone_makes_room_for_the_next_and_others_only_look(live):
    command = [sys.executable, "-c", PROGRAM_OF_A_CLIENT]
    memory = descriptors = None

    def client_in_control():  # after the previous client misses its heartbeat
        client = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        if client.stdout.readline().startswith("True"):
            return client
        client.kill()
        client.wait()
        return None

    for _ in range(3):
        client = wait_for(client_in_control)
        assert client.stdout.readline() == "runs\n"
        other = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
        assert other.stdout.startswith("False") and "runs" not in other.stdout
        client.send_signal(signal.SIGKILL)
        client.wait()
        memory, descriptors = memory or live.memory(), descriptors or live.descriptors()
    assert live.memory() < memory + 20
    wait_for(lambda: live.descriptors() <= descriptors)
    wait_for(lambda: "silent client" in live.words.read_text())
    code, document = live.finish()
    assert code == 0 and document["frames"]["lost"] == 0
    assert live.words.read_text().count("silent client") == 1
