"""One poisoned item never makes a list fail: rows as another version or a full disk left them."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
import sqlalchemy as sa

from service.jobs.database import connect
from service.jobs.model import JobState
from service.jobs.places import JobPlaces
from service.jobs.queue import DbosJobs
from service.jobs.schema import BATCHES, JOBS
from tests.contract.document import bodies
from tests.contract.site import Site, build
from tests.service.conftest import serving

_DBOS_SUCCESS = "UPDATE workflow_status SET status = 'SUCCESS', completed_at = updated_at"

#: What is written over one of the jobs.
POISON: dict[str, dict[str, object]] = {
    "problem of another version": {"problem": '{"kind": "late", "code": 7}'},
    "problem cut off": {"problem": '{"type": "urn:riv'},
    "NaN in a problem": {"problem": '{"status": NaN}'},
    "progress half there": {"phase": "planning", "done": None, "total": 3, "share": None},
    "time beyond the calendar": {"created_ms": 2**62, "started_ms": -(2**62)},
    "controls in its texts": {"title": "a\u0000b\u001b[31m\ud7ff", "job_order_id": "\u2028"},
    "kind nobody knows": {"kind": "dance", "media_type": None, "result": "nothing"},
    "trace that is none": {"trace": "x" * 1000},
}


@pytest.fixture
def kept(tmp_path: Path) -> Iterator[tuple[httpx.Client, JobPlaces]]:
    site: Site = build(tmp_path)
    with serving(site.app) as client:
        client.headers["authorization"] = f"Bearer {site.key}"
        yield client, JobPlaces.of(tmp_path, {})


@pytest.mark.parametrize("values", POISON.values(), ids=POISON)
def test_list_has_the_others_and_the_poisoned_one(
    kept: tuple[httpx.Client, JobPlaces], values: dict[str, object]
) -> None:
    client, places = kept
    made = client.post("/v1/batches", json=bodies()["/v1/batches"][0]).json()
    first, second = (each["job_id"] for each in made["programs"])
    engine = connect(places)
    with engine.begin() as connection:
        connection.execute(sa.update(JOBS).where(JOBS.c.id == first).values(values))
        connection.execute(sa.text(_DBOS_SUCCESS))
    engine.dispose()

    assert {first, second} <= {job_id for job_id, _ in listed(places)}
    for address in (made["links"]["jobs"], made["links"]["self"], made["links"]["report"], "/v1/batches"):
        response = client.get(address)
        assert response.status_code == 200, f"{address}: {response.text[:300]}"


def test_list_of_batches_has_the_poisoned_one(kept: tuple[httpx.Client, JobPlaces]) -> None:
    client, places = kept
    ids = [client.post("/v1/batches", json=bodies()["/v1/batches"][0]).json()["id"] for _ in range(2)]
    engine = connect(places)
    with engine.begin() as connection:
        poisoned = {"created_ms": 2**62, "compared_with": "nothing", "request_sha256": "gone"}
        connection.execute(sa.update(BATCHES).where(BATCHES.c.id == ids[0]).values(poisoned))
    engine.dispose()

    response = client.get("/v1/batches")

    assert response.status_code == 200, response.text
    assert {each["id"] for each in response.json()["batches"]} == set(ids)
    assert client.get(f"/v1/batches/{ids[0]}/report").status_code == 200


def listed(places: JobPlaces) -> list[tuple[str, JobState]]:
    async def ask() -> list[tuple[str, JobState]]:
        jobs = DbosJobs(places)
        await jobs.start()
        try:
            found, _ = await jobs.list(page_size=100)
        finally:
            await jobs.close()
        return [(job.id, job.state) for job in found]

    return asyncio.run(ask())
