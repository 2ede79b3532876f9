"""Tokens of a plant's identity provider: JWT (RFC 7519), proved by public keys in a file.

What a key is says how it signs; a token that names another algorithm is refused (RFC 8725, 3.1), and so are
`none` and every secret shared with the service.
"""

from collections.abc import Mapping
from typing import Any

import jwt
from cryptography.hazmat.primitives.asymmetric.rsa import RSAPublicKey
from pydantic import BaseModel, ValidationError

from service.security.caller import Caller
from service.security.scopes import Scope
from service.security.settings import TokenSettings
from service.security.watched import Watched

#: Kind and curve of a key -> how it signs.
_ALGORITHMS: Mapping[tuple[str, str | None], str] = {
    ("RSA", None): "RS256",
    ("EC", "P-256"): "ES256",
    ("OKP", "Ed25519"): "EdDSA",
}
_SHORTEST_RSA = 2048  # bits, RFC 7518, 3.3
_LONGEST_TOKEN = 8192  # characters
_LONGEST_SUBJECT = 128
_REQUIRED = ["exp", "iss", "aud", "sub"]
_SCOPES = frozenset(Scope)


class _JwkSet(BaseModel):
    keys: list[dict[str, Any]]


class TokenReader:
    """Whose tokens are whose; a change of the key file holds from the next request on."""

    def __init__(self, settings: TokenSettings) -> None:
        self._settings = settings
        self._keys = Watched(settings.jwks, parse_jwks)

    def check(self) -> None:
        """Read the file of keys. Raises UnusableFile."""
        self._keys.value()

    def caller(self, token: str) -> Caller | None:
        """Return whose token this is; None where it proves nothing. Raises UnusableFile."""
        keys = self._keys.value()
        claims = self._claims(token, keys) if len(token) <= _LONGEST_TOKEN else None
        return None if claims is None else _caller(claims)

    def _claims(self, token: str, keys: Mapping[str, jwt.PyJWK]) -> dict[str, Any] | None:
        settings = self._settings
        try:
            kid = jwt.get_unverified_header(token).get("kid")
            if not (isinstance(kid, str) and kid in keys):
                return None
            key = keys[kid]
            return jwt.decode(
                token,
                key,
                algorithms=[key.algorithm_name],
                audience=settings.audience,
                issuer=settings.issuer,
                leeway=settings.leeway_s,
                options={"require": _REQUIRED},
            )
        except jwt.PyJWTError:
            return None


def _caller(claims: Mapping[str, Any]) -> Caller | None:
    subject, scope = claims["sub"], claims.get("scope", "")
    if not (isinstance(subject, str) and isinstance(scope, str)):
        return None
    if not (0 < len(subject) <= _LONGEST_SUBJECT and subject.isprintable()):
        return None
    return Caller(f"token:{subject}", frozenset(map(Scope, _SCOPES & set(scope.split(" ")))))


def parse_jwks(content: bytes) -> dict[str, jwt.PyJWK]:
    """Return the keys of a JWK set by their ids. Raises ValueError where it has none, or a secret."""
    try:
        listed = _JwkSet.model_validate_json(content).keys
    except ValidationError:
        raise ValueError('is no JWK set: an object with a list of "keys"') from None
    usable = [key for place, each in enumerate(listed) if (key := _key(place, each)) is not None]
    by_id = {str(key.key_id): key for key in usable}
    if len(by_id) < len(usable):
        raise ValueError("two keys have the same kid")
    if not by_id:
        raise ValueError("has no key that is used here: RSA, EC P-256 or Ed25519, with a kid")
    return by_id


def _key(place: int, each: Mapping[str, Any]) -> jwt.PyJWK | None:
    """Return a key of the set; None where it is for something else. Raises ValueError."""
    if each.get("kty") == "oct" or "d" in each:
        raise ValueError(f"keys/{place} is a secret; only public keys belong here")
    algorithm = _ALGORITHMS.get((str(each.get("kty")), each.get("crv")))
    if algorithm is None or each.get("use", "sig") != "sig" or each.get("alg", algorithm) != algorithm:
        return None
    if not (isinstance(each.get("kid"), str) and each["kid"]):
        raise ValueError(f"keys/{place} has no kid")
    try:
        key = jwt.PyJWK(dict(each), algorithm)
    except jwt.PyJWTError:
        raise ValueError(f"keys/{place} cannot be read as a key for {algorithm}") from None
    if isinstance(key.key, RSAPublicKey) and key.key.key_size < _SHORTEST_RSA:
        raise ValueError(f"keys/{place} has {key.key.key_size} bits; at least {_SHORTEST_RSA} are needed")
    return key
