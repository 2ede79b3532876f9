"""Keys and tokens never reach a log, whoever put them where."""

import logging
import re

_SECRETS = re.compile(
    r"((?i:bearer)\s+(?:rvp_[0-9a-f]{12}_)?)[^\s\"',]+"  # the id stays: it says whose it was
    r"|(rvp_(?:[0-9a-f]{12}_)?)[^\s\"'&<>;,]+"
    r"|eyJ[\w-]+\.[\w-]*\.[\w-]*"  # a JWT
)


def redact(text: str) -> str:
    """Return a text without the keys and tokens in it."""
    return _SECRETS.sub(lambda found: f"{found[1] or found[2] or ''}[redacted]", text)


class RedactingFormatter(logging.Formatter):
    """Formats a record, its traceback too, without keys and tokens."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the record's text."""
        return redact(super().format(record))
