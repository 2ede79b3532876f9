"""Tokens: what proves who somebody is, and everything that looks as if it did."""

import base64
import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jwt
import pytest
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec, ed25519, rsa
from hypothesis import given
from hypothesis import strategies as st

from service.security.caller import Caller
from service.security.scopes import Scope
from service.security.settings import SecuritySettings, TokenSettings
from service.security.tokens import TokenReader, parse_jwks
from service.security.watched import UnusableFile
from tests.service.security.guarded import bearer, guarded_by, key_file

ISSUER, AUDIENCE = "https://identity.plant", "rivetplan"
PRIVATE: dict[str, Any] = {
    "RS256": rsa.generate_private_key(65537, 2048),
    "ES256": ec.generate_private_key(ec.SECP256R1()),
    "EdDSA": ed25519.Ed25519PrivateKey.generate(),
}
STRANGER = ec.generate_private_key(ec.SECP256R1())


def jwk(algorithm: str, private: Any, **members: Any) -> dict[str, Any]:
    made = jwt.get_algorithm_by_name(algorithm)
    return {**made.to_jwk(private.public_key(), as_dict=True), "kid": algorithm, "use": "sig"} | members


JWKS = json.dumps({"keys": [jwk(algorithm, private) for algorithm, private in PRIVATE.items()]})


def claims(**changes: Any) -> dict[str, Any]:
    now = int(time.time())
    usual = {
        "iss": ISSUER,
        "aud": AUDIENCE,
        "sub": "mes",
        "exp": now + 600,
        "nbf": now,
        "scope": "openid plan",
    }
    return {name: value for name, value in (usual | changes).items() if value is not None}


def signed(algorithm: str = "ES256", private: Any = None, *, kid: Any = "", **changes: Any) -> str:
    key = private or PRIVATE[algorithm]
    return jwt.encode(claims(**changes), key, algorithm, headers={"kid": kid or algorithm})


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> TokenReader:
    file = tmp_path_factory.mktemp("jwks") / "jwks.json"
    file.write_text(JWKS)
    return TokenReader(TokenSettings(file, ISSUER, AUDIENCE))


@pytest.mark.parametrize("algorithm", PRIVATE)
def test_token_says_who_it_is_and_what_they_may(reader: TokenReader, algorithm: str) -> None:
    assert reader.caller(signed(algorithm)) == Caller("token:mes", frozenset({Scope.PLAN}))


@pytest.mark.parametrize(
    "changes",
    [
        {"exp": int(time.time()) - 120},
        {"exp": None},
        {"exp": "soon"},
        {"exp": 1e400},
        {"nbf": int(time.time()) + 600},
        {"iat": int(time.time()) + 600},
        {"iss": "https://elsewhere"},
        {"iss": None},
        {"iss": [ISSUER]},
        {"aud": "somebody"},
        {"aud": None},
        {"aud": []},
        {"sub": None},
        {"sub": ""},
        {"sub": "a\nb"},
        {"sub": "x" * 129},
        {"scope": ["plan"]},
    ],
    ids=str,
)
def test_claim_that_is_wrong_proves_nothing(reader: TokenReader, changes: dict[str, Any]) -> None:
    token = _raw({"alg": "ES256", "kid": "ES256"}, claims(**changes), PRIVATE["ES256"])

    assert reader.caller(_raw({"alg": "ES256", "kid": "ES256"}, claims(), PRIVATE["ES256"])) is not None
    assert reader.caller(token) is None


def _part(content: Mapping[str, Any]) -> str:
    return base64.urlsafe_b64encode(json.dumps(content).encode()).decode().rstrip("=")


def _raw(header: Mapping[str, Any], content: Mapping[str, Any], private: Any) -> str:
    """Sign anything, also what the library would not."""
    return _signed_text(_part(header), _part(content), private)


def _signed_text(header: str, content: str, private: Any = None) -> str:
    message = f"{header}.{content}"
    signature = jwt.get_algorithm_by_name("ES256").sign(message.encode(), private or PRIVATE["ES256"])
    return f"{message}.{base64.urlsafe_b64encode(signature).decode().rstrip('=')}"


def test_clocks_may_differ_a_little(reader: TokenReader) -> None:
    now = int(time.time())

    assert reader.caller(signed(exp=now - 5, nbf=now + 5)) is not None
    with pytest.raises(ValueError, match="0 to 60"):
        TokenSettings(Path("x"), ISSUER, AUDIENCE, leeway_s=61)


def test_stranger_and_changed_token_prove_nothing(reader: TokenReader) -> None:
    header, content, signature = signed().split(".")

    assert reader.caller(signed(private=STRANGER)) is None
    assert reader.caller(f"{header}.{_part(claims(scope='admin'))}.{signature}") is None
    assert reader.caller(f"{header}.{content}.") is None
    assert reader.caller(f"{header}.{content}") is None


def test_unsigned_token_proves_nothing(reader: TokenReader) -> None:
    for name in ("none", "None", "NONE", "nOnE"):
        token = f"{_part({'alg': name, 'kid': 'ES256'})}.{_part(claims())}."
        assert reader.caller(token) is None


@pytest.mark.parametrize("algorithm", PRIVATE)
def test_public_key_is_no_shared_secret(reader: TokenReader, algorithm: str) -> None:
    public = PRIVATE[algorithm].public_key()
    pem = public.public_bytes(serialization.Encoding.PEM, serialization.PublicFormat.SubjectPublicKeyInfo)
    for secret in (pem, pem.strip(), JWKS.encode(), json.dumps(jwk(algorithm, PRIVATE[algorithm])).encode()):
        message = f"{_part({'alg': 'HS256', 'kid': algorithm})}.{_part(claims())}"
        signature = jwt.get_algorithm_by_name("HS256").sign(message.encode(), secret)
        token = f"{message}.{base64.urlsafe_b64encode(signature).decode().rstrip('=')}"
        assert reader.caller(token) is None


@pytest.mark.parametrize("name", ["RS384", "RS512", "PS256", "ES384", "HS256", "ES256K", "", "x"])
def test_key_signs_in_its_own_way_only(reader: TokenReader, name: str) -> None:
    for kid in PRIVATE:
        assert reader.caller(_raw({"alg": name, "kid": kid}, claims(), PRIVATE["ES256"])) is None


@pytest.mark.parametrize("kid", [None, 1, [], {}, "../ES256", "x", ""])
def test_key_is_found_by_its_id_only(reader: TokenReader, kid: object) -> None:
    assert reader.caller(_raw({"alg": "ES256", "kid": kid}, claims(), PRIVATE["ES256"])) is None


@pytest.mark.parametrize(
    "header",
    [
        {"jku": "https://evil.example/jwks.json"},
        {"x5u": "https://evil.example/x"},
        {"jwk": jwk("ES256", STRANGER)},
    ],
)
def test_token_brings_no_keys_of_its_own(reader: TokenReader, header: dict[str, Any]) -> None:
    for kid in ("ES256", "x"):
        assert reader.caller(_raw({"alg": "ES256", "kid": kid} | header, claims(), STRANGER)) is None


def test_extension_that_must_be_understood_is_not(reader: TokenReader) -> None:
    header = {"alg": "ES256", "kid": "ES256", "crit": ["b64x"], "b64x": 1}

    assert reader.caller(_raw(header, claims(), PRIVATE["ES256"])) is None


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=10),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


@given(name=st.sampled_from([*claims(), "iat", "jti"]), value=json_values)
def test_no_claim_makes_it_fail(reader: TokenReader, name: str, value: object) -> None:
    caller = reader.caller(_raw({"alg": "ES256", "kid": "ES256"}, claims() | {name: value}, PRIVATE["ES256"]))

    assert caller is None or caller.scopes <= {Scope.PLAN} or name == "scope"


@given(header=st.dictionaries(st.sampled_from(["alg", "kid", "typ", "crit", "b64", "zip"]), json_values))
def test_no_header_makes_it_fail(reader: TokenReader, header: dict[str, Any]) -> None:
    reader.caller(_raw({"alg": "ES256", "kid": "ES256"} | header, claims(), STRANGER))


@given(token=st.text(max_size=60) | st.text("abcABC123._-=", max_size=60))
def test_no_other_text_is_a_token(reader: TokenReader, token: str) -> None:
    assert reader.caller(token) is None


@pytest.mark.parametrize("nested", [b"[" * 5000, b'{"a":' * 1000], ids=["lists", "objects"])
def test_deeply_nested_tokens_are_no_fault(reader: TokenReader, nested: bytes) -> None:
    deep = base64.urlsafe_b64encode(nested).decode().rstrip("=")

    assert reader.caller(f"{deep}.e30.e30") is None
    assert reader.caller(_signed_text(_part({"alg": "ES256", "kid": "ES256"}), deep)) is None


def test_endless_token_is_not_looked_at(reader: TokenReader) -> None:
    assert reader.caller(signed()) is not None
    assert reader.caller(signed(more="x" * 8000)) is None


def test_keys_of_the_file_change_while_the_service_runs(tmp_path: Path) -> None:
    file = tmp_path / "jwks.json"
    file.write_text(JWKS)
    reader = TokenReader(TokenSettings(file, ISSUER, AUDIENCE))
    assert reader.caller(signed()) is not None

    file.write_text(json.dumps({"keys": [jwk("ES256", STRANGER)]}))

    assert reader.caller(signed()) is None
    assert reader.caller(signed(private=STRANGER)) is not None
    file.unlink()
    with pytest.raises(UnusableFile):
        reader.caller(signed(private=STRANGER))


SMALL = rsa.generate_private_key(65537, 1024)


@pytest.mark.parametrize(
    ("keys", "why"),
    [
        ([{"kty": "oct", "k": "c2VjcmV0", "kid": "1"}], "keys/0 is a secret"),
        ([{**jwk("ES256", STRANGER), "d": "AAAA"}], "keys/0 is a secret"),
        ([jwk("ES256", STRANGER), jwk("EdDSA", PRIVATE["EdDSA"], kid="ES256")], "same kid"),
        ([jwk("RS256", SMALL)], "1024 bits"),
        ([jwk("ES256", STRANGER, kid=None)], "no kid"),
        ([jwk("ES256", STRANGER, x="AAAA")], "cannot be read"),
        ([jwk("ES256", STRANGER, use="enc")], "no key that is used here"),
        ([jwk("RS256", PRIVATE["RS256"], alg="HS256")], "no key that is used here"),
        ([jwk("RS256", PRIVATE["RS256"], alg="RS512")], "no key that is used here"),
        ([jwk("ES384", ec.generate_private_key(ec.SECP384R1()))], "no key that is used here"),
        ([], "no key that is used here"),
        ([3], "no JWK set"),
        ({}, "no JWK set"),
        (None, "no JWK set"),
    ],
)
def test_file_that_is_no_set_of_public_keys_is_refused(keys: object, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        parse_jwks(json.dumps({"keys": keys}).encode())


@pytest.mark.parametrize("content", [b"", b"{}", b"[]", b"{", b"\xff", b"[" * 100_000])
def test_file_that_is_no_json_is_refused(content: bytes) -> None:
    with pytest.raises(ValueError, match="no JWK set"):
        parse_jwks(content)


def test_keys_and_tokens_are_believed_side_by_side(tmp_path: Path) -> None:
    file = tmp_path / "jwks.json"
    file.write_text(JWKS)
    keys = key_file(tmp_path)
    settings = SecuritySettings(keys=keys.path, tokens=TokenSettings(file, ISSUER, AUDIENCE))
    with guarded_by(settings) as client:

        def status(credential: str) -> int:
            return client.get("/v1/machines", headers=bearer(credential)).status_code

        assert client.get("/v1/machines").status_code == 401  # tokens are asked for from the start
        key = keys.add("mes", Scope.READ)
        read, plan = signed(scope="read"), signed(scope="plan")
        assert [status(each) for each in (key, read, plan, signed(private=STRANGER))] == [200, 200, 403, 401]
