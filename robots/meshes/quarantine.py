"""Files from others, read in a process of its own that may only take so much memory and time.

Whatever happens there (a library that crashes, a file that asks for all memory) becomes an InvalidInput here;
what comes back is not trusted either: the model is checked as it is unpacked.
"""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO

from robots.errors import InputProblem, InvalidInput
from robots.meshes.formats import MAX_BYTES, format_of
from robots.meshes.model import Model, Unit
from robots.meshes.packed import unpack
from robots.meshes.refusals import refused

#: Puts the folder of this package on the path, which an isolated interpreter does not look at.
_START = "import sys; sys.path.insert(0, sys.argv.pop(1)); from robots.meshes.__main__ import main; main()"
_ROOT = Path(__file__).parents[2]
_MODEL, _PROBLEMS = b"model\n", b"problems\n"
_COARSER = "Export with a coarser tolerance, divide the part, or bring it as GLB."


@dataclass(frozen=True)
class Limits:
    """What reading one file may take: memory [bytes], processor and wall-clock time [s], open files."""

    memory: int = 2_000_000_000
    processor: int = 120
    seconds: float = 180.0
    written: int = 512_000_000
    open_files: int = 64


def read_limited(path: Path, name: str, unit: Unit | None, limits: Limits = Limits()) -> Model:
    """The model in the file at `path`, as `robots.meshes.read.read_model` reads it.

    name: under which it was brought, whose extension tells the format. Raises InvalidInput, also where the
    reader crashes or needs more than `limits` allow; OSError where `path` cannot be opened.
    """
    format_of(name)
    with Path(path).open("rb") as content, tempfile.TemporaryFile() as answer:
        size = os.fstat(content.fileno()).st_size
        if size > MAX_BYTES:
            message = f"the file has {size} bytes; {MAX_BYTES} are the most that are read"
            raise refused("file_too_large", message, _COARSER, value=size)
        sha256 = hashlib.file_digest(content, "sha256").hexdigest()
        content.seek(0)
        status = _run([name, unit or "", json.dumps(asdict(limits))], content, answer, limits.seconds)
        answer.seek(0)
        model = _answered(answer.read(), status, limits)
    if model.sha256 != sha256:
        raise _crashed("the reader answered for another file")
    return model


def _run(arguments: list[str], content: IO[bytes], answer: IO[bytes], seconds: float) -> int | None:
    """The status the reading process ended with; None where its time was over."""
    process = subprocess.Popen(
        [sys.executable, "-I", "-c", _START, str(_ROOT), *arguments],
        stdin=content,
        stdout=answer,
        stderr=subprocess.DEVNULL,
        env={"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "LC_ALL": "C.UTF-8"},
        cwd=_ROOT.anchor,
        start_new_session=True,
    )
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        return None
    finally:
        if process.returncode is None:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def _answered(answer: bytes, status: int | None, limits: Limits) -> Model:
    if status is None or status in (-signal.SIGXCPU, -signal.SIGALRM):
        spent = f"{limits.processor} s of processor or {limits.seconds:g} s in all"
        message = f"reading the file takes more than {spent}"
        raise refused("too_expensive", message, _COARSER)
    if status == 0 and answer.startswith(_MODEL):
        return unpack(answer[len(_MODEL) :])
    if status == 0 and answer.startswith(_PROBLEMS):
        raise InvalidInput([InputProblem(**each) for each in json.loads(answer[len(_PROBLEMS) :])])
    raise _crashed(f"the reader stopped with {_name(status)}")


def _crashed(how: str) -> InvalidInput:
    remedy = "Export the file again: it is damaged, or needs more memory than it may take."
    return refused("mesh_unreadable", f"the file cannot be read: {how}", remedy)


def _name(status: int) -> str:
    return signal.Signals(-status).name if status < 0 else f"status {status}"
