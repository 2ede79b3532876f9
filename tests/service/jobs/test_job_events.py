"""The changes of a job as server-sent events; no worker runs here."""

import asyncio
import json
import time
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass, field
from typing import Any

import httpx
import pytest

from service import job_events as job_events_module
from service.job_events import job_events
from service.jobs import queue
from service.jobs.model import Job, NewJob
from service.jobs.queue import DbosJobs
from service.jobs.schema import JOBS
from tests.service.jobs.http import api, becomes, order, succeeds
from tests.service.jobs.site import LONGEST_S, Site

pytestmark = pytest.mark.parametrize("site", ["sqlite"], indirect=True)


class Watched(DbosJobs):
    """Jobs that know how many read their changes."""

    readers = 0

    async def watch(self, job_id: str) -> AsyncIterator[Job]:
        self.readers += 1
        try:
            async for job in super().watch(job_id):
                yield job
        finally:
            self.readers -= 1


@dataclass
class Event:
    """One event, or a comment: what the HTML Living Standard, 9.2.6, makes of lines."""

    fields: dict[str, str] = field(default_factory=dict)
    comment: str | None = None

    @property
    def job(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.fields["data"])
        return found


def events(answer: httpx.Response) -> Iterator[Event]:
    """The events of a stream as they come; nothing but whole ones."""
    event = Event()
    for line in answer.iter_lines():
        if not line:
            yield event
            event = Event()
        elif line.startswith(":"):
            event.comment = line[1:].strip()
        else:
            name, colon, value = line.partition(": ")
            assert colon
            assert name not in event.fields
            event.fields[name] = value
    assert event == Event(), "the stream ends within an event"


@pytest.fixture
def jobs(site: Site, monkeypatch: pytest.MonkeyPatch) -> Watched:
    monkeypatch.setattr(queue, "_LOOK_S", 0.02)
    return Watched(site.places)


@pytest.fixture
def client(site: Site, jobs: Watched) -> Iterator[httpx.Client]:
    with api(site, jobs=jobs) as client:
        yield client


def test_every_change_is_an_event_and_the_last_is_final(
    client: httpx.Client, site: Site, jobs: Watched
) -> None:
    job = order(client)
    with client.stream("GET", job["links"]["events"]) as answer:
        assert answer.headers["Content-Type"] == "text/event-stream; charset=utf-8"
        assert answer.headers["Cache-Control"] == "no-store"
        following = events(answer)
        seen = [next(following)]
        assert seen[0].job == job
        for done in (1, 2):
            becomes(site, job["id"], "PENDING", phase="plan", done=done, total=4, share=done / 4)
            seen.append(next(following))
            assert (seen[-1].job["state"], seen[-1].job["progress"]["done"]) == ("running", done)
            with site.engine.begin() as connection:  # what is not shown is no change
                connection.execute(JOBS.update().where(JOBS.c.id == job["id"]).values(spent_s=float(done)))
            time.sleep(0.2)
        sha256 = succeeds(site, job["id"], b"{}\n")
        seen += following  # it ends by itself
    assert seen[-1].job == client.get(job["links"]["self"]).json()
    assert seen[-1].job["links"]["result"] == f"/v1/programs/{sha256}"
    assert all(set(event.fields) == {"id", "event", "data"} for event in seen)
    assert {event.fields["event"] for event in seen} == {"job"}
    assert len({event.fields["id"] for event in seen}) == len(seen)
    assert jobs.readers == 0


def test_who_comes_back_is_told_what_is_new(
    client: httpx.Client, site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(job_events_module, "KEEP_ALIVE_S", 0.1)
    job = order(client)

    def follow(last: str | None) -> Iterator[Event]:
        headers = {} if last is None else {"Last-Event-ID": last}
        with client.stream("GET", job["links"]["events"], headers=headers) as answer:
            yield from events(answer)

    first = next(follow(None))
    assert next(follow("0" * 16)).fields == first.fields  # it was told something else
    following = follow(first.fields["id"])
    for _ in range(2):
        nothing = next(following)
        assert nothing.fields == {}
        assert nothing.comment
    becomes(site, job["id"], "CANCELLED")
    rest = [event for event in following if event.fields]
    assert [event.job["state"] for event in rest] == ["cancelled"]
    assert [event.fields for event in follow(first.fields["id"])] == [rest[0].fields]
    assert list(follow(rest[0].fields["id"])) == []


def test_a_reader_who_leaves_leaves_nothing(client: httpx.Client, jobs: Watched, site: Site) -> None:
    job = order(client)
    for _ in range(3):
        with client.stream("GET", job["links"]["events"]) as answer:
            following = events(answer)  # left, and not closed, by who goes away
            next(following)
            assert jobs.readers == 1
        site.wait_for(lambda: jobs.readers == 0)
    head = client.head(job["links"]["events"])
    assert (head.status_code, head.content) == (200, b"")
    site.wait_for(lambda: jobs.readers == 0)
    assert client.get(job["links"]["self"]).json() == job


def test_the_stream_ends_with_the_service(site: Site, jobs: Watched) -> None:
    async def follow() -> list[str]:
        await jobs.start()
        leaving = asyncio.Event()
        stream = job_events(jobs, (await jobs.submit(new)).id, leaving, None)
        told = [await anext(stream)]
        asyncio.get_running_loop().call_later(0.05, leaving.set)
        begin = time.monotonic()
        told += [text async for text in stream]
        assert time.monotonic() - begin < min(job_events_module.KEEP_ALIVE_S, LONGEST_S)
        assert jobs.readers == 0
        assert asyncio.all_tasks() == {asyncio.current_task()}
        await jobs.close()
        return told

    new = NewJob("program", b"{}", "test")
    first, *rest = asyncio.run(follow())
    assert first.startswith("id: ")
    assert all(text.startswith(":") for text in rest)
    assert all(text.endswith("\n\n") for text in (first, *rest))
