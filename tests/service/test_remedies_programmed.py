"""Remedies in whole programs: the panel with its remedy is programmed, and the verifier finds it clean."""

import pytest

from robots.access.remedies import RemedyKind
from service.programming import program_panel
from tests.robots import remedy_panels
from tests.robots.remedy_panels import RIVETER, Bench, applied, of_kind

BENCHES = {
    "near": Bench(remedy_panels.beside_a_frame(bound="long_reach"), ("long_reach",)),
    "between": Bench(remedy_panels.between_walls(), ("straight",)),
    "end": Bench(remedy_panels.behind_a_clip(), ("long_reach",)),
}


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("near", "tilt"),
        ("near", "other_die"),
        ("near", "move_fastener"),
        ("near", "narrower_die"),
        ("between", "other_die"),
        ("between", "lower_die"),
        ("end", "shift_clip"),
        ("end", "move_fastener"),
    ],
)
def test_a_remedy_applied_the_program_installs_the_fastener_and_is_clean(name: str, kind: RemedyKind) -> None:
    bench = BENCHES[name]
    without = program_panel(bench.panel, RIVETER, [RIVETER.dies[die] for die in bench.dies]).program
    assert {each.id: each.status for each in without.fasteners}[name] == "inaccessible"

    remedies = of_kind(bench.remedies(name), kind)

    assert remedies
    for remedy in remedies:
        machine, panel = applied(remedy.edit, bench)
        dies = [machine.dies[die] for die in dict.fromkeys([*bench.dies, remedy.die_id])]
        program = program_panel(panel, machine, dies).program
        done = {each.id: each for each in program.fasteners}
        assert done[name].status == "installed"
        assert done[name].die_id == remedy.die_id
        assert {each.status for each in program.fasteners} == {"installed"}
        assert program.verification is not None
        assert program.verification.result == "clean"
