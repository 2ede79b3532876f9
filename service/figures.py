"""What the service counts of a program, for its metrics."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # it brings the compiler, which counting does not need
    from robots.nc import NcProgram


@dataclass(frozen=True)
class Figures:
    """What one program counts.

    links: by the engine that found them. refused: fasteners that are not installed, by the code of why.
    rejected: 1 where the verifier's certificate is not clean.
    """

    links: Mapping[str, int]
    refused: Mapping[str, int]
    rejected: int

    @classmethod
    def of(cls, program: NcProgram) -> Figures:
        """Count a program."""
        links = program.summary.links
        origins = {
            "direct": links.direct,
            "planned": links.planned,
            "reused": links.reused,
            "fallback": links.fallback,
            "approach": links.approach or 0,
        }
        refused = Counter(each.reason.code for each in program.fasteners if each.reason is not None)
        certificate = program.verification
        return cls(origins, dict(refused), int(certificate is None or certificate.result != "clean"))
