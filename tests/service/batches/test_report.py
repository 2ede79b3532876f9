"""The morning report: sums, what changed, and a page that shows whatever people write."""

import base64
import hashlib
import html
import re
from collections.abc import Sequence
from html.parser import HTMLParser

from hypothesis import given
from hypothesis import strategies as st

from service.batches.comparison import Made
from service.batches.page import CONTENT_SECURITY_POLICY, page, sentences
from service.batches.report import put_together
from service.batches.report_schemas import MOST_NAMED, BatchReport, LeftOut, PanelChange
from tests.service.batches.made import batch, digest, failed, planned, trouble, waiting

REASONS = ("blocked", "no_travel", "too_thick")


def reported(now: Sequence[Made], then: Sequence[Made] | None = None) -> BatchReport:
    earlier = None if then is None else batch("then")
    return put_together(batch(compared_with=None if then is None else "then"), now, earlier, then or (), ())


def change(now: Made, then: Made | None) -> PanelChange:
    (panel,) = reported([now], [] if then is None else [then]).panels
    assert panel.change is not None
    return panel.change


@st.composite
def panels(draw: st.DrawFn, batch_id: str) -> list[Made]:
    found: list[Made] = []
    for number in range(1, draw(st.integers(0, 8)) + 1):
        name = draw(st.sampled_from(["A", "B", "C", ""]))
        kind = draw(st.sampled_from(["planned", "failed", "waiting"]))
        if kind == "failed":
            found.append(failed(number, name, batch=batch_id))
        elif kind == "waiting":
            found.append(waiting(number, name, batch=batch_id))
        else:
            fates = draw(st.lists(st.sampled_from(["installed", *REASONS]), max_size=40))
            ids = {f"F{index}": fate for index, fate in enumerate(fates)}
            found.append(
                planned(
                    number,
                    digest(
                        name,
                        [each for each, fate in ids.items() if fate == "installed"],
                        [(each, fate) for each, fate in ids.items() if fate != "installed"],
                        cycle_time_s=draw(st.integers(0, 10**7)) / 1e3,
                        clearance_mm=draw(
                            st.none() | st.integers(-9999, 99999).map(lambda value: value / 1e4)
                        ),
                        certificate=draw(st.sampled_from(["clean", "rejected"])),
                    ),
                    draw(st.sampled_from(["1" * 64, "2" * 64])),
                    batch=batch_id,
                    queued_s=draw(st.integers(0, 10**6)) / 1e3,
                    computed_s=draw(st.integers(0, 10**6)) / 1e3,
                )
            )
    return found


@given(now=panels("now"), then=st.none() | panels("then"))
def test_totals_are_the_sums_over_the_panels(now: list[Made], then: list[Made] | None) -> None:
    report = reported(now, then)
    totals, rows = report.totals, report.panels

    assert [panel.number for panel in rows] == list(range(1, len(now) + 1))
    states = totals.panels.model_dump()
    assert states.pop("total") == len(rows) == sum(states.values())
    for panel in rows:
        if panel.fasteners is not None:
            assert panel.fasteners.total == panel.fasteners.installed + panel.fasteners.refused
            assert panel.fasteners.refused == sum(each.count for each in panel.refusals)
    with_program = [panel for panel in rows if panel.fasteners is not None]
    for name in ("total", "installed", "refused"):
        assert getattr(totals.fasteners, name) == sum(getattr(each.fasteners, name) for each in with_program)
    assert totals.fasteners.refused == sum(each.count for each in totals.refusals)
    for name in ("cycle_time_s", "queued_s", "computed_s"):
        summed = sum(getattr(each, name) or 0.0 for each in rows)
        assert abs(getattr(totals, name) - summed) < 1e-3
    assert totals.certificates.clean + totals.certificates.rejected == len(with_program)
    least = [each.worst_clearance.mm for each in rows if each.worst_clearance is not None]
    assert (totals.worst_clearance and totals.worst_clearance.mm) == (min(least) if least else None)
    assert (totals.changes is None) == (then is None)
    if totals.changes is not None and then is not None:
        kinds = [each.change.kind for each in rows if each.change is not None]
        assert len(kinds) == totals.panels.total - totals.panels.queued
        assert totals.changes.new + totals.changes.unchanged + totals.changes.changed == len(kinds)
        assert totals.changes.gone == len(report.gone)
        assert len(then) - len(report.gone) == len(now) - sum(
            1 for number, made in enumerate(now) if not _has(then, now, number, made)
        )
    page(report)


def _has(then: list[Made], now: list[Made], number: int, made: Made) -> bool:
    """Whether an earlier batch has a panel of this name, or one more where this is one more."""
    before = sum(each.entry.name == made.entry.name for each in now[:number])
    return sum(each.entry.name == made.entry.name for each in then) > before


@given(panels("now"))
def test_the_same_again_is_unchanged_everywhere(now: list[Made]) -> None:
    final = [each for each in now if each.entry.job is not None and each.entry.job.state.is_final]
    report = reported(final, final)

    assert {each.change.kind for each in report.panels if each.change} <= {"unchanged"}
    assert report.totals.changes is not None
    assert report.totals.changes.unchanged == len(final)
    assert report.gone == ()


def test_it_is_finished_when_every_panel_is() -> None:
    done = planned(1, digest("A"), "1" * 64, computed_s=7.0)
    assert reported([done, waiting(2, "B")]).finished_at is None
    later = reported([done, planned(2, digest("B"), "1" * 64, computed_s=9.0)])
    assert later.elapsed_s == 5.0 + 9.0


def test_a_panel_that_fails_is_told_beside_the_others() -> None:
    report = reported([planned(1, digest("A"), "1" * 64), failed(2, "B"), planned(3, digest("C"), "2" * 64)])

    assert [panel.state for panel in report.panels] == ["succeeded", "failed", "succeeded"]
    assert report.panels[1].problem is not None
    assert report.panels[1].fasteners is None
    assert report.totals.panels.failed == 1
    assert report.totals.fasteners.installed == 6
    assert b"/panel/skin: field required" in page(report)


def test_what_became_better_or_worse_is_named() -> None:
    then = digest(
        "A", ["F1", "F2"], [("F3", "blocked"), ("F4", "blocked")], cycle_time_s=20.0, clearance_mm=2.0
    )
    now = digest(
        "A", ["F1", "F3", "F5"], [("F2", "blocked"), ("F4", "blocked")], cycle_time_s=26.5, clearance_mm=1.25
    )
    found = change(planned(1, now, "2" * 64), planned(1, then, "1" * 64, batch="then"))

    assert found.kind == "changed"
    assert found.gained is not None
    assert found.gained.fasteners == ("F3", "F5")
    assert found.lost is not None
    assert found.lost.fasteners == ("F2",)
    assert (found.cycle_time_s, found.clearance_mm) == (6.5, -0.75)
    assert list(sentences(found)) == [
        "gained 2: F3, F5", "lost 1: F2", "cycle +6.5 s", "clearance -0.750 mm",
    ]  # fmt: skip


def test_other_bytes_and_other_fates_are_changes() -> None:
    then = planned(1, digest("A"), "1" * 64, batch="then")
    assert list(sentences(change(planned(1, digest("A"), "2" * 64), then))) == ["other bytes"]
    rejected = change(planned(1, digest("A", certificate="rejected"), "2" * 64), then)
    assert list(sentences(rejected)) == ["certificate was clean"]
    assert list(sentences(change(failed(1, "A"), then))) == ["was succeeded"]
    assert change(failed(1, "A"), failed(1, "A", batch="then")).kind == "unchanged"
    again = failed(1, "A", trouble=trouble("other"))
    assert change(again, failed(1, "A", batch="then")).kind == "changed"
    assert change(failed(1, "A"), None).kind == "new"


def test_lists_of_fasteners_are_cut_and_counted() -> None:
    ids = [f"F{number}" for number in range(50)]
    (panel,) = reported([planned(1, digest("A", [], [(each, "blocked") for each in ids]), "1" * 64)]).panels

    assert [(each.count, len(each.fasteners)) for each in panel.refusals] == [(50, MOST_NAMED)]
    assert b"F19 and 30 more" in page(
        reported([planned(1, digest("A", [], [(each, "x") for each in ids]), "1" * 64)])
    )


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: set[str] = set()
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.add(tag)
        assert not [name for name, _ in attrs if name.startswith("on") or name in ("src", "href", "style")]
        if tag not in ("meta", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@given(
    st.sampled_from(
        ["<script>alert(1)</script>", '"><img src=x onerror=alert(1)>', "{{ 7 * 7 }}", "</style>"]
    )
)
def test_what_people_write_is_text_on_the_page(evil: str) -> None:
    now = [
        planned(1, digest(evil, [], [(evil, evil)], title=evil), "1" * 64),
        failed(2, evil, title=evil, trouble=trouble(evil)),
    ]
    report = put_together(
        batch(compared_with="then", title=evil), now, batch("then", title=evil),
        [failed(1, evil + "gone", batch="then")], [LeftOut(file=evil, why=evil)],
    )  # fmt: skip
    text = page(report).decode()
    tags = _Tags()
    tags.feed(text)

    assert tags.open == []
    assert tags.seen.isdisjoint({"script", "img", "iframe", "object", "embed", "link", "base", "form"})
    assert tags.text.count(evil) >= 10
    stated = re.search('http-equiv="Content-Security-Policy" content="([^"]*)"', text)
    assert stated is not None
    assert CONTENT_SECURITY_POLICY.startswith(html.unescape(stated[1]))
    style = re.search("<style>(.*)</style>", text, re.S)
    assert style is not None
    sha256 = base64.b64encode(hashlib.sha256(style[1].encode()).digest()).decode()
    assert f"style-src 'sha256-{sha256}'" in CONTENT_SECURITY_POLICY
    assert not re.search(r"url\(|@import|https?:", text)
