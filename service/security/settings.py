"""Settings of who may ask what."""

from dataclasses import dataclass
from pathlib import Path

_MOST_LEEWAY_S = 60


@dataclass(frozen=True)
class TokenSettings:
    """Where tokens (JWT) of a plant's identity provider are believed.

    jwks: a file with its public keys (RFC 7517); nothing is ever fetched. issuer, audience: what a token must
    name. leeway_s: [s], by how much clocks may differ, at most 60.
    """

    jwks: Path
    issuer: str
    audience: str
    leeway_s: int = 30

    def __post_init__(self) -> None:
        if not 0 <= self.leeway_s <= _MOST_LEEWAY_S:
            raise ValueError(f"leeway_s is {self.leeway_s}; it must be 0 to {_MOST_LEEWAY_S}")
        if not (self.issuer and self.audience):
            raise ValueError("a token's issuer and audience must be named")


@dataclass(frozen=True)
class SecuritySettings:
    """Who may ask what, and how much.

    keys: the file of API keys, see `rivetplan keys`; it need not exist yet. tokens: whose tokens are
        believed. With neither a key nor tokens, the service is for this computer only, and asks for none.
    required: nobody is let in without a key or token, also where there are none.
    allowed_hosts: names by which clients may call it. Without keys, loopback names are allowed besides; with
        keys, every name is where none is listed.
    requests_per_s, burst: of one caller [1/s, 1]. Meant to stop a client that has run wild, before the event
        loop is all its own; far above what computing allows anyway.
    at_once: requests of one caller that are under way; a client of twenty threads fits.
    """

    keys: Path | None = None
    tokens: TokenSettings | None = None
    required: bool = False
    allowed_hosts: tuple[str, ...] = ()
    requests_per_s: float = 200.0
    burst: int = 400
    at_once: int = 32
