"""A kept program in another form: a dialect's text, one JSON object a line, or a report."""

from __future__ import annotations

import hashlib
from pathlib import Path

from robots.nc_json import from_json
from robots.post import dialects
from service.answers import Answer
from service.program_forms import REPORT
from service.settings import Settings
from service.summary import report


def program_text(file: str, form: str, _settings: Settings) -> Answer:
    """Return the program in a file as a text. form: a dialect, or REPORT.

    Raises InvalidInput where the dialect cannot say what the program says.
    """
    program = from_json(Path(file).read_bytes())
    body = (report(program) if form == REPORT else dialects.post(program, form)).encode()
    return Answer(body, hashlib.sha256(body).hexdigest())
