"""The log: one object a line where wanted, what is worked on in every line, and no secrets."""

import json
import logging
import subprocess
import sys
import time
from typing import Any

import pytest

from service.logs import LogFormat

SECRET = "rvp_0123456789ab_c2VjcmV0LXNlY3JldA"
SCRIPT = """
import logging
from service.logs import LogFormat, configure
from service.trace import Trace, bind, enter
configure(LogFormat(%r))
log = logging.getLogger("rivetplan.test")
log.info("before")
enter(Trace.of("00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"))
bind(caller="key:mes")
log.warning('he said "Bearer %s\\\\" twice', extra={"status": 201, "note": "%s"})
try:
    raise ValueError("the key is %s")
except ValueError:
    log.exception("it failed")
logging.getLogger("dbos").info("not ours")
logging.getLogger("dbos").warning("theirs")
"""


def written(how: LogFormat) -> list[str]:
    script = SCRIPT % (how.value, SECRET, SECRET, SECRET)
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert SECRET[17:] not in run.stderr
    return run.stderr.splitlines()


def test_json_is_one_object_a_line_and_says_what_is_worked_on() -> None:
    lines: list[dict[str, Any]] = [json.loads(line) for line in written(LogFormat.JSON)]

    before, warned, failed, theirs = lines
    assert before["message"] == "before"
    assert "trace_id" not in before
    assert before["time"].endswith("Z")
    assert (warned["level"], warned["logger"], warned["status"]) == ("WARNING", "rivetplan.test", 201)
    assert warned["message"].startswith('he said "Bearer rvp_0123456789ab_[redacted]')
    for line in (warned, failed):
        assert line["trace_id"] == "4bf92f3577b34da6a3ce929d0e0e4736"
        assert line["caller"] == "key:mes"
    assert "ValueError" in failed["exc_info"]
    assert theirs["logger"] == "dbos"


def test_text_says_the_same_to_people() -> None:
    before, warned, *_ = written(LogFormat.TEXT)

    assert before.endswith("Z INFO rivetplan.test: before")
    assert warned.endswith(" trace=4bf92f3577b34da6a3ce929d0e0e4736 caller=key:mes")


def _access(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [record.getMessage() for record in caplog.records if record.name == "rivetplan.access"]


def test_the_access_log_has_templates_and_nothing_of_the_client(
    client: Any, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.DEBUG, "rivetplan.access"):
        client.get("/v1/machines/nope?key=hidden-in-query")
        client.get("/hidden-in-path")
        client.request("HIDDEN", "/v1/machines")
        client.post("/v1/motions", content=b'{"hidden": "in body"}')
        until = time.monotonic() + 10.0
        while len(lines := _access(caplog)) < 4 and time.monotonic() < until:  # written after the answer
            time.sleep(0.01)

    assert [line.split()[:3] for line in lines] == [
        ["GET", "/v1/machines/{machine_id}", "422"],
        ["GET", "none", "404"],
        ["other", "/v1/machines", "405"],
        ["POST", "/v1/motions", "415"],
    ]
    assert not any("hidden" in line.lower() for line in lines)
