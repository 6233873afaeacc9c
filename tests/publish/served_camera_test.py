"""`slipstream serve` with a GigE Vision camera; one machine can serve only one at a time."""

import signal
import subprocess

import pytest

from serve_test import Service
from web_test import PATIENCE, PROGRAM, wait_for


def test_it_goes_on_when_the_camera_goes_away(tmp_path):
    def camera():
        words = [PROGRAM, "camera", "serve", "--world", "ideal", "--camera", "64x48", "--strategy",
                 "pmp", "--steps", "4", "--rate", "60", "--write-scanner", "scanner.yaml"]
        process = subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        if not process.stdout.readline():
            pytest.skip(process.stderr.read())  # another camera is being served, or Aravis is missing
        return process

    rig = "source: aravis:127.0.0.1\nstrategy: pmp\nsteps: 4\nindexing: counted\n" \
          "scanner: scanner.yaml\npublish: web:0\n"
    served = camera()
    try:
        with Service(tmp_path, rig).wait_until_ready() as service:
            wait_for(lambda: service.statistics()["clouds"] > 5)

            def rate_is_30():  # the camera rounds the rate
                return abs(float(service.settings()["rate"]["value"]) - 30) < 0.1

            rate = service.settings()["rate"]
            assert rate["unit"] == "per s" and rate["least"] < 30 < rate["most"]
            assert service.change("rate=30")[0] == 200
            status, text = service.change(f"rate={2 * rate['most']}")
            assert status == 400 and f"to {rate['most']:g}" in text
            wait_for(rate_is_30)
            served.kill()
            served.wait()
            wait_for(lambda: "is lost; searching for it" in service.get("/health")[1])
            assert service.get("/health")[0] == 503
            wait_for(lambda: "rate" not in service.settings())
            assert service.change("min-modulation=20")[0] == 200
            served = camera()
            wait_for(lambda: service.get("/health") == (200, "ok\n"))
            before = service.statistics()["clouds"]
            wait_for(lambda: service.statistics()["clouds"] > before + 5)
            assert rate_is_30(), "it is set so again"
            assert "STATUS=camera" in service.ear.recv(1000).decode()

            # After a reload the old settings wait for the camera.
            served.kill()
            served.wait()
            wait_for(lambda: service.get("/health")[0] == 503)
            service.hang_up()
            wait_for(lambda: "trying again" in service.words.read_text())
            served = camera()
            service.wait_until_ready()
            wait_for(lambda: service.get("/health") == (200, "ok\n"))
            service.process.send_signal(signal.SIGTERM)
            assert service.process.wait(PATIENCE) == 0
    finally:
        served.kill()
