"""Lines of the log: text for people, or one JSON object a line; without keys and tokens in either.

Every process of a service writes to standard error in one way: the first one says which, its children find it
in their environment.
"""

from __future__ import annotations

import logging
import os
import sys
from datetime import UTC, datetime
from enum import StrEnum
from typing import Any

from pythonjsonlogger.json import JsonFormatter

from service.security.redaction import redact
from service.trace import bound

ENVIRONMENT = "RIVETPLAN_LOG_FORMAT"
"""Environment variable that says how a process writes its log."""
_SHORT = {"trace_id": "trace", "span": None}
_QUIET = ("dbos", "alembic")
"""Libraries whose notes nobody needs; their warnings are ours."""


class LogFormat(StrEnum):
    """How lines of the log are written."""

    TEXT = "text"
    JSON = "json"


def configure(how: LogFormat | None = None) -> None:
    """Write this process's log, and that of the processes it starts, to standard error.

    how: None as the environment says, text where it does not.
    """
    if how is None:
        how = LogFormat(os.environ.get(ENVIRONMENT) or LogFormat.TEXT)
    os.environ[ENVIRONMENT] = how.value
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(_JsonLines() if how is LogFormat.JSON else _TextLines())
    handler.addFilter(_add_context)
    logging.basicConfig(level=logging.INFO, handlers=[handler], force=True)
    logging.captureWarnings(True)
    for name in _QUIET:
        logging.getLogger(name).setLevel(logging.WARNING)
    logging.getLogger("dbos").addHandler(logging.NullHandler())  # else it writes lines of its own


def _add_context(record: logging.LogRecord) -> bool:
    """Put beside a line what is worked on; what the line itself says of it is kept."""
    for name, value in bound().items():
        if not hasattr(record, name):
            setattr(record, name, value)
    return True


def _utc(record: logging.LogRecord) -> str:
    when = datetime.fromtimestamp(record.created, UTC)
    return when.isoformat(timespec="milliseconds").replace("+00:00", "Z")


class _TextLines(logging.Formatter):
    """`2026-11-23T07:00:00.000Z INFO rivetplan.jobs: the message [job=... trace=...]`"""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(name)s: %(message)s%(context)s")

    def format(self, record: logging.LogRecord) -> str:
        known = {_SHORT.get(name, name): getattr(record, name, value) for name, value in bound().items()}
        known.pop(None, None)
        record.context = "".join(f" {name}={value}" for name, value in known.items())
        return redact(super().format(record))

    def formatTime(self, record: logging.LogRecord, datefmt: str | None = None) -> str:  # noqa: ARG002
        return _utc(record)


class _JsonLines(JsonFormatter):
    """One object a line: time (UTC), level, logger, message; trace_id, span, job, caller where known."""

    def __init__(self) -> None:
        super().__init__("%(message)s", json_ensure_ascii=True)

    def add_fields(
        self, log_data: dict[str, Any], record: logging.LogRecord, message_dict: dict[str, Any]
    ) -> None:
        log_data |= {"time": _utc(record), "level": record.levelname, "logger": record.name}
        super().add_fields(log_data, record, message_dict)
        for name in ("taskName", "color_message", "context"):
            log_data.pop(name, None)

    def process_log_record(self, log_data: dict[str, Any]) -> dict[str, Any]:
        return {name: redact(value) if isinstance(value, str) else value for name, value in log_data.items()}
