"""`rivetplan serve` itself: which addresses it takes, whom it lets in, what it logs."""

import json
import re
import subprocess
import sys
from pathlib import Path

import httpx
import pytest

from service.commands import serve
from service.commands.reading import Unusable
from service.security.scopes import Scope
from service.security.settings import SecuritySettings
from tests.service.conftest import ROOT
from tests.service.security.guarded import bearer, guarded_by, key_file
from tests.service.security.test_tokens import JWKS


def security(data: Path, tokens: tuple[Path, str, str] | None = None) -> SecuritySettings:
    return serve.security(data, allowed_hosts=[], tokens=tokens, requests_per_s=200.0)


@pytest.mark.long
def test_any_address_is_taken_with_keys_and_nothing_secret_is_logged(tmp_path: Path) -> None:
    key = key_file(tmp_path).add("mes", Scope.READ)
    command = [sys.executable, "-m", "service.cli", "serve", "--host", "0.0.0.0", "--port", "0"]
    options = ["--workers", "0", "--data", str(tmp_path)]
    environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"}
    with subprocess.Popen(
        command + options, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        told = process.stdout.readline()
        port = int(told.rpartition(":")[2])
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=60, trust_env=False) as client:
            let_in = client.get("/v1/machines", headers=bearer(key))
            refused = client.get("/v1/machines", params={"api_key": key})
        process.terminate()
        _, logged = process.communicate(timeout=60)

    assert [let_in.status_code, refused.status_code] == [200, 401]
    assert "server" not in let_in.headers
    assert "put a proxy with TLS before" in logged
    assert re.search(r"GET \S+ 401", logged)
    assert "api_key" not in logged
    assert key.split("_")[2] not in logged


def test_what_cannot_be_checked_is_not_served(tmp_path: Path) -> None:
    file = key_file(tmp_path)
    file.path.write_text("{")
    with pytest.raises(Unusable, match="no file of rivetplan's keys"):
        serve._is_guarded(security(tmp_path))

    file.path.unlink()
    secret = tmp_path / "jwks.json"
    secret.write_text(json.dumps({"keys": [{"kty": "oct", "k": "eA", "kid": "1"}]}))
    with pytest.raises(Unusable, match="only public keys belong here"):
        serve._is_guarded(security(tmp_path, (secret, "https://identity.plant", "rivetplan")))
    with pytest.raises(Unusable, match="--jwt-issuer"):
        security(tmp_path, (secret, "", "rivetplan"))


def test_tokens_guard_as_keys_do(tmp_path: Path) -> None:
    jwks = tmp_path / "jwks.json"
    jwks.write_text(JWKS)

    assert not serve._is_guarded(security(tmp_path))
    assert serve._is_guarded(security(tmp_path, (jwks, "https://identity.plant", "rivetplan")))


def test_service_that_had_keys_when_it_began_never_opens(tmp_path: Path) -> None:
    guarded = SecuritySettings(keys=key_file(tmp_path).path, required=True)  # they were removed meanwhile
    with guarded_by(guarded) as client:
        assert client.get("/v1/machines").status_code == 401
