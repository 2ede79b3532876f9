"""Cells that served before: a client asks for many motions along the same panel, one after another."""

from __future__ import annotations

import json
from collections import OrderedDict
from typing import Any

from robots.cell import Cell
from service.inputs import Places, gather

_MOST = 8
_LONGEST = 1_000_000
"""Characters of a panel's text; of a larger one planning takes longer than loading."""


class Cells:
    """The last few cells of a process, by what they were made from."""

    def __init__(self) -> None:
        self._cells: OrderedDict[tuple[str, str, str], Cell] = OrderedDict()

    def of(self, panel: dict[str, Any], machine: str, die: str) -> Cell:
        """Return the cell of a panel document, a machine's and a die's id. Raises InvalidInput."""
        key = json.dumps(panel, sort_keys=True), machine, die
        cell = self._cells.pop(key, None)
        if cell is None:
            inputs = gather(panel, machine, [die], Places(dies="/die"))
            cell = Cell(inputs.machine, inputs.dies[0], inputs.panel)
        if len(key[0]) <= _LONGEST:
            self._cells[key] = cell
            if len(self._cells) > _MOST:
                self._cells.popitem(last=False)
        return cell
