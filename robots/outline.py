"""The outline of a program: what another program is compared with or made from, without times and proofs.

Read from a file it costs a third of the whole program; what is left unread, nobody who uses an outline asks.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Annotated, Any

from robots.garbage import collection_put_off
from robots.nc import (
    BlockKind,
    NcAxes,
    NcBlock,
    NcDynamics,
    NcFastener,
    NcHeader,
    NcPolicy,
    NcProgram,
    NcSummary,
)
from robots.nc_changes import NcChanges
from robots.nc_codec import WHEN_GIVEN, decode_document
from robots.nc_json import from_json, program_sha256
from robots.strict_json import parse_document

Between = tuple[str | None, str | None]
"""Ids of the fasteners that a link leaves and leads to; None is home."""

_CERTIFICATE = b',"verification":'


@dataclass(frozen=True)
class OutlinedWay:
    """A link: where its blocks end, the last one excepted, how it was found, and the limits of its blocks."""

    inner: tuple[NcAxes, ...]
    origin: str
    dynamics: tuple[NcDynamics | None, ...] = field(compare=False)


@dataclass(eq=False)
class OutlinedPass:
    """What a program does with one die: open and clamped poses by fastener, links by their ends."""

    stations: dict[str, tuple[NcAxes, NcAxes]] = field(default_factory=dict)
    ways: dict[Between, OutlinedWay] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Outline:
    """sha256: of the program without its certificate, which names it; empty where it was not read. passes: by
    die. changes: as the program itself tells them.
    """

    sha256: str
    header: NcHeader
    policy: NcPolicy
    fasteners: tuple[NcFastener, ...]
    cycle_time_s: float
    passes: dict[str, OutlinedPass]
    changes: NcChanges | None


@dataclass(frozen=True, slots=True)
class _Block:
    kind: BlockKind
    axes: NcAxes
    die_id: str
    origin: str
    fastener_id: str | None
    dynamics: NcDynamics | None


@dataclass(frozen=True, slots=True)
class _File:
    header: NcHeader
    policy: NcPolicy
    fasteners: tuple[NcFastener, ...]
    summary: NcSummary
    blocks: tuple[_Block, ...]
    changes: Annotated[NcChanges | None, WHEN_GIVEN] = None


def outline_of(program: NcProgram) -> Outline:
    """The outline of a program that is there already; it has no hash."""
    return _outlined("", program)


@collection_put_off()
def read_outline(data: bytes) -> Outline:
    """The outline of a program's file. Raises InvalidInput.

    A file that is laid out as rivetplan writes it is named by the hash of its text, as a whole reading would.
    """
    document = parse_document(data)
    end = data.rfind(_CERTIFICATE)
    sha256 = program_sha256(from_json(data)) if end < 0 else hashlib.sha256(data[:end] + b"}").hexdigest()
    return _outlined(sha256, decode_document(_File, _only(document)))


def _only(document: Mapping[str, Any]) -> dict[str, Any]:
    """The members of a program's document that an outline has; what is of another type is left as it is."""
    wanted = {each.name for each in fields(_Block)}
    known = {each.name: document[each.name] for each in fields(_File) if each.name in document}
    blocks = known.get("blocks")
    if isinstance(blocks, list):
        known["blocks"] = [
            {name: block[name] for name in wanted & block.keys()} if isinstance(block, dict) else block
            for block in blocks
        ]
    return known


def _outlined(sha256: str, content: _File | NcProgram) -> Outline:
    passes, cycle_time = _passes(content.blocks), content.summary.cycle_time_s
    return Outline(
        sha256, content.header, content.policy, content.fasteners, cycle_time, passes, content.changes
    )


def _passes(blocks: Sequence[_Block | NcBlock]) -> dict[str, OutlinedPass]:
    """Blocks that make no sense give passes that fit nothing."""
    passes: dict[str, OutlinedPass] = {}
    here: str | None = None
    way: list[_Block | NcBlock] = []
    for block in blocks[1:]:  # the first one is the machine at rest, at home
        if block.kind == "move":
            way.append(block)
        elif block.kind in ("approach", "die_change") and way:
            leads = block.fastener_id if block.kind == "approach" else None
            this = passes.setdefault(way[-1].die_id, OutlinedPass())
            this.ways[here, leads] = _way(way)
            if leads is not None:
                this.stations[leads] = way[-1].axes, block.axes
            here, way = leads, []
    if way:
        passes.setdefault(way[-1].die_id, OutlinedPass()).ways[here, None] = _way(way)
    return passes


def _way(blocks: Sequence[_Block | NcBlock]) -> OutlinedWay:
    dynamics = tuple(block.dynamics for block in blocks)
    return OutlinedWay(tuple(block.axes for block in blocks[:-1]), blocks[0].origin, dynamics)
