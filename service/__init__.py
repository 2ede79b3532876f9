"""Faces of rivetplan: HTTP service, command line, demo. The only layer that knows of clients."""

__version__ = "0.1.0"
