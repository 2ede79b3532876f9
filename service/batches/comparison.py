"""What became of a panel since an earlier batch."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from service.batches.digest import Digest
from service.batches.model import Entry
from service.batches.report_schemas import MOST_NAMED, NamedFasteners, PanelChange

Key = tuple[str, int]
"""A panel's name in a batch, and which one of that name it is."""


@dataclass(frozen=True)
class Made:
    """An entry with the digest of its program; None where it has none."""

    entry: Entry
    digest: Digest | None

    @property
    def result(self) -> str | None:
        """The sha256 of the program's file."""
        return self.entry.job.result if self.entry.job is not None else None


def keyed(made: Iterable[Made]) -> Iterator[tuple[Key, Made]]:
    """Panels by what finds them in another batch."""
    seen: Counter[str] = Counter()
    for each in made:
        name = each.entry.name
        yield (name, seen[name]), each
        seen[name] += 1


def change_of(then: Made | None, now: Made) -> PanelChange | None:
    """What changed of a panel; None while its job is not final."""
    job = now.entry.job
    if job is None or not job.state.is_final:
        return None
    if then is None:
        return PanelChange(kind="new")
    before = then.entry.job
    state_then = before.state if before is not None and before.state is not job.state else None
    if then.digest is None or now.digest is None:
        same = before is not None and (before.state, before.problem) == (job.state, job.problem)
        same = same and then.result == now.result
        return PanelChange(kind="unchanged" if same else "changed", state_then=state_then)
    if then.result == now.result:
        return PanelChange(
            kind="unchanged", cycle_time_s=0.0, clearance_mm=_clearance(then.digest, now.digest)
        )
    return _difference(then.digest, now.digest)


def _difference(then: Digest, now: Digest) -> PanelChange:
    installed_then, installed_now = set(then.installed), set(now.installed)
    other_certificate = then.certificate != now.certificate
    return PanelChange(
        kind="changed",
        gained=named([each for each in now.installed if each not in installed_then]),
        lost=named([each for each in then.installed if each not in installed_now]),
        cycle_time_s=round(now.cycle_time_s - then.cycle_time_s, 6),
        clearance_mm=_clearance(then, now),
        certificate_then=(then.certificate or "none") if other_certificate else None,
        panel_file_is_another=then.panel_sha256 != now.panel_sha256,
    )


def named(ids: Sequence[str]) -> NamedFasteners | None:
    """Fasteners by their ids; None where there are none."""
    return NamedFasteners(count=len(ids), fasteners=tuple(ids[:MOST_NAMED])) if ids else None


def _clearance(then: Digest, now: Digest) -> float | None:
    if then.clearance is None or now.clearance is None:
        return None
    return round(now.clearance.mm - then.clearance.mm, 4)
