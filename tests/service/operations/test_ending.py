"""How the service ends: requests are answered, jobs handed back, and nobody shows a traceback."""

import json
import os
import signal
import threading
import time
from pathlib import Path

import httpx
import pytest

from tests.service.conftest import CROSSING
from tests.service.operations.running import running

PROGRAM = {"panel": json.loads(CROSSING.read_text()), "seed": 7}


def test_told_to_end_it_says_so_answers_what_is_under_way_and_leaves_nothing(tmp_path: Path) -> None:
    with running(tmp_path, "--log-format", "json") as service:
        service.until_ready()
        answers: list[httpx.Response] = []
        with service.client() as client, service.client() as prober:
            prober.get("/health/live")
            asking = threading.Thread(
                target=lambda: answers.append(client.post("/v1/programs", json=PROGRAM))
            )
            asking.start()
            time.sleep(0.05)

            os.killpg(service.process.pid, signal.SIGTERM)  # the whole group, as a terminal or systemd may

            time.sleep(0.2)
            probed = prober.get("/health/ready")
            asking.join()
        assert service.process.wait(30.0) == 0

        assert (probed.status_code, probed.json()["detail"]) == (503, "The service ends.")
        assert [answer.status_code for answer in answers] == [201]
        service.until_gone(5.0)
        lines = [json.loads(line) for line in service.said.splitlines()]  # nothing but lines of the log
        assert not {"ERROR", "CRITICAL"} & {line["level"] for line in lines}
        program = next(line for line in lines if "/v1/programs" in line["message"])
        assert (program["route"], program["status"], program["caller"]) == ("/v1/programs", 201, "local")


@pytest.mark.long
@pytest.mark.parametrize("after_s", [0.1, 0.3, 0.5, 0.8, 1.1, 1.4, 1.7, 2.0, 2.5, 3.0, 4.0])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_told_to_end_while_it_starts_nobody_shows_a_traceback(
    tmp_path: Path, after_s: float, number: signal.Signals
) -> None:
    with running(tmp_path) as service:
        service.wait_for(lambda: "http://" in service.url)
        time.sleep(after_s)

        os.killpg(service.process.pid, number)
        service.process.wait(30.0)

        service.until_gone(20.0)
        assert "Traceback" not in service.said, service.said


@pytest.mark.long
def test_told_twice_it_ends_at_once(tmp_path: Path) -> None:
    with running(tmp_path) as service:
        service.until_ready()
        service.process.send_signal(signal.SIGTERM)
        time.sleep(0.2)

        service.process.send_signal(signal.SIGTERM)

        assert service.process.wait(3.0) == 128 + signal.SIGTERM
        service.until_gone(3.0)
