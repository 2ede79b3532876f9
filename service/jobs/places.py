"""Where jobs are kept: the data directory, the database and the artefact store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from service.jobs.artefacts import Store

DATABASE, ARTEFACTS = "RIVETPLAN_DB", "RIVETPLAN_ARTIFACTS"
"""Environment variables."""


@dataclass(frozen=True)
class JobPlaces:
    """Where jobs are kept.

    data: the directory; locks lie in it, and with SQLite the database. database: a URL of SQLAlchemy,
    sqlite:///... or postgresql://... artefacts: a directory that every worker and every API host sees.
    """

    data: Path
    database: str
    artefacts: Path

    @classmethod
    def of(cls, data: Path, environment: Mapping[str, str]) -> JobPlaces:
        """Everything in one directory, unless the environment says otherwise."""
        data = data.absolute()
        database = environment.get(DATABASE) or f"sqlite:///{data / 'jobs.sqlite'}"
        artefacts = environment.get(ARTEFACTS)
        return cls(data, database, Path(artefacts).absolute() if artefacts else data / "artefacts")

    @property
    def is_sqlite(self) -> bool:
        """Whether the database is a file of this machine."""
        return self.database.startswith("sqlite")

    @property
    def locks(self) -> Path:
        """The directory of the workers' locks."""
        return self.data / "locks"

    def store(self) -> Store:
        """The artefact store."""
        return Store(self.artefacts)


def usual_data(environment: Mapping[str, str]) -> Path:
    """The data directory where none is named: in the user's own directory for data."""
    home = environment.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    return Path(home) / "rivetplan"
