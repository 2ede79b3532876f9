"""Interactive work while a batch is computed on the same two cores, and big bodies.

Of 200 motions each: one client alone; 20 clients at a screen, who think for a second between two motions; 20
clients that ask again at once, which is more than two cores can do in five times what one client waits.
"""

import json
import threading
import time
from pathlib import Path

import pytest

from tests.benchmarks.interactive import measured, own_blocks
from tests.service.conftest import ROOT
from tests.service.operations.running import running

pytestmark = pytest.mark.long
SHELL = json.loads((ROOT / "openapi" / "examples" / "a320_shell.json").read_text())


def test_interactive_motions_while_a_batch_is_computed() -> None:
    loads = measured(SHELL)

    assert loads.thinking.failures == loads.at_once.failures == []
    assert max(loads.thinking.longest, loads.at_once.longest) <= 2.0, loads
    assert loads.thinking_ratio <= 5.0, loads
    assert loads.at_once_ratio <= 5.0, loads
    assert loads.blocks == 0, loads


def test_bodies_of_megabytes_do_not_hold_up_the_event_loop(tmp_path: Path) -> None:
    blocks = [{"n": n, "x": 1.25 * n, "axes": {"X_mm": 0.1 * n, "Y_mm": 2.5}} for n in range(100_000)]
    body = json.dumps({"panel": SHELL, "previous_program": {"blocks": blocks}}).encode()
    assert 5e6 < len(body) < 8e6
    with running(tmp_path, "--workers", "0") as service:
        service.until_ready()
        before = own_blocks(service)
        waits: list[float] = []

        def post() -> None:
            with service.client() as client:
                headers = {"Content-Type": "application/json"}
                assert client.post("/v1/programs", content=body, headers=headers).status_code == 422

        posting = [threading.Thread(target=post) for _ in range(3)]
        for each in posting:
            each.start()
        with service.client() as client:
            while any(each.is_alive() for each in posting):
                begun = time.perf_counter()
                assert client.get("/health/live").status_code == 200
                waits.append(time.perf_counter() - begun)
                time.sleep(0.01)

        assert own_blocks(service) == before, service.said
        assert sorted(waits)[len(waits) // 2] < 0.05
