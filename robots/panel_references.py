"""Names in a panel definition: unique where they name, known where they refer. No geometry here."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from robots.panel_reading import PART_LISTS, Findings, Reading
from robots.panel_schema import RowDefinition
from robots.schema_problems import Keys
from robots.sections import WEBBED

#: Lists whose entries can carry a row.
ROW_LISTS = ("doublers", "straps", "stringers", "frames", "clips")
PLATE_LISTS = ("doublers", "straps")


def check_names(reading: Reading, processes: Collection[str], findings: Findings) -> None:
    """Find duplicate ids, references to what is not there, and unknown processes."""
    _check_duplicates(reading, findings)
    _check_skin(reading, findings)
    _check_parts(reading, findings)
    _check_fasteners(reading, processes, findings)
    for position, row in enumerate(reading.definition.rows):
        _check_row(reading, reading.keys("rows", position), row, findings)


def part_entries(reading: Reading) -> Iterator[tuple[str, Keys, str]]:
    """All parts but the skin as (list, place of the entry, id), in part order."""
    for name in PART_LISTS:
        for position, part in enumerate(getattr(reading.definition, name)):
            yield name, reading.keys(name, position), part.id


def _check_duplicates(reading: Reading, findings: Findings) -> None:
    skin = reading.definition.skin
    parts: list[tuple[Keys, str]] = [] if skin is None else [(("skin", "id"), skin.id)]
    parts += [((*keys, "id"), part_id) for _, keys, part_id in part_entries(reading)]
    fasteners: list[tuple[Keys, str]] = [
        (reading.keys(name, position, "id"), entry.id)
        for name in ("fasteners", "rows")
        for position, entry in enumerate(getattr(reading.definition, name))
    ]
    for what, named in (("part", parts), ("fastener or row", fasteners)):
        seen: set[str] = set()
        for keys, name in named:
            if name in seen:
                message = f"the {what} id {name!r} is used more than once"
                findings.add(keys, "duplicate_id", message, name, f"Give every {what} an id of its own.")
            seen.add(name)


def _check_skin(reading: Reading, findings: Findings) -> None:
    """There is one skin: of sizes, and then members may lie on it, or of meshes, and then none may."""
    definition = reading.definition
    meshed = [i for i, mesh in enumerate(definition.meshes) if mesh.kind == "skin"]
    if definition.skin is not None:
        for position in meshed:
            keys = reading.keys("meshes", position, "kind")
            message = "the panel has a skin already"
            findings.add(keys, "two_skins", message, "skin", "Remove `skin`, or give this mesh another kind.")
        return
    if not meshed:
        if not reading.index_lost("meshes"):
            remedy = "Add `skin` with its sizes, or a mesh of the kind skin."
            findings.add(("skin",), "missing_field", "the panel has no skin", None, remedy)
        return
    for name in (*ROW_LISTS, "rows"):
        if getattr(definition, name):
            message = f"{name} are laid out on a skin that is given by its sizes; this one is a mesh"
            remedy = "Give these parts as meshes too, and fasteners by their points."
            findings.add(reading.keys(name, 0), "needs_sized_skin", message, name, remedy)


def _check_parts(reading: Reading, findings: Findings) -> None:
    definition = reading.definition
    frames = {frame.id: frame for frame in definition.frames}
    plates = [plate.id for name in PLATE_LISTS for plate in getattr(definition, name)]
    for name in PART_LISTS:
        for position, part in enumerate(getattr(definition, name)):
            for attribute, known in (
                ("section", [*definition.sections]),
                ("on", plates),
                ("frame", [*frames]),
            ):
                referred = getattr(part, attribute, None)
                if referred is not None:
                    keys = reading.keys(name, position, attribute)
                    _check_reference(reading, keys, attribute, referred, known, findings)
    for position, clip in enumerate(definition.clips):
        section = definition.sections.get(clip.section)
        if section is not None and section.profile != "L":
            message = f"the section {clip.section!r} of a clip is a {section.profile}, not an L"
            remedy = "Use an L: its foot lies on the skin, its web on the frame."
            findings.add(
                reading.keys("clips", position, "section"), "wrong_section", message, clip.section, remedy
            )
        frame = frames.get(clip.frame)
        webbed = None if frame is None else definition.sections.get(frame.section)
        if webbed is not None and webbed.profile not in WEBBED:
            message = f"the frame {clip.frame!r} is a {webbed.profile}: it has no single web to fix a clip to"
            remedy = f"Use a frame of one of the sections {', '.join(sorted(WEBBED))}."
            findings.add(
                reading.keys("clips", position, "frame"), "wrong_section", message, clip.frame, remedy
            )


def _check_fasteners(reading: Reading, processes: Collection[str], findings: Findings) -> None:
    for name in ("fasteners", "rows"):
        for position, entry in enumerate(getattr(reading.definition, name)):
            if entry.process not in processes:
                message = f"there is no process {entry.process!r}"
                remedy = f"Use one of: {', '.join(sorted(processes)) or '(none)'}."
                keys = reading.keys(name, position, "process")
                findings.add(keys, "unknown_process", message, entry.process, remedy)
    if not reading.definition.fasteners and not reading.definition.rows and reading.complete_fasteners:
        findings.add(
            (), "empty_panel", "the panel has no fasteners", None, "Add fasteners or rows of fasteners."
        )


def _check_row(reading: Reading, keys: Keys, row: RowDefinition, findings: Findings) -> None:
    definition = reading.definition
    kinds = {part.id: name for name in ROW_LISTS for part in getattr(definition, name)}
    for i, member in enumerate(row.members):
        _check_reference(reading, (*keys, "members", i), "member", member, [*kinds], findings)
        if member in row.members[:i]:
            message = f"the row names the member {member!r} twice"
            findings.add((*keys, "members", i), "duplicate_id", message, member, "Name each member once.")
    if row.pitch_mm is None and row.count is None:
        findings.add(
            keys, "missing_field", "the row has neither a pitch nor a count", None, "Add pitch_mm or count."
        )
    for i, zone in enumerate(row.skip_zones):
        if zone.from_mm >= zone.to_mm:
            message = "the zone ends before it begins"
            findings.add(
                (*keys, "skip_zones", i), "empty_interval", message, zone.to_mm, "Let from_mm be the smaller."
            )
    plates = [kinds[member] in PLATE_LISTS for member in row.members if member in kinds]
    if plates and all(plates) and row.direction is None:
        message = "a row on a doubler or strap needs a direction"
        findings.add(
            (*keys, "direction"), "missing_field", message, None, "Say x (along the length) or arc (across)."
        )
    if plates and not any(plates):
        for attribute in ("direction", "offset_mm"):
            value = getattr(row, attribute)
            if value is not None:
                message = f"{attribute} is for doublers and straps; this member has rivet lines of its own"
                findings.add((*keys, attribute), "unknown_field", message, value, "Remove the field.")
    if any(plates) and not all(plates):
        message = "the row mixes doublers or straps with other members"
        findings.add((*keys, "members"), "mixed_members", message, None, "Make two rows of it.")


def _check_reference(
    reading: Reading, keys: Keys, what: str, name: str, known: Collection[str], findings: Findings
) -> None:
    if name in known or reading.is_lost(name):
        return
    noun = "doubler or strap" if what == "on" else what
    some = ", ".join(sorted(known)[:12]) + (" ..." if len(known) > 12 else "")
    message = f"there is no {noun} {name!r}"
    findings.add(keys, f"unknown_{noun.replace(' ', '_')}", message, name, f"Use one of: {some or '(none)'}.")
