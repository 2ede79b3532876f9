"""What the rivets come to: counts, percentage, status and class (Dakdouk 2016, 3.5 and Tables 6-1, 6-2)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from planners.accessibility.reach import RivetReach

AccessStatus = Literal["Accessible", "Has some limitations"]
AccessClass = Literal["accessible", "modify_tool", "crowded"]


@dataclass(frozen=True)
class AccessSummary:
    """Counts of rivets; `accomplished` includes those that need another angle, as the tables do."""

    direct: int
    rotated: int
    inaccessible: int

    @classmethod
    def of(cls, rivets: Iterable[RivetReach]) -> AccessSummary:
        """Count rivets by their status."""
        statuses = [rivet.status for rivet in rivets]
        return cls(statuses.count("direct"), statuses.count("rotated"), statuses.count("inaccessible"))

    @property
    def accomplished(self) -> int:
        """Rivets that can be set, at whatever angle."""
        return self.direct + self.rotated

    @property
    def total(self) -> int:
        """All rivets."""
        return self.accomplished + self.inaccessible

    @property
    def percent(self) -> float | None:
        """The accessibility percentage (Dakdouk 2016, eq. 3.50); None without rivets."""
        return 100.0 * self.accomplished / self.total if self.total else None

    @property
    def status(self) -> AccessStatus:
        """The status line of Tables 6-1 and 6-2."""
        return "Has some limitations" if self.inaccessible or not self.total else "Accessible"

    @property
    def access_class(self) -> AccessClass | None:
        """The class of section 3.5: over 80 % accessible, under 50 % crowded; both limits lie between.

        None without rivets.
        """
        hundredths = 100 * self.accomplished
        if not self.total:
            return None
        if hundredths > 80 * self.total:
            return "accessible"
        return "crowded" if hundredths < 50 * self.total else "modify_tool"
