"""No path and no address from a request is ever opened, whoever reads it: an audit hook watches."""

import asyncio
import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import cycle, repeat
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.types import Message

from service import tasks
from service.access_schemas import AccessibilityRequest
from service.answers import Answer
from service.app import create_app
from service.inputs import Places, gather
from service.schemas import MotionRequest, ProgramRequest
from service.verification_schemas import VerificationRequest
from tests.service.conftest import SETTINGS, FakeEngine

EXAMPLES = Path(__file__).parents[3] / "openapi" / "examples"
MARK = "planted-by-the-test"
PLANTED = (
    f"/tmp/{MARK}.json",
    f"../../{MARK}.json",
    f"file:///tmp/{MARK}.json",
    f"http://127.0.0.1:9/{MARK}",
    f"\\\\{MARK}\\share",
)
_WATCHED = {
    "open",
    "os.listdir",
    "os.scandir",
    "os.mkdir",
    "os.remove",
    "os.rename",
    "os.system",
    "os.exec",
    "os.posix_spawn",
    "shutil.copyfile",
    "glob.glob",
    "subprocess.Popen",
    "socket.connect",
    "socket.getaddrinfo",
    "socket.gethostbyname",
    "urllib.Request",
    "ctypes.dlopen",
    "import",
    "compile",
    "exec",
}
_seen: list[str] = []
_watching = False


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    if _watching and event in _WATCHED:
        _seen.append(f"{event} {arguments!r}")


sys.addaudithook(_hook)  # for good: a hook cannot be taken out again


@contextmanager
def watched() -> Iterator[list[str]]:
    """Yield what is opened, connected or run meanwhile."""
    global _watching  # noqa: PLW0603
    _seen.clear()
    _watching = True
    try:
        yield _seen
    finally:
        _watching = False


class ReadingEngine(FakeEngine):
    """Reads every request as a worker does, in this process, and leaves out what takes long."""

    async def program(self, request: ProgramRequest) -> Answer:
        gather(request.panel, request.machine, request.dies, Places())
        return self._answer(request)

    async def accessibility(self, request: AccessibilityRequest) -> Answer:
        gather(request.panel, request.machine, request.dies, Places())
        return Answer(b"{}", "")

    async def motion(self, request: MotionRequest) -> Answer:
        gather(request.panel, request.machine, [request.die], Places(dies="/die"))
        return self._answer(request)

    async def verification(self, request: VerificationRequest) -> Answer:
        return tasks.verification(request, SETTINGS)

    async def program_text(self, file: str, form: str) -> Answer:
        return tasks.program_text(file, form, SETTINGS)


APP = create_app(engine=ReadingEngine())


def ask(app: FastAPI, method: str, path: str, body: bytes = b"", query: str = "", **headers: str) -> int:
    """Send a request straight to the application, without a socket; return the status."""
    sent: list[Message] = []
    received = asyncio.Queue[Message]()
    received.put_nowait({"type": "http.request", "body": body, "more_body": False})

    async def send(message: Message) -> None:
        sent.append(message)

    fields = {"host": "localhost", "content-type": "application/json"} | headers
    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": method,
        "path": path,
        "raw_path": path.encode(),
        "query_string": query.encode(),
        "headers": [(name.replace("_", "-").encode(), value.encode()) for name, value in fields.items()],
        "client": ("127.0.0.1", 1),
        "server": ("127.0.0.1", 80),
        "scheme": "http",
    }
    asyncio.run(app(scope, received.get, send))
    return int(sent[0]["status"])


def example(name: str) -> Any:
    return json.loads((EXAMPLES / f"{name}.json").read_bytes())


CROSSING = example("crossing")
ENDS = {"start": {"fastener_id": "F1"}, "goal": {"fastener_id": "F2"}}
REQUESTS: dict[str, Any] = {
    "/v1/programs": {"panel": CROSSING, "machine": "riveter", "dies": ["straight"]},
    "/v1/motions": {"panel": CROSSING, "machine": "riveter", "die": "straight"} | ENDS,
    "/v1/accessibility": {"panel": CROSSING, "machine": "riveter", "dies": ["straight"]},
    "/v1/accessibility-areas": example("gaa_case1"),
    "/v1/accessibility-volumes": example("gav_case1"),
    "/v1/rivet-patterns": example("pattern_lap_joint"),
    "/v1/verifications": example("verification"),
}


def planted(value: Any, texts: Iterator[str], items: int) -> Iterator[Any]:
    """Yield a document once for each text in it, replaced by the next of `texts`, and with a member more.

    items: of how many items of a list the texts are replaced.
    """
    if isinstance(value, str):
        yield next(texts)
    elif isinstance(value, list):
        for place, each in enumerate(value[:items]):
            for other in planted(each, texts, items):
                yield [*value[:place], other, *value[place + 1 :]]
    elif isinstance(value, dict):
        for name, each in value.items():
            yield from (value | {name: other} for other in planted(each, texts, items))
        yield value | {next(texts): next(texts)}


def check_nothing_is_opened(path: str, texts: Iterator[str], items: int) -> None:
    usual = ask(APP, "POST", path, json.dumps(REQUESTS[path]).encode())  # what is read once is read
    assert usual in (200, 201)
    with watched() as seen:
        statuses = {
            ask(APP, "POST", path, json.dumps(body).encode())
            for body in planted(REQUESTS[path], texts, items)
        }

    assert statuses <= {200, 201, 404, 422}
    assert 422 in statuses
    assert [each for each in seen if MARK in each or each.startswith(("socket.", "subprocess."))] == []


@pytest.mark.parametrize("path", sorted(set(REQUESTS) - {"/v1/accessibility", "/v1/motions"}))
def test_nothing_a_body_names_is_opened(path: str) -> None:
    check_nothing_is_opened(path, cycle(PLANTED), 1)


@pytest.mark.long
@pytest.mark.parametrize("text", PLANTED)
@pytest.mark.parametrize("path", REQUESTS)
def test_nothing_that_any_body_names_is_opened(path: str, text: str) -> None:
    check_nothing_is_opened(path, repeat(text), 3)


@pytest.mark.parametrize("text", PLANTED)
def test_nothing_else_of_a_request_is_opened(text: str) -> None:
    header = text.replace("\\", "/")
    with watched() as seen:
        for template, item in APP.openapi()["paths"].items():
            for method in item:
                ask(APP, method.upper(), f"{template.split('{')[0]}{text}", query=f"file={text}&url={text}")
                ask(APP, method.upper(), template, authorization=header, referer=header, accept=header)
                ask(APP, method.upper(), template, host=header, origin=header, x_forwarded_host=header)
        ask(APP, "GET", text)

    assert [each for each in seen if MARK in each or each.startswith(("socket.", "subprocess."))] == []


@pytest.mark.parametrize(
    "opening",
    [
        lambda: Path(PLANTED[0]).exists() or open(PLANTED[0]),  # noqa: PTH123, SIM115
        lambda: __import__("urllib.request").request.urlopen(PLANTED[3], timeout=1),
    ],
    ids=["file", "address"],
)
def test_the_hook_sees_what_is_opened(opening: Callable[[], object]) -> None:
    with watched() as seen, pytest.raises(OSError, match=r"."):
        opening()

    assert [each for each in seen if MARK in each] != []
