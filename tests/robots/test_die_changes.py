"""Dies made of those of the library: whole, mounted, checked, and with less in the way than before."""

import json
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.access.die_changes import DieChanges
from robots.dies import TIP, Die
from robots.machine_checks import machine_problems
from robots.machine_file import load_machine
from robots.solids import Cylinder, Prism, Solid
from robots.tooling_file import load_dies

RIVETER = load_machine("riveter")
LIBRARY = RIVETER.dies
CHANGES = DieChanges(LIBRARY)
dies = st.sampled_from(LIBRARY.ids)
amounts = st.integers(1, 200).map(lambda tenths: tenths / 10.0)


def extent(solid: Solid) -> tuple[float, float]:
    """Lowest and highest point [m] in the die frame."""
    if isinstance(solid.shape, Cylinder):
        z = float(solid.T_link_solid[2, 3])
        return z - solid.shape.length / 2.0, z + solid.shape.length / 2.0
    return float(solid.vertices[:, 2].min()), float(solid.vertices[:, 2].max())


def built(definition: dict[str, object]) -> Die:
    die = CHANGES.built(definition)
    assert die is not None
    return die


@settings(max_examples=40, deadline=None)
@given(dies, amounts)
def test_a_lower_die_has_its_tip_where_it_was_its_mounting_too_and_all_else_lower(
    die_id: str, by_mm: float
) -> None:
    before, after = LIBRARY[die_id], built(CHANGES.lowered(die_id, by_mm))

    assert after.mounting_z == before.mounting_z
    assert after.axisymmetric == before.axisymmetric
    assert after.solid_names == before.solid_names
    for old, new in zip(before.solids, after.solids, strict=True):
        (low, high), (lowered, top) = extent(old), extent(new)
        stays = low == pytest.approx(before.mounting_z)
        assert lowered == pytest.approx(low if stays else low - by_mm / 1000.0, abs=1e-9)
        assert top == pytest.approx(0.0 if old.name == TIP else high - by_mm / 1000.0, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(dies, st.floats(0.01, 0.5), st.data())
def test_a_narrower_solid_lies_within_what_it_was_and_the_others_are_the_same(
    die_id: str, share: float, data: st.DataObject
) -> None:
    widths = CHANGES.widths(die_id)
    name = data.draw(st.sampled_from(sorted(widths)))
    by_mm = max(0.1, round(share * widths[name], 1))
    before, after = LIBRARY[die_id], built(CHANGES.narrowed(die_id, name, by_mm))

    assert TIP not in widths
    for old, new in zip(before.solids, after.solids, strict=True):
        assert extent(old) == extent(new)
        assert new.T_link_solid == pytest.approx(old.T_link_solid)
        less = by_mm / 1000.0 if old.name == name else 0.0
        if isinstance(old.shape, Cylinder) and isinstance(new.shape, Cylinder):
            assert 2.0 * (old.shape.radius - new.shape.radius) == pytest.approx(less, abs=1e-9)
        if isinstance(old.shape, Prism) and isinstance(new.shape, Prism):
            assert old.shape.width - new.shape.width == pytest.approx(less, abs=1e-9)
            assert (old.shape.profile == new.shape.profile).all()


@settings(max_examples=20, deadline=None)
@given(dies, amounts)
def test_the_library_takes_the_changed_die_as_one_more_and_the_machine_the_library(
    die_id: str, by_mm: float
) -> None:
    document = json.loads(LIBRARY.definition)
    definitions = [CHANGES.lowered(die_id, by_mm)]
    definitions += [CHANGES.narrowed(die_id, name, 0.3) for name in CHANGES.widths(die_id)]

    library = load_dies(json.dumps({**document, "dies": [*document["dies"], *definitions]}).encode())

    assert library.ids == (*LIBRARY.ids, *(definition["id"] for definition in definitions))
    assert machine_problems(replace(RIVETER, dies=library)) == []


def test_a_changed_die_never_takes_the_name_of_another() -> None:
    document = json.loads(LIBRARY.definition)
    again = {**CHANGES.lowered("j20", 3.2), "title": "made before"}
    changes = DieChanges(load_dies(json.dumps({**document, "dies": [*document["dies"], again]}).encode()))

    assert again["id"] == "j20_low3_2"
    assert changes.lowered("j20", 3.2)["id"] == "j20_low3_2_2"
    assert changes.lowered("j20", 3.0)["id"] == "j20_low3"


def test_names_and_titles_stay_within_their_length() -> None:
    document = json.loads(LIBRARY.definition)
    long = {**document["dies"][0], "id": "d" * 64, "title": "t" * 500}
    changes = DieChanges(load_dies(json.dumps({**document, "dies": [long]}).encode()))

    for definition in (changes.lowered("d" * 64, 1.5), changes.narrowed("d" * 64, "shank", 1.5)):
        assert changes.built(definition) is not None
        assert len(definition["id"]) <= 64


def test_what_the_checks_of_a_library_refuse_is_no_die() -> None:
    assert CHANGES.built(CHANGES.lowered("straight", 240.0)) is None
    assert CHANGES.built(CHANGES.narrowed("j20", "neck", 22.0)) is None
