"""The morning report as a page to read, on a screen, a phone or paper. It has no script and loads nothing."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterator
from datetime import datetime
from functools import cache
from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from service.batches.report_schemas import MOST_NAMED, BatchReport, NamedFasteners, PanelChange

_STYLE = files(__package__).joinpath("report.css").read_text(encoding="utf-8")
_STYLE_SHA256 = base64.b64encode(hashlib.sha256(_STYLE.encode()).digest()).decode()

_POLICY = f"default-src 'none'; style-src 'sha256-{_STYLE_SHA256}'; base-uri 'none'; form-action 'none'"
CONTENT_SECURITY_POLICY = f"{_POLICY}; frame-ancestors 'none'"
"""What a browser may do with the page: apply its one style. In a file it says so itself, but for frames."""


def page(report: BatchReport) -> bytes:
    """The report as HTML, complete in one file."""
    template = _environment().get_template("report.html.j2")
    text = template.render(report=report, style=_STYLE, policy=_POLICY)
    return text.encode("utf-8")


def sentences(change: PanelChange, most: int = MOST_NAMED) -> Iterator[str]:
    """What changed of a panel, in words. most: fasteners to name."""
    if change.kind != "changed":
        yield change.kind
        return
    found = list(_found(change, most))
    yield from found or ["other bytes"]


def _found(change: PanelChange, most: int) -> Iterator[str]:
    if change.state_then is not None:
        yield f"was {change.state_then}"
    if change.panel_file_is_another:
        yield "the panel's file is another"
    for what, which in (("gained", change.gained), ("lost", change.lost)):
        if which is not None:
            yield f"{what} {which.count}: {names(which, most)}"
    if round(change.cycle_time_s or 0.0, 1):
        yield f"cycle {change.cycle_time_s:+.1f} s"
    if round(change.clearance_mm or 0.0, 3):
        yield f"clearance {change.clearance_mm:+.3f} mm"
    if change.certificate_then is not None:
        yield f"certificate was {change.certificate_then}"


def names(named: NamedFasteners, most: int = MOST_NAMED) -> str:
    """The fasteners of a list in a line."""
    shown = named.fasteners[:most]
    more = named.count - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")


def duration(seconds: float | None) -> str:
    """A time in hours, minutes and seconds, as many as it needs."""
    if seconds is None:
        return "-"
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    hours, rest = divmod(round(seconds), 3600)
    minutes, whole = divmod(rest, 60)
    return f"{hours}:{minutes:02d}:{whole:02d} h" if hours else f"{minutes}:{whole:02d} min"


def _moment(time: datetime | None) -> str:
    return "-" if time is None else time.strftime("%Y-%m-%d %H:%M:%S UTC")


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("service.batches", "."),
        autoescape=select_autoescape(default=True, default_for_string=True, enabled_extensions=("j2",)),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"duration": duration, "moment": _moment, "sentences": sentences, "names": names}
    return environment
