"""The meaning of the topside's URL in the configuration: where to listen, and who is admitted.

What does not live here: the options of such a URL (links).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from links import parse_address


@dataclass(frozen=True, slots=True)
class Ready:
    """Reported once, when an operator can connect."""

    topside: str  # tcp://host:port, the port as it really is
    black_box: str  # path, "" if there is none


def listening(url: str) -> str:
    """The topside's URL as that of a listening link: tcp-listen or tls-listen."""
    return re.sub(r"^(tcp|tls)://", r"\1-listen://", url)


def listening_to_viewers(url: str) -> str:
    """The monitor's URL: admits viewers, with time for a handshake over a slow radio."""
    url = listening(url)
    for option in ("handshake=60", "viewers=yes"):
        if f"{option.partition('=')[0]}=" not in url.partition("?")[2]:
            url += f"{'&' if '?' in url else '?'}{option}"
    return url


def reached_at(url: str) -> str:
    """The URL that an operator gives to ``--to``."""
    return url.replace("-listen://", "://", 1).partition("?")[0]


def open_to_all(url: str) -> bool:
    """Whether anybody who reaches the port can command the vehicle. Raises LinkAddressError."""
    address = parse_address(listening(url))
    loopback = address.host in ("localhost", "::1") or address.host.startswith("127.")
    return address.scheme == "tcp-listen" and not loopback and not address.options.get("allow")
