"""`slipstream live --publish web`: pages, settings, recordings."""

import base64
import concurrent.futures
import http.client
import json
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import time

import prometheus_client.parser
import pytest

from chromium import PROGRAM as CHROMIUM, Chromium

SOURCES = pathlib.Path(__file__).parents[2]
PROGRAM = os.environ.get("SLIPSTREAM_PROGRAM", str(SOURCES / "build" / "slipstream"))
PATIENCE = 300  # s; only to end a hang


class Live:
    """The running program, in its own folder."""

    def __init__(self, folder, *flags, web="web:0", size="320x240", rate=30, command=None):
        self.words = folder / "words"
        sinks = ["--publish", web] if web else []
        command = command or [
            "live", "--source", "virtual", "--world", "ideal", "--camera", size, "--rate", str(rate),
            "--strategy", "pmp", "--steps", "4", "--headless", "--json", *sinks, *flags]
        self.process = subprocess.Popen(
            [PROGRAM, *command],
            cwd=folder, stdout=subprocess.PIPE, stderr=self.words.open("w"), text=True)
        if not web:
            return
        try:
            wait_for(self.has_address)
            self.address = re.search(r"http://\S+", self.words.read_text())[0]
            self.port = int(re.search(r":(\d+)/", self.address)[1])
            wait_for(lambda: self.statistics()["clouds"] > 0)
        except BaseException:
            self.__exit__()
            raise

    def has_address(self):
        ended = self.process.poll() is not None
        words = self.words.read_text()
        assert not ended, f"it ended at once: {words}"
        return re.search(r"http://\S+", words)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        # Shown if a test fails because the program ended by itself.
        if (code := self.process.poll()) is not None:
            print(f"it had ended with {code}: {self.words.read_text()}")

        self.process.kill()
        self.process.wait()

    def token(self):
        return self.address.partition("/?")[2]

    def get(self, path, method="GET", body=None, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        connection.request(method, path + ("?" + self.token() if self.token() else ""), body,
                           headers)
        answer = connection.getresponse()
        return answer.status, answer.read().decode("utf-8", "replace")

    def statistics(self):
        return json.loads(self.get("/statistics")[1])

    def change(self, wish):
        return self.get("/settings", "POST", wish, Origin=f"http://127.0.0.1:{self.port}")

    def settings(self):
        return {setting["name"]: setting for setting in json.loads(self.get("/settings")[1])}

    def memory(self):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1024

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def finish(self):
        self.process.send_signal(signal.SIGINT)
        out, _ = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, json.loads(out)


def wait_for(come):
    end = time.monotonic() + PATIENCE
    while not (value := come()):
        assert time.monotonic() < end
        time.sleep(0.02)
    return value


def ask_for_page(port, path="/clouds", host=None, origin=None):
    """Requests a WebSocket; returns the socket and the first line of the answer."""
    host = host or f"127.0.0.1:{port}"
    head = [f"GET {path} HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade",
            f"Sec-WebSocket-Key: {base64.b64encode(bytes(16)).decode()}",
            "Sec-WebSocket-Version: 13"]
    head += [f"Origin: {origin}"] if origin else []
    client = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
    client.sendall("\r\n".join([*head, "", ""]).encode())
    answer = b""
    while b"\r\n\r\n" not in answer:
        more = client.recv(1)
        if not more:
            break
        answer += more
    return client, answer.decode().splitlines()[0] if answer else ""


def say(client, text, opcode=1):
    client.sendall(bytes([0x80 | opcode, 0x80 | len(text)]) + bytes(4) + text)


def receive(client, count):
    taken = b""
    while len(taken) < count:
        more = client.recv(count - len(taken))
        assert more
        taken += more
    return taken


def take_message(client):
    head = receive(client, 2)
    length = head[1]
    if length == 126:
        length, = struct.unpack(">H", receive(client, 2))
    elif length == 127:
        length, = struct.unpack(">Q", receive(client, 8))
    return head[0] & 15, receive(client, length)


def newest(live):
    client, _ = ask_for_page(live.port, origin=f"http://127.0.0.1:{live.port}")
    with client:
        say(client, b"next")
        return take_message(client)[1]


@pytest.fixture(scope="module")
def live(tmp_path_factory):
    with Live(tmp_path_factory.mktemp("live")) as running:
        yield running


def test_pages_say_what_the_document_says(live):
    assert live.get("/health") == (200, "ok\n")
    status, page = live.get("/")
    assert status == 200 and "<canvas" in page
    told = live.statistics()
    assert told["frames"]["captured"] > 0 and told["sinks"][0]["name"] == "web:0"
    assert live.get("/rays")[0] == 200


def test_prometheus_reads_the_metrics(live):
    families = {family.name: family for family
                in prometheus_client.parser.text_string_to_metric_families(live.get("/metrics")[1])}
    captured = families["slipstream_frames_captured"]
    assert captured.type == "counter" and captured.samples[0].value > 0
    stages = {sample.labels["name"] for sample in families["slipstream_stages_rate"].samples}
    assert stages == {"capture", "window", "reconstruct", "show"}


def test_no_path_of_the_disk_is_reached(live):
    for path in ("/../../../../etc/passwd", "/etc/passwd", "//etc/passwd", "/%2e%2e/%2e%2e/etc/passwd",
                 "/page.html", "/.", "/\\..", "/clouds/../../etc/passwd", "http://x/etc/passwd"):
        status, text = live.get(path)
        assert status in (403, 404) and "root:" not in text, path
    assert live.get("/", method="DELETE", Origin=f"http://127.0.0.1:{live.port}")[0] == 404


def test_other_pages_and_names_are_refused(live):
    own = f"http://127.0.0.1:{live.port}"
    assert live.get("/", Host="evil.example")[0] == 403
    for origin in (None, "http://evil.example", "null", f"http://127.0.0.1:{live.port + 1}"):
        headers = {"Origin": origin} if origin else {}
        assert live.get("/save", method="POST", **headers)[0] == 403
        client, answer = ask_for_page(live.port, origin=origin)
        client.close()
        assert " 403 " in answer
    client, answer = ask_for_page(live.port, origin=own)
    assert " 101 " in answer
    client.close()


def test_a_page_gets_a_cloud_for_each_wish(live):
    client, _ = ask_for_page(live.port, origin=f"http://127.0.0.1:{live.port}")
    with client:
        for _ in range(3):
            say(client, b"next")
            opcode, message = take_message(client)
            width, height, has_depth, points = struct.unpack_from("<4i", message)
            assert (opcode, width, height, has_depth) == (2, 320, 240, 1) and points > 1000
            assert len(message) == 24 + 3 * width * height
        client.settimeout(0.3)
        with pytest.raises(TimeoutError):
            client.recv(1)  # no unrequested data


def test_a_page_that_reads_slowly_gets_whole_clouds_and_delays_nobody(live):
    slow, _ = ask_for_page(live.port, origin=f"http://127.0.0.1:{live.port}")
    with slow:
        say(slow, b"next")
        taken, others = b"", 0
        while len(taken) < 10 + 24 + 3 * 320 * 240:
            taken += slow.recv(4096)
            assert taken
            begin = time.monotonic()
            others += len(newest(live)) == 24 + 3 * 320 * 240
            time.sleep(max(0, begin + 0.03 - time.monotonic()))
        assert struct.unpack(">BBQ", taken[:10]) == (0x82, 127, 24 + 3 * 320 * 240)
        assert struct.unpack_from("<3i", taken, 10) == (320, 240, 1) and others > 50
        say(slow, b"next")
        assert take_message(slow)[0] == 2
    assert live.get("/health") == (200, "ok\n")


def test_view_shows_a_scan_on_a_page(tmp_path):
    subprocess.run([PROGRAM, "simulate", tmp_path / "scan", "--camera", "96x72"], check=True,
                   capture_output=True)
    with Live(tmp_path, command=["view", tmp_path / "scan", "--web", "0", "--json"]) as view:
        assert struct.unpack_from("<3i", newest(view)) == (96, 72, 1)
        code, told = view.finish()
        assert code == 0 and told["clouds"] > 0 and told["source"].startswith("replay:")
    refused = subprocess.run([PROGRAM, "view", "--web", "0", view.words], capture_output=True, text=True)
    assert refused.returncode == 2 and "scan folders and recordings" in refused.stderr


def test_a_page_that_shows_the_phase_gets_it_too(live):
    client, _ = ask_for_page(live.port, origin=f"http://127.0.0.1:{live.port}")
    with client:
        for wish, bytes_per_pixel in ((b"next phase", 4), (b"next", 3), (b"next phase", 4)):
            say(client, wish)
            assert len(take_message(client)[1]) == 24 + bytes_per_pixel * 320 * 240


def test_save_writes_a_scan(live):
    status, folder = live.get("/save", method="POST", Origin=f"http://127.0.0.1:{live.port}")
    assert status == 200
    assert (live.words.parent / folder / "cloud.ply").exists()
    assert (live.words.parent / folder / "scan.yaml").exists()


def test_two_programs_save_into_folders_of_their_own(tmp_path):
    def save(live):
        return live.get("/save", method="POST", Origin=f"http://127.0.0.1:{live.port}")

    for name in ("one", "other"):
        (tmp_path / name).mkdir()
    flags = ("--save-to", str(tmp_path / "saved"))
    folders = []
    with Live(tmp_path / "one", *flags, size="64x48") as one, \
         Live(tmp_path / "other", *flags, size="64x48") as other, \
         concurrent.futures.ThreadPoolExecutor() as threads:
        for _ in range(3):
            for status, folder in threads.map(save, (one, other)):
                assert status == 200, folder
                folders.append(folder)
            time.sleep(1.1)  # saves come a second apart at most
    assert len(set(folders)) == 6, folders
    for folder in folders:  # with two frames for motion
        assert len(list(pathlib.Path(folder).glob("frame_*.png"))) == 4 + 2


def test_settings_are_changed_or_refused_with_why(live):
    told = live.settings()
    assert "exposure" not in told, "the virtual source is no camera"
    assert told["minimum-modulation"]["value"] == "15"
    assert told["strategy"]["choices"] == [told["strategy"]["value"]]
    points = struct.unpack_from("<4i", newest(live))[3]
    status, text = live.change("minimum-modulation=60")
    assert status == 200, text
    assert live.settings()["minimum-modulation"]["value"] == "60"
    wait_for(lambda: struct.unpack_from("<4i", newest(live))[3] < 0.9 * points)
    for wish, why in (("minimum-modulation=128", "from 0 to 127 grey levels"),
                      ("minimum-modulation=bright", "a number"), ("minimum-modulaton=20", "did you mean"),
                      ("record=perhaps", "off; on"), ("exposure=5", "no setting 'exposure'"),
                      ("nonsense", "NAME=VALUE"), ("", "NAME=VALUE"), ("\0=\xff", "no setting")):
        status, text = live.change(wish)
        assert status == 400 and why in text and "\n" not in text.strip(), (wish, text)
    with pytest.raises((ConnectionError, http.client.BadStatusLine)):
        live.change("x" * 10000)
    assert live.get("/settings", "POST", "minimum-modulation=20")[0] == 403
    assert live.get("/settings", "POST", "minimum-modulation=20", Origin="http://evil.example")[0] == 403
    assert live.settings()["minimum-modulation"]["value"] == "60"
    assert live.change("minimum-modulation=15")[0] == 200


def test_recording_is_begun_and_ended(live):
    assert live.change("record=on")[0] == 200
    wait_for(lambda: re.search(r"[1-9]\d frames", live.settings()["record"]["state"]))
    assert live.change("record=off")[0] == 200
    assert live.settings()["record"]["value"] == "off"
    recording, = live.words.parent.glob("recording-*.slip")
    assert subprocess.run([PROGRAM, "check", recording]).returncode == 0


def test_a_taken_port_and_a_kind_that_is_none_are_one_line(live):
    for sink, code, words in ((f"web:{live.port}", 1, "in use"), ("wbe:1", 2, "mcap:FILE")):
        done = subprocess.run([PROGRAM, "live", "--source", "virtual", "--camera", "64x48",
                               "--headless", "--frames", "20", "--publish", sink],
                              capture_output=True, text=True)
        assert done.returncode == code and words in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize("flags", [["--publish", "web:0"], ["--publish", "web:0.0.0.0:0"],
                                   ["--publish", "web:0", "--duration", "60"]])
def test_a_pipe_gets_the_address_at_once(flags):
    with subprocess.Popen([PROGRAM, "live", "--source", "virtual", "--world", "ideal", "--camera",
                           "64x48", "--rate", "30", "--headless", *flags],
                          stdout=subprocess.PIPE, text=True) as process:
        line = process.stdout.readline()
        process.kill()
    assert "http://" in line and ("token=" in line) == ("0.0.0.0" in flags[1])


def test_a_run_that_ends_tells_the_page(tmp_path):
    with Live(tmp_path, size="64x48") as live:
        client, _ = ask_for_page(live.port, origin=f"http://127.0.0.1:{live.port}")
        code, told = live.finish()
        assert code == 0 and told["sinks"][0]["error"] == ""
        assert client.recv(100) == b""
        client.close()


def test_npm_reads_the_mcap_file(tmp_path):
    packages = ["@mcap/core", "fzstd", "@foxglove/rosmsg", "@foxglove/rosmsg2-serialization"]
    try:
        subprocess.run(["node", "-e", ";".join(f"require('{name}')" for name in packages)],
                       check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip(f"no node, or not {', '.join(packages)} of npm where NODE_PATH says")
    with Live(tmp_path, "--frames", "60", "--motion", "0", "--publish", "mcap:clouds.mcap",
              "-o", "last.xyz", web=None) as live:
        out, _ = live.process.communicate(timeout=PATIENCE)
        assert live.process.returncode == 0, live.words.read_text()
    told = json.loads(out)["sinks"][0]
    read = subprocess.run(["node", SOURCES / "tests/publish/read_mcap.js", tmp_path / "clouds.mcap"],
                          capture_output=True, text=True)
    assert read.returncode == 0, read.stderr
    summary = json.loads(read.stdout)
    assert told["published"] >= 10 and told["error"] == ""
    published, seconds = told["published"], summary["counts"].pop("/statistics")
    frames = {summary["counts"].pop(f"/frames/{n}") for n in range(4)}
    assert summary["counts"] == dict.fromkeys(["/points", "/image", "/camera_info"], published)
    assert len(frames) == 1 and 1 <= frames.pop() <= published
    assert 1 <= seconds <= 10 and summary["attachments"] == {"scanner.yaml": True, "scan.yaml": True}
    assert summary["points"]["width"] == 320 and summary["points"]["height"] == 240
    # 60 frames are 15 cycles of four, so the run's last cloud is also the file's last.
    points = [tuple(map(float, line.split()[:3])) for line in open(tmp_path / "last.xyz")
              if not line.startswith(("#", "/"))]
    assert len(points) == summary["points"]["valid"] > 10000
    for axis in range(3):
        mean = sum(point[axis] for point in points) / len(points)
        assert summary["points"]["mean"][axis] * 1000 == pytest.approx(mean, abs=1e-3)


needs_chromium = pytest.mark.skipif(not CHROMIUM, reason="Debian's chromium is not there")


@needs_chromium
@pytest.mark.parametrize("look", [(1280, 800, "light", False), (1280, 800, "dark", False),
                                  (390, 844, "dark", True), (1280, 801, "dark", False)],
                         ids=["light", "dark", "phone", "webgl"])
def test_the_page_shows_the_cloud(live, tmp_path, look):
    pictures = pathlib.Path(os.environ.get("SLIPSTREAM_SCREENSHOTS", tmp_path))
    with Chromium() as browser:
        browser.look_like(*look[:2], phone=look[3])
        if look[1] == 801:  # pretend to have a graphics card
            browser.ask("Page.addScriptToEvaluateOnNewDocument", source="""
                WebGL2RenderingContext.prototype.getParameter = () => 'a card';""")
        browser.ask("Page.navigate", url=live.address)
        wait_for(lambda: browser.value("typeof cloud !== 'undefined' && !!cloud && !!pivot"))
        browser.value(f"useLight({str(look[2] == 'light').lower()})")
        assert browser.value("cloud.count") > 1000
        browser.value("cardAsked")
        assert browser.value("!!gl") == (look[1] == 801)
        assert browser.value("document.querySelectorAll('#stage canvas').length") == 1
        shown = "(draw(), (() => { const pen = document.createElement('canvas').getContext('2d');" \
                "Object.assign(pen.canvas, { width: canvas.width, height: canvas.height });" \
                "pen.drawImage(canvas, 0, 0);" \
                "const some = pen.getImageData(0, 0, canvas.width, canvas.height).data;" \
                "const ground = some.slice(0, 3).join(); let count = 0;" \
                "for (let i = 0; i < some.length; i += 4)" \
                " count += some.slice(i, i + 3).join() !== ground;" \
                "return count / (some.length / 4); })())"
        assert browser.value(shown) > 0.1
        wait_for(lambda: "frames captured" in browser.value("document.body.innerText"))
        browser.screenshot(pictures / f"{look[2]}-{look[0]}-{look[1]}.png")
        browser.value("at('pause').click()")
        wait_for(lambda: browser.value("new Promise(done => { const before = cloud;"
                                       "setTimeout(() => done(cloud === before), 700); })"))
        browser.value("at('pause').click()")
        wait_for(lambda: browser.value("seen.length") > 0)
        browser.value("at('picture').click()")
        assert browser.value(shown) > 0.1
        browser.value("at('phase').click()")
        assert not browser.value("pressed('picture')")
        wait_for(lambda: browser.value("cloud.phases.length") == 320 * 240)
        assert browser.value(shown) > 0.1
        browser.screenshot(pictures / f"{look[2]}-{look[0]}-{look[1]}-phase.png")
        browser.value("at('phase').click(); at('depth').click(); view.turn = 0.5; redraw()")
        assert browser.value(shown) > 0.05
        browser.screenshot(pictures / f"{look[2]}-{look[0]}-{look[1]}-depth.png")
        assert not [told for told in browser.told if "exceptionDetails" in told]
        assert browser.value("document.documentElement.scrollWidth <= innerWidth")


@needs_chromium
def test_pages_change_settings_and_show_what_others_changed(live):
    def shown(browser, name):
        return browser.value(f"typeof at === 'function' && at('set {name}') &&"
                             f" at('set {name}').value")

    def put(browser, name, value):
        browser.value(f"at('set {name}').focus(); at('set {name}').value = '{value}';"
                      f"at('set {name}').onchange()")

    with Chromium() as one, Chromium() as other:
        for browser in (one, other):
            browser.look_like(900, 700)
            browser.ask("Page.navigate", url=live.address)
            wait_for(lambda: shown(browser, "minimum-modulation") == "15")
        assert not shown(one, "exposure") and not shown(one, "strategy")
        put(one, "minimum-modulation", 40)
        wait_for(lambda: shown(other, "minimum-modulation") == "40")
        put(other, "keep-saturated", "on")
        wait_for(lambda: shown(one, "keep-saturated") == "on")
        put(one, "minimum-modulation", 500)
        wait_for(lambda: "from 0 to 127" in one.value("at('answer').textContent"))
        wait_for(lambda: shown(one, "minimum-modulation") == "40")
        assert "127" not in other.value("at('answer').textContent")
        one.value("at('record').click()")
        wait_for(lambda: other.value("pressed('record')"))
        wait_for(lambda: ".slip" in other.value("at('answer').textContent"))
        other.value("at('record').click()")
        wait_for(lambda: not one.value("pressed('record')"))
        live.change("minimum-modulation=15")
        one.value("at('set minimum-modulation').blur()")
        wait_for(lambda: shown(one, "minimum-modulation") == "15")
        one.value("at('save').click()")
        wait_for(lambda: "saved: " in one.value("at('answer').textContent"))
        for browser in (one, other):
            assert not [told for told in browser.told if "exceptionDetails" in told]
