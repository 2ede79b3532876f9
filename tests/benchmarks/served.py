"""Bodies of megabytes over HTTP: a program that is fetched, and orders that are refused."""

from __future__ import annotations

import gzip
import itertools
import json
import re
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import zstandard

from service.jobs.places import JobPlaces
from tests.benchmarks.interactive import own_blocks
from tests.benchmarks.statistics import aligned
from tests.service.operations.running import Service, running

_PROGRAM_BYTES = 15_000_000
_AT_ONCE = 1_000
_FETCHES = 20
_POSTERS = 3
_SENT_BLOCKS = 100_000
_LOOK_S = 0.01
_PLANNING_S = 120.0
_ROUTE = 'rivetplan_http_request_seconds_{}{{method="GET",route="/v1/programs/{{sha256}}"}}'
_DECODED: dict[str, Callable[[bytes], bytes]] = {
    "identity": bytes,
    "gzip": gzip.decompress,
    "zstd": zstandard.decompress,
}


@dataclass(frozen=True)
class Fetched:
    """encoding: of the answer. size: [byte], as sent. server_s: [s], the service's own mean time for one."""

    encoding: str
    size: int
    server_s: float


@dataclass(frozen=True)
class Bodies:
    """fetched: a program of 15 MB in every encoding. sent: [byte], an order that is refused, three at once.

    waits: [s], of others meanwhile, for /health/live. blocks: how often the event loop was late by over 50 ms
    because of what the service itself did.
    """

    fetched: list[Fetched]
    sent: int
    waits: list[float]
    blocks: int


def measured(large: dict[str, object], small: dict[str, object]) -> Bodies:
    """Measure a service of one's own. large: panel whose program is made longer; small: of orders refused."""
    with tempfile.TemporaryDirectory() as directory, running(Path(directory)) as service:
        service.until_ready()
        before = own_blocks(service)
        program = _lengthened(_planned(service, large))
        sha256 = JobPlaces.of(service.data, {}).store().put(program, served=True)
        fetched = [_fetched(service, sha256, program, encoding) for encoding in _DECODED]
        sent, waits = _sent(service, small)
        return Bodies(fetched, sent, waits, own_blocks(service) - before)


def table(bodies: Bodies) -> str:
    """The figures side by side."""
    rows = [["15 MB program as", "MB sent", "ms of the server"]]
    rows += [
        [each.encoding, f"{each.size / 1e6:.1f}", f"{1e3 * each.server_s:.1f}"] for each in bodies.fetched
    ]
    return aligned(rows)


def _planned(service: Service, panel: dict[str, object]) -> dict[str, Any]:
    with service.client() as client:
        order = {"panel": panel, "seed": 7}
        job = client.post("/v1/programs", json=order, headers={"Prefer": "respond-async"}).json()
        until = time.monotonic() + _PLANNING_S
        while job["state"] in ("queued", "running") and time.monotonic() < until:
            time.sleep(0.2)
            job = client.get(job["links"]["self"]).json()
        program: dict[str, Any] = client.get(job["links"]["result"]).json()
        return program


def _lengthened(program: dict[str, Any]) -> bytes:
    """As many blocks, again from the first one after the last, as make it large enough."""
    again = itertools.cycle(program["blocks"])
    longer, text = program, b""
    while len(text) < _PROGRAM_BYTES:
        longer = longer | {"blocks": longer["blocks"] + list(itertools.islice(again, _AT_ONCE))}
        text = json.dumps(longer, separators=(",", ":")).encode()
    return text


def _fetched(service: Service, sha256: str, program: bytes, encoding: str) -> Fetched:
    with service.client() as client:
        headers = {"Accept-Encoding": encoding}
        count, seconds = _seconds(service)
        for _ in range(_FETCHES):
            with client.stream("GET", f"/v1/programs/{sha256}", headers=headers) as answer:
                raw = b"".join(answer.iter_raw())
            assert answer.status_code == 200
            assert answer.headers.get("Content-Encoding", "identity") == encoding
        assert _DECODED[encoding](raw) == program
        more, later = _seconds(service)
        return Fetched(encoding, len(raw), (later - seconds) / (more - count))


def _seconds(service: Service) -> tuple[int, float]:
    """How many programs were fetched, and the service's own time for them [s]."""
    with service.client() as client:
        text = client.get("/metrics").text

    def of(what: str) -> float:
        found = re.search(re.escape(_ROUTE.format(what)) + r" (\S+)", text)
        return float(found[1]) if found else 0.0

    return int(of("count")), of("sum")


def _sent(service: Service, panel: dict[str, object]) -> tuple[int, list[float]]:
    """Send large orders that are refused; others look meanwhile whether the service lives."""
    blocks = [{"n": n, "x": 1.25 * n, "axes": {"X_mm": 0.1 * n, "Y_mm": 2.5}} for n in range(_SENT_BLOCKS)]
    body = json.dumps({"panel": panel, "previous_program": {"blocks": blocks}}).encode()

    def post() -> None:
        with service.client() as client:
            headers = {"Content-Type": "application/json"}
            assert client.post("/v1/programs", content=body, headers=headers).status_code == 422

    posting = [threading.Thread(target=post) for _ in range(_POSTERS)]
    waits = []
    for each in posting:
        each.start()
    with service.client() as client:
        while any(each.is_alive() for each in posting):
            begun = time.perf_counter()
            assert client.get("/health/live").status_code == 200
            waits.append(time.perf_counter() - begun)
            time.sleep(_LOOK_S)
    return len(body), waits
