"""Artefacts whose files are not what they were: a damaged disk may cost an answer, and never alters one."""

import hashlib
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest

from service.jobs.artefacts import Store
from service.jobs.model import Encoding
from tests.service.conftest import CrossingRun
from tests.service.jobs.http import ASYNC, ORDER, api, refused, succeeds
from tests.service.jobs.site import Site

Damage = Callable[[bytes], bytes]
SUFFIXES: dict[Encoding, str] = {"identity": "", "zstd": ".zst", "gzip": ".gz"}
DAMAGES: dict[str, Damage] = {
    "shorter": lambda content: content[: len(content) // 2],
    "empty": lambda _content: b"",
    "longer": lambda content: content + b"}",
    "altered": lambda content: content[:-9] + bytes([content[-9] ^ 1]) + content[-8:],
    "another": lambda content: bytes(len(content)),
}
damaged = pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)


@pytest.fixture
def place(tmp_path: Path) -> Iterator[Site]:
    site = Site(tmp_path)
    yield site
    site.close()


@pytest.fixture
def client(place: Site) -> Iterator[httpx.Client]:
    with api(place) as client:
        yield client


def spoil(place: Site, sha256: str, encoding: Encoding, damage: Damage) -> None:
    path = place.places.store().path(sha256, encoding)
    assert path is not None
    path.write_bytes(damage(path.read_bytes()))


def fetched(client: httpx.Client, address: str, encoding: str) -> httpx.Response:
    return client.get(address, headers={"Accept-Encoding": encoding})


@damaged
@pytest.mark.parametrize("encoding", SUFFIXES)
def test_what_is_damaged_is_not_whole(tmp_path: Path, encoding: Encoding, damage: Damage) -> None:
    content = b"a program, " * 1000
    store = Store(tmp_path)
    sha256 = store.put(content, served=True)
    path = store.path(sha256, encoding)
    assert path is not None
    assert store.is_whole(sha256, encoding)
    path.write_bytes(damage(path.read_bytes()))
    assert not store.is_whole(sha256, encoding)
    assert all(store.is_whole(sha256, each) for each in SUFFIXES if each != encoding)
    store.put(content, served=True)
    assert store.is_whole(sha256, encoding)


def test_what_is_not_there_is_not_whole(tmp_path: Path) -> None:
    store = Store(tmp_path)
    sha256 = store.put(b"a request")
    assert [store.is_whole(sha256, each) for each in SUFFIXES] == [True, False, False]
    assert not store.is_whole(hashlib.sha256(b"another").hexdigest())


@damaged
def test_a_damaged_program_is_not_served_until_it_is_made_again(
    place: Site, client: httpx.Client, crossing_run: CrossingRun, damage: Damage
) -> None:
    program = crossing_run.program.read_bytes()
    sha256 = place.places.store().put(program, served=True)
    address = f"/v1/programs/{sha256}"
    assert fetched(client, address, "identity").content == program  # and is known to be whole
    spoil(place, sha256, "identity", damage)
    refused(fetched(client, address, "identity"), 404, "not_found")
    assert fetched(client, address, "gzip").content == program
    for encoding in ("zstd", "gzip"):
        spoil(place, sha256, encoding, damage)
    refused(fetched(client, address, "zstd, gzip"), 404, "not_found")
    place.places.store().put(program, served=True)
    for encoding in SUFFIXES:
        assert fetched(client, address, encoding).content == program


def test_no_text_is_written_of_a_damaged_program(
    place: Site, client: httpx.Client, crossing_run: CrossingRun
) -> None:
    program = crossing_run.program.read_bytes()
    sha256 = place.places.store().put(program, served=True)
    spoil(place, sha256, "identity", lambda content: content.replace(b"0", b"1", 1))
    refused(client.get(f"/v1/programs/{sha256}/report"), 404, "not_found")


def test_a_damaged_answer_of_a_job_is_not_served(place: Site, client: httpx.Client) -> None:
    job = client.post("/v1/programs", json=ORDER, headers=ASYNC).json()
    sha256 = succeeds(place, job["id"], b'{"answer": 1}')
    result = f"/v1/jobs/{job['id']}/result"
    assert fetched(client, result, "identity").json() == {"answer": 1}
    spoil(place, sha256, "identity", lambda content: content.replace(b"1", b"2"))
    refused(fetched(client, result, "identity"), 404, "not_found")
