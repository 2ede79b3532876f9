"""A service with keys: what the tests of its security share."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import httpx

from service.app import create_app
from service.files import write_atomically
from service.security.keys import FILE_NAME, KeyTable, parse_keys, written_keys
from service.security.scopes import Scope
from service.security.settings import SecuritySettings
from tests.service.conftest import SETTINGS, FakeEngine, serving

NOW = datetime(2026, 11, 23, 8, 0, tzinfo=UTC)


@dataclass(frozen=True)
class KeyFile:
    """A file of keys, changed as the command line does."""

    path: Path

    @property
    def table(self) -> KeyTable:
        return parse_keys(self.path.read_bytes() if self.path.exists() else b"")

    def write(self, table: KeyTable) -> None:
        write_atomically(self.path, written_keys(table), mode=0o600)

    def add(self, name: str, *scopes: Scope) -> str:
        table, key = self.table.added(name, scopes, NOW)
        self.write(table)
        return key

    def rotate(self, name: str) -> str:
        table, key = self.table.rotated(name, NOW)
        self.write(table)
        return key

    def remove(self, name: str, key_id: str | None = None) -> None:
        self.write(self.table.removed(name, key_id))


def key_file(directory: Path) -> KeyFile:
    return KeyFile(directory / FILE_NAME)


def bearer(key: str) -> dict[str, str]:
    return {"authorization": f"Bearer {key}"}


@contextmanager
def guarded_by(security: SecuritySettings, engine: FakeEngine | None = None) -> Iterator[httpx.Client]:
    """Serve with these settings on a loopback port."""
    app = create_app(replace(SETTINGS, security=security), engine or FakeEngine())
    with serving(app) as client:
        yield client
