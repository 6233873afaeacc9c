"""`slipstream live --publish web`: clients without a token, hostile ones, names that are not UTF-8."""

import http.client
import json
import os
import re
import signal
import socket
import struct
import subprocess
import time

import pytest

from web_test import PATIENCE, PROGRAM, Live, ask_for_page, say, take_message, wait_for


def test_others_need_the_token(tmp_path):
    with Live(tmp_path, web="web:0.0.0.0:0", size="64x48") as live:
        assert re.fullmatch(r"token=[0-9a-f]{32}", live.token())
        assert live.get("/")[0] == 200
        token, live.address = live.token(), "http://x/"
        for path in ("/", "/metrics", "/?token=", "/?token=" + "0" * 32, "/?token=" + token[6:-1]):
            assert live.get(path)[0] == 403
        origin = f"http://127.0.0.1:{live.port}"
        client, answer = ask_for_page(live.port, origin=origin)
        client.close()
        assert " 403 " in answer
        client, answer = ask_for_page(live.port, "/clouds?" + token, origin=origin)
        client.close()
        assert " 101 " in answer


def test_only_this_machine_reaches_the_ports_unless_told(tmp_path):
    with Live(tmp_path, "--publish", "tcp:0", "--save-to", "saved", size="64x48") as live:
        port = int(re.search(r"tcp://127.0.0.1:(\d+)", live.words.read_text())[1])
        for loopback in (live.port, port):  # other addresses of this machine are not listened to
            with pytest.raises(ConnectionRefusedError):
                socket.create_connection(("127.0.0.2", loopback))

        controller = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        answers = controller.makefile("rb")

        def ask(**request):
            controller.sendall(json.dumps(request).encode() + b"\n")
            return json.loads(answers.readline())

        # What it may change, and where it writes.
        for name, value in (("minimum-modulation", 128), ("save-to", str(tmp_path)), ("record", "x")):
            assert not ask(do="set", name=name, value=value)["ok"]
        assert ask(do="set", name="minimum-modulation", value=20)["ok"]
        assert ask(do="set", name="record", value="on")["ok"]
        assert ask(do="save")["folder"].startswith("saved/")
        assert {path.name for path in tmp_path.iterdir()} == {"words", "saved"}
        controller.close()


def test_a_request_has_8_kb_and_ten_seconds(tmp_path):
    with Live(tmp_path, size="64x48") as live:
        slow, begin = connect(live, b"GET / HT"), time.monotonic()
        assert live.get("/health", filler="x" * 7900)[0] == 200
        with pytest.raises((ConnectionError, http.client.BadStatusLine)):
            live.get("/health", filler="x" * 8200)
        assert slow.recv(1) == b"" and time.monotonic() > begin + 9
        slow.close()


def test_hostile_clients_harm_nobody(tmp_path):
    with Live(tmp_path, size="640x480") as live:
        origin = f"http://127.0.0.1:{live.port}"
        memory, descriptors = live.memory(), live.descriptors()
        kept, begin = [], time.monotonic()
        for _ in range(8):  # stop reading with requests pending
            client, answer = ask_for_page(live.port, origin=origin)
            assert " 101 " in answer
            for _ in range(50):
                say(client, b"next")
            kept.append(client)
        for text in (b"nonsense", b"\x00\xff", b"x" * 100, b"", b"next 4", b"next "):
            client, _ = ask_for_page(live.port, origin=origin)
            say(client, text)
            while client.recv(65536):
                pass  # until the server closes it
            client.close()
        for junk in (b"\x16\x03\x01\x02", b"GET / HTTP/9.9\r\n\r\n", os.urandom(5000), b"A" * 100000,
                     b"POST /save HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n",
                     b"GET /" + b"a" * 20000 + b" HTTP/1.1\r\n\r\n", b"\r\n" * 1000):
            client = socket.create_connection(("127.0.0.1", live.port))
            try:
                client.sendall(junk)
            except OSError:
                pass
            client.close()
        for cut in (20, 120):  # disconnect during the handshake or during a cloud
            client, _ = ask_for_page(live.port, origin=origin)
            say(client, b"next")
            client.recv(cut)
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            client.close()
        many = []
        for _ in range(100):
            client = socket.create_connection(("127.0.0.1", live.port))
            client.sendall(b"GET / HT")
            many.append(client)
        time.sleep(2)
        assert live.descriptors() < descriptors + 40
        for client in many:
            client.close()
        wait_for(lambda: "disconnected" in live.words.read_text())
        assert time.monotonic() > begin + 29, "they had 30 s to read"
        assert live.get("/health") == (200, "ok\n")
        assert live.memory() < memory + 80  # MB
        wait_for(lambda: live.descriptors() < descriptors + 4)
        before = live.statistics()["clouds"]
        wait_for(lambda: live.statistics()["clouds"] > before + 5)
        code, told = live.finish()
        words = live.words.read_text()
        assert code == 0 and told["frames"]["lost"] == 0
        assert words.count("disconnected") == 1 and "further ones are refused" not in words
        for client in kept:
            client.close()


def connect(live, text=b""):
    client = socket.create_connection(("127.0.0.1", live.port), timeout=PATIENCE)
    client.sendall(text)
    return client


@pytest.mark.parametrize("text", [b"", b"GET / HT", b"GET /health HTTP/1.1\r\nHost: x\r\n\r\n"],
                         ids=["silent", "unfinished", "without_token"])
def test_nobody_without_a_token_locks_others_out(tmp_path, text):
    with Live(tmp_path, web="web:0.0.0.0:0", size="64x48") as live:
        descriptors = live.descriptors()
        page, answer = ask_for_page(live.port, "/clouds?" + live.token(),
                                    origin=f"http://127.0.0.1:{live.port}")
        assert " 101 " in answer
        strangers = []
        for _ in range(100):
            strangers.append(connect(live, text))
            assert len(strangers) % 10 or live.get("/health") == (200, "ok\n")
        assert live.get("/")[0] == 200
        assert live.descriptors() < descriptors + 12
        say(page, b"next")
        assert take_message(page)[0] == 2
        for client in [page, *strangers]:
            client.close()


def test_health_is_answered_when_all_places_are_taken(tmp_path):
    with Live(tmp_path, size="64x48") as live:
        origin = f"http://127.0.0.1:{live.port}"
        pages = [ask_for_page(live.port, origin=origin)[0] for _ in range(32)]
        for _ in range(3):
            assert live.get("/health") == (200, "ok\n")
            assert live.get("/statistics")[0] == 503
        wait_for(lambda: "further ones are refused" in live.words.read_text())
        pages.pop().close()
        wait_for(lambda: live.get("/statistics")[0] == 200)
        for page in pages:
            page.close()


@pytest.mark.parametrize("name", [b"a\xff", b"\xc3(", b"\xed\xa0\x80"])
def test_a_path_that_is_not_utf_8_harms_no_sink(tmp_path, name):
    folder = os.path.join(os.fsencode(tmp_path), name)
    subprocess.run([PROGRAM, "simulate", folder, "--camera", "64x48", "--world", "ideal"],
                   check=True, capture_output=True)
    words, files = tmp_path / "words", os.fsencode(tmp_path)
    with subprocess.Popen([PROGRAM, "live", "--source", b"replay:" + folder, "--loop", "--rate",
                           "60", "--headless", "--publish", "web:0", "--save-to", folder,
                           "--publish", b"mcap:" + folder + b".mcap", "--json"], cwd=files,
                          stdout=subprocess.PIPE, stderr=words.open("w")) as process:
        wait_for(lambda: re.search(r"http://\S+", words.read_text(errors="replace")))
        live = Live.__new__(Live)
        live.address = re.search(r"http://\S+", words.read_text(errors="replace"))[0]
        live.port = int(re.search(r":(\d+)/", live.address)[1])
        assert live.change("record=on")[0] == 200
        for path in ("/metrics", "/statistics", "/settings"):
            assert live.get(path)[0] == 200
        assert live.get("/health") == (200, "ok\n")
        process.send_signal(signal.SIGINT)
        told = json.loads(process.communicate(timeout=PATIENCE)[0])
        assert process.returncode == 0
        assert [sink["error"] for sink in told["sinks"]] == ["", ""]
