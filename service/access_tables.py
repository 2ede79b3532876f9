"""The accessibility of a panel as tables for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from service.access_schemas import (
    AccessOverview,
    AccessRemedy,
    AccessShare,
    FastenerAccessibility,
    JoiningShares,
    PanelAccessibility,
)
from service.summary import ACCESS_CLASSES, Row
from service.terminal import print_rows, print_table

_MOST = 10
"""Inaccessible fasteners in the table; the report has all of them."""

_WORDS = "Accessible (over 80 %), Limited accessibility (50 to 80 %), Not accessible (under 50 %)"
_JOININGS = {"structure_to_skin": "structure to skin", "skin_to_skin": "skin to skin"}


def print_accessibility(title: str, report: PanelAccessibility, *, whole: bool) -> None:
    """Print what the fasteners come to, and those that are not reached with reason and best remedy.

    whole: print also the parts that are reached everywhere, and every fastener that is not.
    """
    summary = report.summary
    print_rows(title, _summary_rows(summary))
    head = ("die", "reaches", "at the default angle", "turned", "taken for")
    counts = [(each.reached, each.direct, each.rotated, each.chosen) for each in summary.dies]
    dies = zip((each.die for each in summary.dies), counts, strict=True)
    print_table("dies", head, [(die, *map(str, each)) for die, each in dies])
    kinds = [("panel", summary.panel), *((each.kind, each) for each in summary.by_kind)]
    rows = [(kind, *_joining_cells(shares)) for kind, shares in kinds]
    print_table("joining", ("part", *_JOININGS.values()), rows)
    _print_parts(summary, whole=whole)
    _print_inaccessible(report, whole=whole)


def _print_parts(summary: AccessOverview, *, whole: bool) -> None:
    parts = [each for each in summary.by_part if whole or each.share.accessible < each.share.total]
    if parts:
        head = ("part", "kind", "joining", "accessible", "percentage", "in words")
        rows = [(each.part, each.kind, _JOININGS[each.joining], *_share_cells(each.share)) for each in parts]
        print_table("parts", head, rows)


def _print_inaccessible(report: PanelAccessibility, *, whole: bool) -> None:
    refused = [each for each in report.fasteners if each.status == "inaccessible"]
    if refused:
        searched = report.remedies.searched
        title = f"not accessible (remedies were searched for {searched} of {len(refused)})"
        print_rows(title, _refusal_rows(refused, len(refused) if whole else _MOST))


def _summary_rows(summary: AccessOverview) -> Iterator[Row]:
    yield "fasteners", f"{summary.total}"
    yield "  direct", f"{summary.direct}"
    yield "  with the die turned", f"{summary.rotated}"
    yield "  with another die", f"{summary.other_die}"
    yield "  inaccessible", f"{summary.inaccessible}"
    yield "percentage", _percent(summary.percent)
    yield "status", summary.status
    yield "class", ACCESS_CLASSES[summary.access_class]
    yield "words below", _WORDS


def _joining_cells(shares: JoiningShares) -> Iterator[str]:
    for share in (shares.structure_to_skin, shares.skin_to_skin):
        yield "-" if share is None else f"{share.word} ({share.accessible} of {share.total})"


def _share_cells(share: AccessShare) -> tuple[str, ...]:
    return f"{share.accessible} of {share.total}", _percent(share.percent), share.word or "-"


def _percent(percent: float | None) -> str:
    return "-" if percent is None else f"{percent:.2f} %"


def _best(remedies: Sequence[AccessRemedy]) -> str:
    if not remedies:
        return "none was found within the limits"
    return remedies[0].text + (f" (the best of {len(remedies)})" if len(remedies) > 1 else "")


def _refusal_rows(refused: Sequence[FastenerAccessibility], most: int) -> Iterator[Row]:
    for each in refused[:most]:
        yield each.id, "-" if each.reason is None else each.reason.text
        if each.remedies is not None:
            yield "  remedy", _best(each.remedies.found)
    if len(refused) > most:
        yield "...", f"{len(refused) - most} more; --all shows them, and --out writes them"
