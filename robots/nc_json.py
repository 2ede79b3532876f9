"""Canonical text and identity of NC programs.

The sha256 of the text without the `verification` member is the program's identity: the certificate inside the
file names the hash of everything else.
"""

import hashlib
from dataclasses import replace

from robots import nc_codec
from robots.nc import Certificate, NcInputs, NcPlanner, NcProgram
from robots.nc_codec import decode, encode


def to_json(program: NcProgram) -> bytes:
    """Return the canonical file: one line of ASCII JSON with a newline at the end.

    The certificate is its last member, so what is hashed is what is written.
    """
    certificate = "null" if program.verification is None else encode(program.verification)
    return f'{program.identity_text[:-1]},"verification":{certificate}}}\n'.encode("ascii")


def from_json(text: str | bytes) -> NcProgram:
    """Read a program; raises `InvalidInput` listing every problem with its JSON pointer."""
    program: NcProgram = decode(NcProgram, text)
    return program


def rounded(program: NcProgram) -> NcProgram:
    """Return the program as a reader of its file sees it: every number with the digits of the format.

    What is examined, hashed and written must be the same numbers; build, round, then examine. Raises
    `ValueError` for what cannot be written and `InvalidInput` for what could not be read back.
    """
    read: NcProgram = nc_codec.rounded(program)
    return read


def rounded_certificate(certificate: Certificate) -> Certificate:
    """Return the certificate as a reader of the file sees it."""
    read: Certificate = nc_codec.rounded(certificate)
    return read


def program_sha256(program: NcProgram) -> str:
    """Identity of the program: sha256 of its canonical JSON without the certificate, 64 hex digits."""
    return hashlib.sha256(program.identity_text.encode("ascii")).hexdigest()


def program_id(inputs: NcInputs, planner: NcPlanner) -> str:
    """Name of a planning run: the same inputs, planner version and seed give the same 16 hex digits."""
    return hashlib.sha256((encode(inputs) + encode(planner)).encode("ascii")).hexdigest()[:16]


def with_certificate(program: NcProgram, certificate: Certificate) -> NcProgram:
    """Return the program with its certificate in it; the identity stays as it is."""
    certified = replace(program, verification=certificate)
    if "identity_text" in vars(program):
        vars(certified)["identity_text"] = program.identity_text  # the certificate is no part of it
    return certified
