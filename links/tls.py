"""TLS 1.3 with certificates on both ends, over the same sockets as tcp.

    tls://host:port?keys=FOLDER          as tcp://; handshake=5: s that the handshake may take
    tls-listen://host:port?keys=FOLDER   as tcp-listen://, with all its options

FOLDER (default ``~/.config/auvmission/keys``) holds ca.pem, cert.pem and key.pem, as `auvmission
keys` makes them. The authority signs only the certificates of this vehicle, its boats and its
viewers, and each certificate states the role of its owner. So a certificate need not contain the
vehicle's host name or address, and a boat cannot pose as the vehicle.
What does not live here: making keys (mission).
"""

from __future__ import annotations

import ssl
from pathlib import Path

from links import Address
from links.base import Link, LinkAbsent
from links.tcp import CONNECT_TIMEOUT, TcpClient, TcpServer, settings

FOLDER = "~/.config/auvmission/keys"
FILES = ("ca.pem", "cert.pem", "key.pem")


def context(folder: Path, *, server: bool) -> ssl.SSLContext:
    """Return a TLS context. Raises LinkAbsent if the folder lacks a file (it may come later)."""
    made = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER if server else ssl.PROTOCOL_TLS_CLIENT)
    made.minimum_version = ssl.TLSVersion.TLSv1_3
    made.check_hostname = False
    made.verify_mode = ssl.CERT_REQUIRED
    if server:
        made.num_tickets = 0
    ca, certificate, key = (folder / name for name in FILES)
    for path in (ca, certificate, key):
        if not path.is_file():
            raise LinkAbsent(f"{path} is not there: `auvmission keys` makes all three files")
    try:
        made.load_verify_locations(ca)
        made.load_cert_chain(certificate, key)
    except PermissionError as error:
        raise LinkAbsent(f"{folder}: its key cannot be read by this user") from error
    except OSError as error:
        raise LinkAbsent(f"{folder}: these are no keys of ours: {error}") from error
    return made


def open_url(name: str, address: Address) -> Link:
    host, port, admission = settings(address)
    folder = Path(address.options.get("keys") or FOLDER).expanduser()
    if address.scheme == "tls-listen":
        tls = context(folder, server=True)
        return TcpServer(name, host, port, admission=admission, tls=tls)
    within = address.number("handshake", CONNECT_TIMEOUT, 1.0, 120.0)
    return TcpClient(name, host, port, tls=context(folder, server=False), handshake=within)
