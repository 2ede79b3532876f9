"""`rivetplan serve`: the HTTP service on a loopback address."""

import logging
import socket
from ipaddress import ip_address

import uvicorn

from service.app import create_app
from service.commands.reading import Unusable
from service.settings import Settings


def serve(host: str, port: int, settings: Settings) -> None:
    """Serve until interrupted. Raises Unusable where the address cannot be used."""
    listening = _listen(host, port)
    address, its_port = listening.getsockname()[:2]
    shown = f"[{address}]" if ":" in address else address
    print(f"rivetplan serves on http://{shown}:{its_port}", flush=True)
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    config = uvicorn.Config(create_app(settings), log_config=None, timeout_graceful_shutdown=5)
    uvicorn.Server(config).run(sockets=[listening])


def _listen(host: str, port: int) -> socket.socket:
    """Open the socket to serve on: of this computer only, because no keys tell clients apart."""
    try:
        address = ip_address("127.0.0.1" if host == "localhost" else host)
    except ValueError:
        raise Unusable([f"--host: {host} is not an IP address. Use 127.0.0.1 or ::1."]) from None
    if not address.is_loopback:
        why = "the service knows no keys and would let everybody in"
        raise Unusable([f"--host: {host} is not a loopback address and {why}. Use 127.0.0.1 and a proxy."])
    listening = socket.socket(socket.AF_INET6 if address.version == 6 else socket.AF_INET)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((str(address), port))
        listening.listen()  # from here on clients wait instead of being refused
    except OSError as error:
        listening.close()
        raise Unusable([f"--port: {host} port {port} cannot be used: {error.strerror}."]) from None
    return listening
