import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robots.sections import PROFILES, TOPPED, Profile, Section


def section(profile: Profile, height: float = 0.04, foot: float = 0.03, t: float = 0.002) -> Section:
    return Section(profile, height, foot, t, top=0.024 if profile in TOPPED else None)


profiles = st.sampled_from(PROFILES)


@st.composite
def sections(draw: st.DrawFn) -> Section:
    profile = draw(profiles)
    t = draw(st.floats(0.0005, 0.004))
    made = Section(
        profile,
        height=draw(st.floats(0.01, 0.15)),
        foot=draw(st.floats(0.01, 0.06)),
        thickness=t,
        top=draw(st.floats(0.008, 0.06)) if profile in TOPPED else None,
        mirrored=draw(st.booleans()),
    )
    assume(not made.faults())
    return made


#: Area by what the section is made of: flanges at full width, webs between them.
AREAS = {
    "Z": lambda s, t: s.foot * t + s.top * t + (s.height - 2 * t) * t,
    "C": lambda s, t: s.foot * t + s.top * t + (s.height - 2 * t) * t,
    "I": lambda s, t: s.foot * t + s.top * t + (s.height - 2 * t) * t,
    "J": lambda s, t: s.foot * t + s.top * t + (s.height - 2 * t) * t,
    "L": lambda s, t: s.foot * t + (s.height - t) * t,
    "T": lambda s, t: s.foot * t + (s.height - t) * t,
    "U": lambda s, t: s.foot * t + 2 * (s.height - t) * t,
    "hat": lambda s, t: 2 * s.foot * t + s.top * t + 2 * (s.height - 2 * t) * t,
}
WIDTHS = {
    "Z": lambda s: s.foot + s.top - s.thickness,
    "C": lambda s: max(s.foot, s.top),
    "L": lambda s: s.foot,
    "U": lambda s: s.foot,
    "T": lambda s: s.foot,
    "I": lambda s: max(s.foot, s.top),
    "J": lambda s: max(0.5 * s.foot, s.top - 0.5 * s.thickness) + 0.5 * s.foot,
    "hat": lambda s: s.top + 2 * (s.foot - s.thickness),
}


@given(sections())
def test_area_is_that_of_flanges_and_webs(made: Section) -> None:
    sides = np.diff(made.plates(), axis=1)[:, 0]

    assert (sides > 0.0).all()
    assert sides.prod(axis=1).sum() == pytest.approx(AREAS[made.profile](made, made.thickness))


@given(sections())
def test_plates_lie_in_the_profile_and_nowhere_in_each_other(made: Section) -> None:
    plates = made.plates()

    assert plates[..., 1].min() == 0.0
    assert plates[..., 1].max() == pytest.approx(made.height)
    assert np.ptp(plates[..., 0]) == pytest.approx(WIDTHS[made.profile](made))
    for a, b in itertools.combinations(plates, 2):
        overlap = np.minimum(a[1], b[1]) - np.maximum(a[0], b[0])
        assert overlap.min() <= 1e-15


@given(sections())
def test_plates_hang_together(made: Section) -> None:
    plates = made.plates()
    linked = {0}
    for _ in plates:
        for i, j in itertools.product(list(linked), range(len(plates))):
            gap = np.maximum(plates[i][0], plates[j][0]) - np.minimum(plates[i][1], plates[j][1])
            if (gap <= 1e-12).all() and (gap < -1e-6).any():
                linked.add(j)

    assert linked == set(range(len(plates)))


@given(sections())
def test_rivet_lines_are_on_the_foot_and_clear_of_the_web(made: Section) -> None:
    feet, uprights = made.feet(), made.uprights()

    assert [line for line, _ in feet] == sorted(made.lines(), key=[line for line, _ in feet].index)
    for line, plate in feet:
        assert plate[0, 0] < line < plate[1, 0]
        assert plate[1, 1] == made.thickness
    for line in made.lines():
        assert not any(low[0] < line < high[0] and low[1] < 1.5 * made.thickness for low, high in uprights)


@given(sections())
def test_feet_and_uprights_are_all_of_the_section(made: Section) -> None:
    def area(plates: list[np.ndarray]) -> float:
        return sum(float(np.prod(plate[1] - plate[0])) for plate in plates)

    parts = [plate for _, plate in made.feet()] + list(made.uprights())

    assert area(parts) == pytest.approx(area(list(made.plates())))


@given(sections())
def test_mirroring_turns_everything_round(made: Section) -> None:
    other = replace(made, mirrored=not made.mirrored)

    assert np.allclose(np.sort(made.plates()[..., 0]), np.sort(-other.plates()[..., 0]))
    assert made.lines() == tuple(-s for s in other.lines())


def test_stringer_of_the_shell_has_its_edge_distance() -> None:
    z = Section("Z", 0.030, 0.022, 0.0016, top=0.022, line=0.0124)

    (line,) = z.lines()

    assert line - 0.5 * z.thickness == pytest.approx(0.0124)  # from the web's face
    assert z.foot_edges()[1] - line == pytest.approx(0.008)  # 2 D to the edge


@pytest.mark.parametrize("profile", PROFILES)
def test_sound_sections_have_no_faults(profile: Profile) -> None:
    assert section(profile).faults() == []


@pytest.mark.parametrize(
    ("made", "field"),
    [
        (Section("Z", 0.003, 0.02, 0.0016, top=0.02), "height"),
        (Section("L", 0.0015, 0.02, 0.0016), "height"),
        (Section("L", 0.03, 0.0015, 0.0016), "foot"),
        (Section("U", 0.03, 0.003, 0.0016), "foot"),
        (Section("Z", 0.03, 0.02, 0.0016), "top"),
        (Section("L", 0.03, 0.02, 0.0016, top=0.02), "top"),
        (Section("C", 0.03, 0.02, 0.0016, top=0.001), "top"),
        (Section("L", 0.03, 0.02, 0.0016, line=0.0185), "line"),
        (Section("U", 0.03, 0.02, 0.0016, line=0.005), "line"),
        (Section("T", 0.03, 0.02, 0.0016, line=0.0095), "line"),
    ],
)
def test_impossible_sizes_are_named(made: Section, field: str) -> None:
    assert [name for name, _ in made.faults()] == [field]
