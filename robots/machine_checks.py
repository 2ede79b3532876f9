"""What has to agree across a machine definition: names, chains, and the layout a closed form relies on.

The checks read the raw document, so they also work where other parts of it are wrong.
"""

from collections.abc import Iterable

from robots.definition_file import CrossCheck, duplicates, select, select_names, unknown_names
from robots.errors import InputProblem
from robots.machine import CLAMPED_FOOT, DIE, FOOT, PANEL, Machine
from robots.strict_json import Document

#: The layout the closed form of `robots.riveter` holds for: axis, kind, direction, chain.
_RIVETER = (
    ("X", "prismatic", (1, 0, 0), "tool_chain"),
    ("Y", "prismatic", (0, 1, 0), "panel_chain"),
    ("Z", "prismatic", (0, 0, 1), "panel_chain"),
    ("A", "revolute", (1, 0, 0), "panel_chain"),
    ("B", "revolute", (0, 1, 0), "panel_chain"),
    ("W", "prismatic", (0, 0, 1), "tool_chain"),
    ("C", "revolute", (0, 0, 1), "tool_chain"),
)


def _names(document: Document) -> Iterable[InputProblem]:
    solids = select_names(document, "/solids/*/name")
    yield from duplicates(select_names(document, "/axes/*/name"), "axis")
    yield from duplicates(solids, "solid")
    for pointer, name in solids:
        if name in (DIE, PANEL, FOOT, CLAMPED_FOOT):
            yield InputProblem(
                pointer,
                "reserved_name",
                f"{name!r} has a meaning of its own in pairs",
                name,
                "Give the solid another name.",
            )


def _chains(document: Document) -> Iterable[InputProblem]:
    """Every axis moves something, and once."""
    joints = select_names(document, "/panel_chain/*/axis") + select_names(document, "/tool_chain/*/axis")
    axes = select_names(document, "/axes/*/name")
    yield from unknown_names(joints, [name for _, name in axes], "axis")
    yield from duplicates(joints, "chain joint")
    used = {name for _, name in joints}
    for pointer, name in axes:
        if name not in used:
            yield InputProblem(
                pointer,
                "unused_axis",
                f"axis {name!r} is in neither chain",
                name,
                "Add it to panel_chain or tool_chain, or remove the axis.",
            )


def _links(document: Document) -> Iterable[InputProblem]:
    links = [name for _, name in select_names(document, "/tool_chain/*/axis")]
    carried = select_names(document, "/solids/*/link") + select_names(document, "/foot/link")
    return unknown_names(carried, links, "link")


def _pairs(document: Document) -> Iterable[InputProblem]:
    """Pairs name solids that exist. Clearance pairs may name die solids: see `machine_problems`."""
    solids = [name for _, name in select_names(document, "/solids/*/name")]
    yield from unknown_names(select_names(document, "/self_pairs/*/*"), [*solids, FOOT, DIE], "solid")
    for pattern in ("/self_pairs/*", "/clearance/pairs/*/solids"):
        seen: set[frozenset[str]] = set()
        for pointer, pair in select(document, pattern):
            names = frozenset(name for _, name in select_names(pair, "/*"))
            if len(names) == 1:
                yield InputProblem(
                    pointer, "pair_of_one", "a pair needs two different solids", str(pair), "Name two solids."
                )
            elif names in seen:
                yield InputProblem(
                    pointer,
                    "duplicate_pair",
                    "this pair is there more than once",
                    str(pair),
                    "Keep one of them; the order of the two names does not matter.",
                )
            seen.add(names)


def _foot(document: Document) -> Iterable[InputProblem]:
    """The foot comes down to clamp."""
    lows = {
        state: low
        for state in ("open", "clamped")
        for _, extent in select(document, f"/foot/{state}/z_mm")
        if isinstance(extent, list) and extent and isinstance(low := extent[0], int | float)
    }
    if len(lows) == 2 and lows["clamped"] >= lows["open"]:
        yield InputProblem(
            "/foot/clamped/z_mm/0",
            "foot_does_not_close",
            f"the clamped foot is not below the open one at {lows['open']} mm",
            lows["clamped"],
            "Swap the two shapes or correct their heights.",
        )


def _riveter_layout(document: Document) -> Iterable[InputProblem]:
    """A definition that says "riveter" has exactly the layout of the closed form."""
    if document.get("kinematics") != "riveter":
        return
    axes = [name for _, name in select_names(document, "/axes/*/name")]
    if axes != [name for name, *_ in _RIVETER]:
        yield _mismatch("/axes", f"the axes are {' '.join(axes)}, not X Y Z A B W C in this order", axes)
        return
    for i, (name, kind, direction, _) in enumerate(_RIVETER):
        for pointer, value in select(document, "/axes/*/kind")[i : i + 1]:
            if value != kind:
                yield _mismatch(pointer, f"axis {name} is not {kind}", value)
        for pointer, value in select(document, "/axes/*/direction")[i : i + 1]:
            if value != list(direction):
                yield _mismatch(pointer, f"axis {name} does not point along {list(direction)}", value)
    yield from _riveter_chains(document)


def _riveter_chains(document: Document) -> Iterable[InputProblem]:
    for chain in ("panel_chain", "tool_chain"):
        wanted = [name for name, _, _, of in _RIVETER if of == chain]
        order = [name for _, name in select_names(document, f"/{chain}/*/axis")]
        if order != wanted:
            yield _mismatch(f"/{chain}", f"the chain is {' '.join(order)}, not {' '.join(wanted)}", order)
            continue
        for name, (pointer, offset) in zip(wanted, select(document, f"/{chain}/*/offset_mm"), strict=False):
            free = name in ("W", "C")  # the die may start at any height, on the tool axis
            if isinstance(offset, list) and any(offset[:2] if free else offset):
                yield _mismatch(pointer, f"joint {name} is not where the closed form has it", offset)


def _mismatch(pointer: str, message: str, value: object) -> InputProblem:
    return InputProblem(
        pointer, "not_a_riveter", message, str(value), 'Correct the layout, or say kinematics: "chain".'
    )


CROSS_CHECKS: tuple[CrossCheck, ...] = (_names, _chains, _links, _pairs, _foot, _riveter_layout)


def machine_problems(machine: Machine) -> list[InputProblem]:
    """What does not agree between a machine and its dies, and what only the built machine shows."""
    return [*_die_problems(machine), *_clearance_problems(machine), *_reach_problems(machine)]


def _die_problems(machine: Machine) -> Iterable[InputProblem]:
    own = {solid.name: f"/solids/{i}/name" for i, solid in enumerate(machine.solids)} | {
        FOOT: "/foot",
        CLAMPED_FOOT: "/foot",
    }
    for die in machine.dies:
        for solid in die.solids:
            if solid.name in own:
                message = f"die {die.id!r} has a solid {solid.name!r} and so has the machine"
                remedy = "Rename one of the two: reports name solids without their die."
                yield InputProblem(own[solid.name], "name_clash", message, solid.name, remedy)
        link = die.solids[0].link
        if link != machine.die_link:
            message = f"die {die.id!r} is made for link {link!r}"
            remedy = f"Use dies for the last link of the tool chain, {machine.die_link!r}."
            yield InputProblem("/tool_chain", "die_on_wrong_link", message, link, remedy)


def _clearance_problems(machine: Machine) -> Iterable[InputProblem]:
    """Clearance pairs name solids of the machine or of a die, or the panel."""
    of_dies = {name for die in machine.dies for name in die.solid_names}
    known = sorted({solid.name for solid in machine.solids} | of_dies | {FOOT, CLAMPED_FOOT, PANEL})
    for i, pair in enumerate(machine.policy.pairs):
        named = [(f"/clearance/pairs/{i}/solids/{k}", name) for k, name in enumerate(pair)]
        yield from unknown_names(named, known, "solid")


def _reach_problems(machine: Machine) -> Iterable[InputProblem]:
    if machine.kinematics != "riveter":
        return
    X, base = machine.axis("X"), float(machine.T_world_gantry[0, 3])
    if not X.lower <= base <= X.upper:
        message = "X never brings the head to the gantry's origin"
        remedy = "Put the gantry within the travel of X, in mm."
        yield InputProblem("/gantry_base_mm/0", "gantry_out_of_reach", message, base * 1000.0, remedy)
