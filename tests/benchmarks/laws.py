"""What the searched links of a panel take by each timing law, beside the bound that none goes below."""

from __future__ import annotations

from dataclasses import dataclass

from robots.machine import Machine
from robots.nc import NcProgram
from robots.nc_blend import DEVIATION_MM, TimingLaw
from robots.panel import Panel
from service.link_bound import TimeOptimalLaw
from service.programming import program_panel
from service.timing import Timing

LAWS: tuple[TimingLaw, ...] = ("s_curve", "exact_stop", "overlap")


@dataclass(frozen=True)
class SearchedLinks:
    """Of one seed. seconds: by law, along the way planned for that law. bound: along the way of `overlap`,
    its corners within the same deviation, jerk not bounded [s]. clean: whether every certificate is.
    """

    seed: int
    seconds: dict[str, float]
    bound: float
    clean: bool

    @property
    def ratio(self) -> float:
        """`overlap` over `exact_stop`."""
        return self.seconds["overlap"] / self.seconds["exact_stop"]


def searched_links(panel: Panel, machine: Machine, seed: int) -> SearchedLinks:
    """Plan a panel by every law."""
    made = {
        law: program_panel(
            panel, machine, tuple(machine.dies), seed=seed, workers=2, timing=Timing(law)
        ).program
        for law in LAWS
    }
    return SearchedLinks(
        seed,
        {law: program.summary.breakdown_s.escape for law, program in made.items()},
        _bound(made["overlap"], machine),
        all(each.verification is not None and each.verification.result == "clean" for each in made.values()),
    )


def _bound(program: NcProgram, machine: Machine) -> float:
    spans = TimeOptimalLaw(DEVIATION_MM / 1e3).spans(program, machine)
    return sum(
        end - begin
        for block, (begin, end) in zip(program.blocks, spans, strict=True)
        if block.kind == "move" and block.dynamics is not None and not block.origin.startswith("direct")
    )


def laws_table(found: list[SearchedLinks]) -> str:
    """The laws as text, one line a seed, and all seeds together."""
    lines = [" ".join(["seed", *(f"{law:>12}" for law in LAWS), "time_optimal  overlap / exact_stop"])]
    for each in found:
        times = " ".join(f"{each.seconds[law]:12.1f}" for law in LAWS)
        doubt = "" if each.clean else "  a certificate is not clean"
        lines.append(f"{each.seed:4d} {times} {each.bound:12.1f} {each.ratio:21.3f}{doubt}")
    sums = {law: sum(each.seconds[law] for each in found) for law in LAWS}
    times = " ".join(f"{sums[law]:12.1f}" for law in LAWS)
    bound = sum(each.bound for each in found)
    lines.append(f" all {times} {bound:12.1f} {sums['overlap'] / sums['exact_stop']:21.3f}")
    return "\n".join(lines)
