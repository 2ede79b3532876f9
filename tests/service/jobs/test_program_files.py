"""Programs that are kept, over HTTP: their bytes, their other forms, compressed or not, known or not."""

import gzip
import hashlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import httpx
import pytest
import zstandard

from robots.nc_json import from_json
from robots.post import dialects
from service.program_forms import MEDIA_TYPES
from service.security.scopes import Scope
from service.summary import report
from tests.service.conftest import CrossingRun
from tests.service.jobs.http import DOCUMENT, SETTINGS, api, refused
from tests.service.jobs.site import Site
from tests.service.security.guarded import bearer, key_file

DECODED: Mapping[str, Callable[[bytes], bytes]] = {
    "gzip": gzip.decompress,
    "zstd": zstandard.ZstdDecompressor().decompress,
}
PLAIN = {"Accept-Encoding": "identity"}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    site = Site(tmp_path_factory.mktemp("programs"))
    yield site
    site.close()


@pytest.fixture(scope="module")
def client(place: Site) -> Iterator[httpx.Client]:
    with api(place) as client:
        yield client


@pytest.fixture(scope="module")
def program(crossing_run: CrossingRun) -> bytes:
    return crossing_run.program.read_bytes()


@pytest.fixture(scope="module")
def address(place: Site, program: bytes) -> str:
    return f"/v1/programs/{place.places.store().put(program, served=True)}"


def sent(client: httpx.Client, address: str, **headers: str) -> tuple[httpx.Response, bytes]:
    """An answer and its bytes as they were sent."""
    asked = {name.replace("_", "-"): value for name, value in headers.items()}
    with client.stream("GET", address, headers={"Accept-Encoding": "identity"} | asked) as answer:
        return answer, b"".join(answer.iter_raw())


def file_of(place: Site, address: str) -> Path:
    path = place.places.store().path(address.rpartition("/")[2])
    assert path is not None
    return path


def test_its_bytes_are_those_of_its_address(client: httpx.Client, address: str, program: bytes) -> None:
    answer, body = sent(client, address)
    assert (answer.status_code, body) == (200, program)
    assert address.endswith(hashlib.sha256(body).hexdigest())
    assert answer.headers["ETag"] == f'"{address.rpartition("/")[2]}"'
    assert answer.headers["Content-Type"] == "application/json"
    assert int(answer.headers["Content-Length"]) == len(program)
    assert "immutable" in answer.headers["Cache-Control"]
    assert "Content-Encoding" not in answer.headers
    head = client.head(address, headers=PLAIN)
    assert (head.status_code, head.content) == (200, b"")
    differ = ("date", "traceparent")
    assert {name: value for name, value in head.headers.items() if name not in differ} == {
        name: value for name, value in answer.headers.items() if name not in differ
    }


@pytest.mark.parametrize("form", ["application/json", *MEDIA_TYPES, "report"])
def test_every_form_is_the_same_in_every_encoding(
    client: httpx.Client, address: str, program: bytes, form: str
) -> None:
    path, headers = (f"{address}/report", {}) if form == "report" else (address, {"Accept": form})
    plain, body = sent(client, path, **headers)
    assert plain.headers["Content-Type"].partition(";")[0] == ("text/markdown" if form == "report" else form)
    if form == "application/json":
        assert body == program
    elif form == "report":
        assert body.decode() == report(from_json(program))
    else:
        assert body.decode() == dialects.post(from_json(program), MEDIA_TYPES[form])
    tags = {plain.headers["ETag"]}
    assert tags == {f'"{hashlib.sha256(body).hexdigest()}"'}
    for encoding, decoded in DECODED.items():
        answer, compressed = sent(client, path, **headers, Accept_Encoding=encoding)
        assert answer.headers["Content-Encoding"] == encoding
        assert int(answer.headers["Content-Length"]) == len(compressed)
        assert decoded(compressed) == body
        tags.add(answer.headers["ETag"])
        assert {"accept", "accept-encoding"} <= set(answer.headers["Vary"].lower().split(", "))
    assert len(tags) == 3  # a strong tag names bytes


def test_what_a_client_has_is_not_sent_again(client: httpx.Client, address: str) -> None:
    for path in (address, f"{address}/report"):
        for encoding in ("identity", "gzip", "zstd"):
            answer, _ = sent(client, path, Accept_Encoding=encoding)
            tag = answer.headers["ETag"]
            for known in (tag, f"W/{tag}", f'"x", {tag}', "*"):
                again, body = sent(client, path, Accept_Encoding=encoding, If_None_Match=known)
                assert (again.status_code, body) == (304, b"")
                for name in ("ETag", "Cache-Control", "Vary"):
                    assert again.headers[name] == answer.headers[name]
                assert "Content-Encoding" not in again.headers
            other, body = sent(client, path, Accept_Encoding=encoding, If_None_Match='"x", W/"y"')
            assert (other.status_code, body != b"") == (200, True)


def test_the_form_is_the_one_that_is_accepted(client: httpx.Client, address: str) -> None:
    for accept, media_type in (
        ("*/*", "application/json"),
        ("text/html, */*;q=0.1", "application/json"),
        ("text/*", "text/csv"),
        ("application/json;q=0.2, text/x-apt;q=0.3", "text/x-apt"),
        ("application/*, application/json;q=0", "application/x-ndjson"),
    ):
        assert sent(client, address, Accept=accept)[0].headers["Content-Type"].startswith(media_type)
    for accept in ("text/html", "application/json;q=0", "*/*;q=0"):
        problem = refused(client.get(address, headers={"Accept": accept}), 406, "not_acceptable")
        for media_type in ("application/json", *MEDIA_TYPES):
            assert media_type in problem["remedy"]
    listed = DOCUMENT["paths"]["/v1/programs/{sha256}"]["get"]["responses"]["200"]["content"]
    assert set(listed) == {"application/json", *MEDIA_TYPES}


def test_a_form_that_cannot_say_it_is_not_acceptable(
    client: httpx.Client, place: Site, program: bytes
) -> None:
    """Nothing uncertified is posted."""
    uncertified = program.replace(b'"result":"clean"', b'"result":"rejected"')
    assert uncertified != program
    address = f"/v1/programs/{place.places.store().put(uncertified, served=True)}"
    problem = refused(client.get(address, headers={"Accept": "text/x-fanuc30i"}), 406, "not_acceptable")
    assert "fanuc30i" in problem["detail"]
    assert sent(client, address)[1] == uncertified


def test_without_what_is_compressed_it_is_sent_as_it_is_or_not_at_all(
    client: httpx.Client, place: Site
) -> None:
    address = f"/v1/programs/{place.places.store().put(b'{}')}"
    for accepted in ("gzip, zstd", "*", "zstd;q=1, identity;q=0.1"):
        answer, body = sent(client, address, Accept_Encoding=accepted)
        assert (answer.status_code, body, "Content-Encoding" in answer.headers) == (200, b"{}", False)
    for refusing in ("gzip, identity;q=0", "gzip, *;q=0", "*;q=0", "identity;q=0"):
        refused(client.get(address, headers={"Accept-Encoding": refusing}), 406, "not_acceptable")


def test_parts_are_not_served(client: httpx.Client, address: str, program: bytes) -> None:
    """What a Range asks for may be passed over (RFC 9110, 14.2), however it is written."""
    for asked in (
        "bytes=0-9",
        "bytes=-5",
        "bytes=5-2",
        f"bytes={10**9}-",
        "bytes=x",
        "x",
        "bytes=0-0,2-2",
        "lines=1-2",
    ):
        answer, body = sent(client, address, Range=asked)
        assert (answer.status_code, body) == (200, program)
        assert answer.headers["Accept-Ranges"] == "none"


def test_what_is_not_kept_is_not_found(client: httpx.Client, address: str, place: Site) -> None:
    for path in ("", "/report"):
        refused(client.get(f"/v1/programs/{'0' * 64}{path}"), 404, "not_found")
        for sha256 in ("x", "0" * 63, "0" * 65, "A" * 64, "g" * 64, "%00" * 64):
            found = refused(client.get(f"/v1/programs/{sha256}{path}"), 422, "invalid_input")
            assert [error["pointer"] for error in found["errors"]] == ["sha256"]
        query = refused(client.get(f"{address}{path}", params={"form": "csv"}), 422, "invalid_input")
        assert [error["pointer"] for error in query["errors"]] == ["form"]
    refused(client.get(f"/v1/programs/{'0' * 64}", headers={"Accept": "text/csv"}), 404, "not_found")
    refused(client.get("/v1/programs/..%2f..%2fetc%2fpasswd"), 404, "not_found")
    refused(client.delete(address), 405, "method_not_allowed")
    assert file_of(place, address).exists()


def test_a_text_that_was_swept_is_written_again(client: httpx.Client, place: Site, program: bytes) -> None:
    moved = program.replace(b'"title":"', b'"title":"again ', 1)
    assert moved != program
    address = f"/v1/programs/{place.places.store().put(moved, served=True)}/report"
    _, first = sent(client, address)
    text = place.places.store().path(hashlib.sha256(first).hexdigest())
    assert text is not None
    text.unlink()
    assert sent(client, address)[1] == first


def test_whoever_may_read_and_has_the_address_gets_it(place: Site, address: str, program: bytes) -> None:
    """The address is a sha256 of the content: who knows it has seen it, or was told."""
    keys = key_file(place.places.data)
    plans, reads = bearer(keys.add("mes", Scope.PLAN)), bearer(keys.add("hall", Scope.READ))
    with api(place, SETTINGS, keys=keys) as client:
        assert client.get(address, headers=reads | PLAIN).content == program
        for path in (address, f"{address}/report"):
            refused(client.get(path, headers=plans), 403, "scope_missing")
            refused(client.get(path), 401, "unauthenticated")
