"""Canonical text and identity of NC programs.

The sha256 of the text without the `verification` member is the program's identity: the certificate inside the
file names the hash of everything else.
"""

import hashlib
from dataclasses import replace

from robots.nc import Certificate, NcInputs, NcPlanner, NcProgram
from robots.nc_codec import decode, encode


def to_json(program: NcProgram) -> bytes:
    """Return the canonical file: one line of ASCII JSON with a newline at the end."""
    return (encode(program) + "\n").encode("ascii")


def from_json(text: str | bytes) -> NcProgram:
    """Read a program; raises `InvalidInput` listing every problem with its JSON pointer."""
    program: NcProgram = decode(NcProgram, text)
    return program


def rounded(program: NcProgram) -> NcProgram:
    """Return the program as a reader of its file sees it: every number with the digits of the format.

    What is examined, hashed and written must be the same numbers; build, round, then examine.
    """
    return from_json(to_json(program))


def rounded_certificate(certificate: Certificate) -> Certificate:
    """Return the certificate as a reader of the file sees it."""
    read: Certificate = decode(Certificate, encode(certificate))
    return read


def program_sha256(program: NcProgram) -> str:
    """Identity of the program: sha256 of its canonical JSON without the certificate, 64 hex digits."""
    return hashlib.sha256(encode(program, omit=("verification",)).encode("ascii")).hexdigest()


def program_id(inputs: NcInputs, planner: NcPlanner) -> str:
    """Name of a planning run: the same inputs, planner version and seed give the same 16 hex digits."""
    return hashlib.sha256((encode(inputs) + encode(planner)).encode("ascii")).hexdigest()[:16]


def with_certificate(program: NcProgram, certificate: Certificate) -> NcProgram:
    """Return the program with its certificate in it; the identity stays as it is."""
    return replace(program, verification=certificate)
