"""API keys: made, kept, compared.

A key reads `rvp_<id>_<secret>`. The id is public and says which record to compare with; the secret is 256
random bits. Kept is the sha256 of the whole key: a slow, memory-hard hash is for secrets that people choose
and others can guess; nobody guesses 256 random bits, and on every request it would be a lever to stop the
service with.

Exception
  KeyRefused      a change of the keys is not possible
"""

import base64
import hashlib
import re
import secrets
from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime
from hmac import compare_digest
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from service.security.caller import Caller
from service.security.scopes import Scope
from service.security.watched import Watched

FILE_NAME = "keys.json"

#: For a change of keys: one in use, one that takes over.
_MOST_OF_A_NAME = 2

_KEY = re.compile(r"rvp_([0-9a-f]{12})_[a-z2-7]{52}")
_NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$"


class KeyRefused(Exception):
    """A change of the keys is not possible; the text says why and what to do."""


class StoredKey(BaseModel):
    """What is kept of a key."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str = Field(pattern=_NAME)
    id: str = Field(pattern="^[0-9a-f]{12}$")
    sha256: str = Field(pattern="^[0-9a-f]{64}$")
    scopes: Annotated[tuple[Scope, ...], Field(min_length=1)]
    created: datetime


class _Document(BaseModel):
    """The file of the keys."""

    model_config = ConfigDict(extra="forbid")

    format: Literal["rivetplan-keys/1"] = "rivetplan-keys/1"
    keys: tuple[StoredKey, ...] = ()

    @model_validator(mode="after")
    def _ids_are_different(self) -> "_Document":
        if len({key.id for key in self.keys}) < len(self.keys):
            raise ValueError("two keys have the same id")
        return self


@dataclass(frozen=True)
class KeyTable:
    """The keys there are, oldest first."""

    keys: tuple[StoredKey, ...] = ()

    def of(self, name: str) -> tuple[StoredKey, ...]:
        """Return the keys of a client, oldest first. Raises KeyRefused where there are none."""
        found = tuple(key for key in self.keys if key.name == name)
        if not found:
            known = ", ".join(sorted({key.name for key in self.keys})) or "none at all"
            raise KeyRefused(f"There is no key of {name}. There are keys of: {known}.")
        return found

    def added(self, name: str, scopes: Iterable[Scope], now: datetime) -> tuple["KeyTable", str]:
        """Return the table with the first key of a client, and that key. Raises KeyRefused."""
        if not re.fullmatch(_NAME, name):
            raise KeyRefused(
                f"A client cannot be named {name!r}. Use up to 64 letters, digits, dots, dashes, underscores."
            )
        if any(key.name == name for key in self.keys):
            raise KeyRefused(f"{name} has a key. Use `rivetplan keys rotate {name}` for the next one.")
        return self._with_new(name, tuple(sorted(set(scopes))), now)

    def rotated(self, name: str, now: datetime) -> tuple["KeyTable", str]:
        """Return the table with a second key of a client, as the first, and that key. Raises KeyRefused."""
        *others, latest = self.of(name)
        if len(others) + 1 >= _MOST_OF_A_NAME:
            remedy = f"End the older one first: rivetplan keys remove {name} --id {others[0].id}."
            raise KeyRefused(f"{name} has two keys, {others[0].id} and {latest.id}. {remedy}")
        return self._with_new(name, latest.scopes, now)

    def removed(self, name: str, key_id: str | None) -> "KeyTable":
        """Return the table without a client's key, or without any of theirs. Raises KeyRefused."""
        theirs = self.of(name)
        if key_id is not None and key_id not in {key.id for key in theirs}:
            known = ", ".join(key.id for key in theirs)
            raise KeyRefused(f"{name} has no key {key_id}. Theirs are: {known}.")
        return replace(self, keys=tuple(k for k in self.keys if k.name != name or key_id not in (None, k.id)))

    def _with_new(self, name: str, scopes: tuple[Scope, ...], now: datetime) -> tuple["KeyTable", str]:
        key_id = secrets.token_hex(6)
        while key_id in {key.id for key in self.keys}:
            key_id = secrets.token_hex(6)
        secret = base64.b32encode(secrets.token_bytes(32)).decode().rstrip("=").lower()
        text = f"rvp_{key_id}_{secret}"
        key = StoredKey(
            name=name,
            id=key_id,
            sha256=_sha256(text).hex(),
            scopes=scopes,
            created=now.replace(microsecond=0),
        )
        return replace(self, keys=(*self.keys, key)), text


def parse_keys(content: bytes) -> KeyTable:
    """Return the keys in a file's content; none where it is empty. Raises ValueError."""
    if not content:
        return KeyTable()
    try:
        return KeyTable(_Document.model_validate_json(content).keys)
    except ValidationError as error:
        first = error.errors(include_input=False, include_url=False)[0]
        where = "/".join(map(str, first["loc"])) or "the document"
        raise ValueError(f"is no file of rivetplan's keys: {where}: {first['msg']}") from None


def written_keys(table: KeyTable) -> bytes:
    """Return a file's content."""
    return _Document(keys=table.keys).model_dump_json(indent=2).encode() + b"\n"


class KeyRing:
    """The keys of the running service; a change of the file holds from the next request on."""

    def __init__(self, path: Path) -> None:
        self._file = Watched(path, _prepared)

    def has_keys(self) -> bool:
        """Whether there is any key. Raises UnusableFile."""
        return bool(self._file.value())

    def caller(self, credential: str) -> Caller | None:
        """Return whose key this is; None where it is nobody's. Raises UnusableFile.

        Whatever is wrong, the same is done: hashed, looked up, compared once in constant time. An id that is
        unknown, or that cannot be told, is compared with a digest of nothing.
        """
        told = _KEY.fullmatch(credential)
        digest, caller = self._file.value().get(told[1] if told else "", _NOBODY)
        return caller if compare_digest(_sha256(credential), digest) else None


_Prepared = dict[str, tuple[bytes, Caller | None]]

_NOBODY: tuple[bytes, Caller | None] = (secrets.token_bytes(32), None)


def _prepared(content: bytes) -> _Prepared:
    keys = parse_keys(content).keys
    return {
        key.id: (bytes.fromhex(key.sha256), Caller(f"key:{key.name}", frozenset(key.scopes))) for key in keys
    }


def _sha256(text: str) -> bytes:
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).digest()
