"""Where jobs are kept, made ready for a command."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import psycopg
from sqlalchemy.exc import SQLAlchemyError

from service.commands.reading import Unusable
from service.jobs.database import prepare
from service.jobs.places import DATABASE, JobPlaces
from service.jobs.schema import NewerSchema


def prepared(data: Path) -> JobPlaces:
    """Where jobs are kept, with everything that is needed there. Raises Unusable."""
    try:
        places = JobPlaces.of(data, os.environ)
        prepare(places)
        _try(places)
    except OSError as error:
        raise Unusable([f"--data: {data} cannot be used: {error.strerror}. Name a directory."]) from None
    except NewerSchema as newer:
        raise Unusable([f"--data: {newer}. Install that version."]) from None
    except (SQLAlchemyError, psycopg.Error) as error:
        why = str(error).splitlines()[0]
        raise Unusable([f"{DATABASE}: the database cannot be used: {why}. Name one that runs."]) from None
    return places


def _try(places: JobPlaces) -> None:
    """Write where jobs will: that everything is there already says nothing of it. Raises Unusable."""
    for directory in (places.data, places.locks, places.artefacts):
        try:
            with tempfile.TemporaryFile(dir=directory):
                pass
        except OSError as error:
            why = f"nothing can be written in {directory}: {error.strerror}"
            raise Unusable([f"--data: {why}. Mend that, or name another directory."]) from None
