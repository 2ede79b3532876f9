"""The gate over real HTTP: callers, scopes, hosts, limits, headers, and what reaches the log."""

import asyncio
import logging
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.app import create_app
from service.errors import MEDIA_TYPE
from service.security.caller import Caller
from service.security.headers import HEADERS
from service.security.redaction import RedactingFormatter, redact
from service.security.scopes import PUBLIC, SCOPES, Scope, needed_scope
from service.security.settings import SecuritySettings
from tests.service.conftest import FakeEngine
from tests.service.security.guarded import KeyFile, bearer, guarded_by, key_file
from tests.service.test_http_errors import check_problem

DOCUMENT: dict[str, Any] = create_app().openapi()
OPERATIONS = {
    f"{method.upper()} {path}": operation
    for path, item in DOCUMENT["paths"].items()
    for method, operation in item.items()
}
MACHINES = "/v1/machines"


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> KeyFile:
    return key_file(tmp_path_factory.mktemp("keys"))


@pytest.fixture(scope="module")
def by_scope(keys: KeyFile) -> dict[Scope, str]:
    return {scope: keys.add(scope.value, scope) for scope in Scope}


@pytest.fixture(scope="module")
def guarded(keys: KeyFile, by_scope: dict[Scope, str]) -> Iterator[httpx.Client]:
    with guarded_by(SecuritySettings(keys=keys.path, requests_per_s=1e6, burst=10**6)) as client:
        yield client


def asked(client: httpx.Client, operation: str, **options: Any) -> httpx.Response:
    method, _, path = operation.partition(" ")
    return client.request(method, path.replace("{", "").replace("}", ""), **options)


def test_every_route_has_a_scope_or_is_public() -> None:
    assert set(OPERATIONS) | {"GET /openapi.json"} == set(SCOPES) | PUBLIC


@pytest.mark.parametrize("operation", OPERATIONS)
def test_document_says_who_may_ask(operation: str) -> None:
    described, scope = OPERATIONS[operation], needed_scope(operation)

    assert described["security"] == ([] if scope is None else [{"key": [scope.value]}])
    documented = {"421", "429"} if scope is None else {"401", "403", "421", "429"}
    assert documented <= set(described["responses"])
    assert set(DOCUMENT["components"]["securitySchemes"]) == {"key"}


def test_route_that_nobody_listed_needs_admin() -> None:
    assert needed_scope("PUT /v1/everything") is Scope.ADMIN


@pytest.mark.parametrize("operation", OPERATIONS)
def test_scopes_open_their_routes_and_no_others(
    guarded: httpx.Client, by_scope: dict[Scope, str], operation: str
) -> None:
    needed = needed_scope(operation)
    for scope, key in by_scope.items():
        response = asked(guarded, operation, headers=bearer(key))

        if needed is None or Caller("", frozenset({scope})).may(needed):
            assert response.status_code not in (
                401,
                403,
            )  # the route judges: a body that lacks, an unknown id
        else:
            body = check_problem(response, 403, "scope_missing")
            assert f"scope {needed}" in str(body["detail"])
            assert f'scope="{needed}"' in response.headers["www-authenticate"]


@pytest.mark.parametrize("operation", OPERATIONS)
def test_without_a_key_only_what_is_public_answers(guarded: httpx.Client, operation: str) -> None:
    response = asked(guarded, operation)

    if operation in PUBLIC:
        assert response.status_code == 200
    else:
        check_problem(response, 401, "unauthenticated")
        assert response.headers["www-authenticate"] == 'Bearer realm="rivetplan"'


@pytest.mark.parametrize("path", ["/", "/nowhere", "/v1", "/health", "/health/live/", "//health/live"])
def test_what_is_there_is_not_told_without_a_key(guarded: httpx.Client, path: str) -> None:
    check_problem(guarded.get(path), 401, "unauthenticated")


def test_methods_of_public_addresses_are_not_told_without_a_key(guarded: httpx.Client) -> None:
    check_problem(guarded.post("/health/live"), 401, "unauthenticated")


def test_unknown_key_and_wrong_secret_get_the_same_answer(
    guarded: httpx.Client, by_scope: dict[Scope, str]
) -> None:
    wrong_secret = by_scope[Scope.READ][:-52] + "a" * 52
    unknown = f"rvp_{'0' * 12}_{'a' * 52}"

    answers = [guarded.get(MACHINES, headers=bearer(key)) for key in (wrong_secret, unknown, "x", "y z")]

    bodies = [check_problem(answer, 401, "unauthenticated") | {"trace_id": ""} for answer in answers]
    assert all(body == bodies[0] for body in bodies)
    assert len({answer.headers["www-authenticate"] for answer in answers}) == 1


values = st.binary(max_size=120).map(lambda raw: bytes(b for b in raw if b >= 32 and b != 127).strip())


@given(prefix=st.sampled_from([b"", b"Bearer x", b"Bearer rvp_"]), value=values)
def test_no_malformed_credential_is_let_in(guarded: httpx.Client, prefix: bytes, value: bytes) -> None:
    response = guarded.get(MACHINES, headers={b"authorization": prefix + value})

    check_problem(response, 401, "unauthenticated")


@pytest.mark.parametrize("scheme", ["Basic", "Token", "Bearer Bearer", "Bearer,"])
def test_valid_key_in_another_scheme_is_not_read(
    guarded: httpx.Client, by_scope: dict[Scope, str], scheme: str
) -> None:
    headers = {"authorization": f"{scheme} {by_scope[Scope.READ]}"}

    check_problem(guarded.get(MACHINES, headers=headers), 401, "unauthenticated")


def test_key_counts_in_its_own_header_only_and_once(
    guarded: httpx.Client, by_scope: dict[Scope, str]
) -> None:
    key = by_scope[Scope.READ]
    twice = [("authorization", f"Bearer {key}")] * 2

    assert guarded.get(MACHINES, headers={"authorization": f"bearer  {key}"}).status_code == 200
    check_problem(guarded.get(MACHINES, headers={"x-api-key": key}), 401, "unauthenticated")
    check_problem(guarded.get(MACHINES, params={"api_key": key}), 401, "unauthenticated")
    check_problem(guarded.get(MACHINES, headers=twice), 401, "unauthenticated")


def test_big_body_without_a_key_is_refused_before_it_is_read(guarded: httpx.Client) -> None:
    check_problem(guarded.post("/v1/programs", content=b" " * 3_000_000), 401, "unauthenticated")


def test_keys_change_while_the_service_runs(tmp_path: Path) -> None:
    keys = key_file(tmp_path)
    with guarded_by(SecuritySettings(keys=keys.path)) as client:

        def status(key: str) -> int:
            return client.get(MACHINES, headers=bearer(key)).status_code

        assert client.get(MACHINES).status_code == 200  # of this computer, as long as there are no keys
        first = keys.add("mes", Scope.READ)
        assert client.get(MACHINES).status_code == 401
        second = keys.rotate("mes")
        assert [status(first), status(second)] == [200, 200]
        keys.remove("mes", first.split("_")[1])
        assert [status(first), status(second)] == [401, 200]
        keys.remove("mes")
        assert [status(second), client.get(MACHINES).status_code] == [401, 401]
        keys.path.unlink()
        assert client.get(MACHINES).status_code == 401  # what had keys is never open again
        keys.path.write_text("{")
        unusable = client.get(MACHINES, headers=bearer(second))
        check_problem(unusable, 503, "keys_unusable")
        assert keys.path.name not in unusable.text


HOSTS_OF_THIS_COMPUTER = ["localhost", "LOCALHOST:80", "127.0.0.1", "127.1.2.3:8000", "[::1]", "[::1]:8000"]
OTHER_HOSTS = [
    "evil.example",
    "127.0.0.1.evil.example",
    "localhost.evil.example",
    "localhost@evil.example",
    "evil.example/localhost",
    "10.0.0.1",
    "[::2]",
    "[",
    "localhost:x:y",
    "",
]


@pytest.mark.parametrize("host", HOSTS_OF_THIS_COMPUTER)
def test_this_computer_has_several_names(client: httpx.Client, host: str) -> None:
    assert client.get(MACHINES, headers={"host": host}).status_code == 200


@pytest.mark.parametrize("host", OTHER_HOSTS)
@pytest.mark.parametrize("path", [MACHINES, "/health/live", "/openapi.json"])
def test_without_keys_no_other_name_is_answered(client: httpx.Client, host: str, path: str) -> None:
    check_problem(client.get(path, headers={"host": host}), 421, "wrong_host")


def test_no_host_and_two_hosts_are_refused(client: httpx.Client) -> None:
    for head in ("HTTP/1.0\r\n", "HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n"):
        with socket.create_connection((client.base_url.host, client.base_url.port or 0)) as connection:
            connection.sendall(f"GET {MACHINES} {head}Connection: close\r\n\r\n".encode())
            with connection.makefile("rb") as answer:
                assert answer.readline().split(b" ")[1] in (b"400", b"421")


def test_names_that_are_listed_are_answered(tmp_path: Path) -> None:
    with guarded_by(SecuritySettings(allowed_hosts=("Planner.Plant",))) as client:
        assert client.get(MACHINES, headers={"host": "planner.plant:8000"}).status_code == 200
        check_problem(client.get(MACHINES, headers={"host": "other.plant"}), 421, "wrong_host")


def test_with_keys_every_name_is_answered_unless_some_are_listed(
    guarded: httpx.Client, keys: KeyFile, by_scope: dict[Scope, str]
) -> None:
    headers = bearer(by_scope[Scope.READ]) | {"host": "other.plant"}

    assert guarded.get(MACHINES, headers=headers).status_code == 200
    with guarded_by(SecuritySettings(keys=keys.path, allowed_hosts=("planner.plant",))) as client:
        check_problem(client.get(MACHINES, headers=headers), 421, "wrong_host")


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://localhost:1", "file://", "http://["]
)
def test_without_keys_a_page_of_elsewhere_may_not_ask(client: httpx.Client, origin: str) -> None:
    response = client.post("/v1/programs", json={"panel": {}}, headers={"origin": origin})

    check_problem(response, 403, "foreign_origin")


def test_page_of_the_service_itself_may_ask(client: httpx.Client) -> None:
    own = f"http://{client.base_url.netloc.decode()}"

    assert client.get(MACHINES, headers={"origin": own}).status_code == 200


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", MACHINES),
        ("GET", "/health/live"),
        ("GET", "/nowhere"),
        ("POST", "/v1/programs"),
        ("PUT", "/x"),
    ],
)
def test_every_answer_tells_browsers_what_not_to_make_of_it(
    client: httpx.Client, guarded: httpx.Client, method: str, path: str
) -> None:
    for server in (client, guarded):
        headers = server.request(method, path).headers

        assert {name: headers[name] for name in HEADERS} == HEADERS
        assert headers["cache-control"] == "no-store"
        assert "default-src 'none'" in headers["content-security-policy"]


def test_fault_of_ours_has_the_headers_too(client: httpx.Client, engine: FakeEngine) -> None:
    engine.fault = RuntimeError("x")
    try:
        response = client.post("/v1/programs", json={"panel": {}}, headers={"connection": "close"})
    finally:
        engine.fault = None

    check_problem(response, 500, "internal_error")
    assert {name: response.headers[name] for name in HEADERS} == HEADERS


def test_what_is_named_by_its_content_may_be_kept_by_who_asked(client: httpx.Client) -> None:
    response = client.post("/v1/programs", json={"panel": {}})

    assert response.headers["etag"]
    assert response.headers["cache-control"] == "private, no-cache"


def test_callers_have_limits_of_their_own(tmp_path: Path) -> None:
    keys = key_file(tmp_path)
    wild, calm = keys.add("wild", Scope.READ), keys.add("calm", Scope.READ)
    with guarded_by(SecuritySettings(keys=keys.path, requests_per_s=0.01, burst=3)) as client:
        answers = [client.get(MACHINES, headers=bearer(wild)) for _ in range(4)]

        assert [answer.status_code for answer in answers] == [200, 200, 200, 429]
        assert check_problem(answers[3], 429, "too_many_requests")["limit"] == 3
        assert 1 <= int(answers[3].headers["retry-after"]) <= 100
        assert client.get(MACHINES, headers=bearer(calm)).status_code == 200
        assert [client.get(MACHINES).status_code for _ in range(4)] == [401, 401, 401, 429]  # by address
        assert client.get("/health/live").status_code == 200  # no probe fails for it


def test_requests_of_one_caller_at_once_are_bounded() -> None:
    slow = SlowEngine()
    with guarded_by(SecuritySettings(at_once=2), slow) as client:
        threads = [
            threading.Thread(target=client.post, args=("/v1/programs",), kwargs={"json": {"panel": {}}})
            for _ in range(2)
        ]
        for thread in threads:
            thread.start()
        slow.wait_for(2)

        response = client.get(MACHINES)
        check_problem(response, 429, "too_many_requests_under_way")
        assert response.headers["retry-after"] == "1"

        slow.let_go()
        for thread in threads:
            thread.join()
        assert client.get(MACHINES).status_code == 200


class SlowEngine(FakeEngine):
    """Holds programs until it is told to let go."""

    def __init__(self) -> None:
        super().__init__()
        self._held = threading.Semaphore(0)
        self._going = threading.Event()

    async def program(self, request: Any) -> Any:
        self._held.release()
        await asyncio.to_thread(self._going.wait)
        return self._answer(request)

    def wait_for(self, count: int) -> None:
        for _ in range(count):
            assert self._held.acquire(timeout=10)

    def let_go(self) -> None:
        self._going.set()


def test_secrets_never_reach_the_log(
    guarded: httpx.Client,
    by_scope: dict[Scope, str],
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    key = by_scope[Scope.READ]
    wrong = key[:-1] + ("a" if key[-1] != "a" else "b")
    caplog.set_level(logging.DEBUG)
    caplog.set_level(logging.DEBUG, "uvicorn.access")
    monkeypatch.setattr(logging.getLogger("uvicorn.access"), "handlers", [caplog.handler])

    for each in (key, wrong):
        guarded.get(MACHINES, headers=bearer(each))
        guarded.get(f"{MACHINES}/{each}", headers=bearer(each), params={"api_key": each})
        guarded.post("/v1/programs", headers=bearer(each), json={"panel": {}, each: each})

    formatter = RedactingFormatter("%(name)s %(message)s")
    logged = [formatter.format(record) for record in caplog.records if not record.name.startswith("http")]
    assert any(line.startswith("uvicorn.access") and "[redacted]" in line for line in logged)
    assert [line for line in logged if key[-52:] in line or wrong[-52:] in line] == []


def test_secrets_are_taken_out_of_any_text() -> None:
    key = f"rvp_{'0' * 12}_{'a' * 52}"
    token = "eyJhbGciOiJSUzI1NiJ9.eyJzdWIiOiJtZXMifQ.c2lnbmF0dXJl"
    texts = [
        f"GET /v1/machines?api_key={key}&x=1",
        f"{{'authorization': 'Bearer {key}'}}",
        f"bearer {token}",
        f"token={token}",
        "Authorization: Bearer whatever-it-is",
        "rvp_mistyped",
    ]

    redacted = [redact(text) for text in texts]

    assert [text for text in redacted if "a" * 8 in text or "eyJ" in text or "whatever" in text] == []
    assert redacted[0] == f"GET /v1/machines?api_key=rvp_{'0' * 12}_[redacted]&x=1"
    assert "mistyped" not in redacted[5]
    assert redact("the programs of rivetplan") == "the programs of rivetplan"


def test_formatter_takes_secrets_out_of_tracebacks() -> None:
    key = f"rvp_{'0' * 12}_{'a' * 52}"
    try:
        raise RuntimeError(key)
    except RuntimeError as error:
        record = logging.LogRecord("x", logging.ERROR, "", 0, "it failed", (), (type(error), error, None))

    assert "a" * 52 not in RedactingFormatter().format(record)


def test_refusals_are_problems(guarded: httpx.Client) -> None:
    assert guarded.get(MACHINES).headers["content-type"] == MEDIA_TYPE
