"""Clients that ask for motions: what they wait for, measured where they are."""

from __future__ import annotations

import asyncio
import json
import random
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from tests.service.conftest import CROSSING

CLIENTS, EACH = 20, 10
_FASTENERS = ("SR.S2.001", "SR.S2.002", "SR.S2.003")


@dataclass
class Waits:
    """How long answers took [s], and how many were none."""

    seconds: list[float] = field(default_factory=list)
    failures: list[int] = field(default_factory=list)

    @property
    def median(self) -> float:
        """[s]"""
        return statistics.median(self.seconds)

    @property
    def p99(self) -> float:
        """[s] All but one in a hundred were answered by then."""
        return sorted(self.seconds)[max(0, round(0.99 * len(self.seconds)) - 1)]

    @property
    def longest(self) -> float:
        """[s]"""
        return max(self.seconds)

    def __str__(self) -> str:
        ms = [f"{1e3 * each:.1f}" for each in (self.median, self.p99, self.longest)]
        return f"{len(self.seconds)} answers, median {ms[0]} ms, p99 {ms[1]} ms, longest {ms[2]} ms"


def ask(port: int, *, clients: int = CLIENTS, each: int = EACH, think_s: float = 0.0) -> Waits:
    """Let `clients` ask at once, each for `each` motions, no two the same.

    think_s: [s], how long a client waits on average before it asks again; 0: not at all.
    """
    waits = Waits()

    async def all_of_them() -> None:
        await asyncio.gather(*(_client(port, number, each, think_s, waits) for number in range(clients)))

    asyncio.run(all_of_them())
    return waits


async def _client(port: int, number: int, each: int, think_s: float, waits: Waits) -> None:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    thinks = random.Random(number)
    for place in range(each):
        await asyncio.sleep(2.0 * think_s * thinks.random())
        begun = time.perf_counter()
        status = await _asked(reader, writer, _motion(1000 * number + place))
        waits.seconds.append(time.perf_counter() - begun)
        if status != 200:
            waits.failures.append(status)
    writer.close()


async def _asked(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, body: bytes) -> int:
    """The status of an answer; it is read whole."""
    head = f"POST /v1/motions HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: {len(body)}\r\n"
    writer.write(head.encode() + b"Content-Type: application/json\r\n\r\n" + body)
    status, *lines = (await reader.readuntil(b"\r\n\r\n")).lower().split(b"\r\n")
    (length,) = (line.split(b":")[1] for line in lines if line.startswith(b"content-length"))
    await reader.readexactly(int(length))
    return int(status.split()[1])


def _motion(seed: int) -> bytes:
    start, goal = _two(seed, _FASTENERS)
    ends = {"start": {"fastener_id": start}, "goal": {"fastener_id": goal}}
    return json.dumps({"panel": _PANEL, "die": "straight", "seed": seed, **ends}).encode()


def _two(seed: int, of: Sequence[str]) -> tuple[str, str]:
    return of[seed % len(of)], of[(seed + 1) % len(of)]


_PANEL = json.loads(CROSSING.read_text())
