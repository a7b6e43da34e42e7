"""Move bytes, whatever they mean.

    serial:///dev/ttyUSB0?baud=9600     tcp://host:port     tcp-listen://127.0.0.1:port
    tls://host:port?keys=FOLDER         tls-listen://0.0.0.0:port?keys=FOLDER&allow=192.168.1.0/24
    memory://name                       acoustic://name?range=1000&rate=1000&loss=0.1
    can://can0?interface=socketcan

``open_link`` opens a link by its URL. LINKS has one row for each scheme. The module of a row is
imported when it is first needed.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from urllib.parse import parse_qsl, urlsplit

from links.base import Link, LinkError

__all__ = [
    "LINKS",
    "Address",
    "LinkAddressError",
    "LinkRow",
    "at_rate",
    "baud_of",
    "check_url",
    "open_link",
    "parse_address",
]

SERIAL_BAUD = 9600


class LinkAddressError(LinkError):
    """The URL itself is wrong. The message names the part, and what to write instead."""


@dataclass(frozen=True, slots=True)
class Address:
    """A link's URL, parsed. ``options`` has only options that the row of the scheme allows."""

    url: str
    scheme: str
    host: str
    port: int | None
    path: str
    options: Mapping[str, str]

    def number(self, option: str, default: float, low: float, high: float) -> float:
        """Return an option as a number within bounds. Raises LinkAddressError."""
        text = self.options.get(option)
        if text is None:
            return default
        try:
            value = float(text)
        except ValueError:
            value = low - 1.0
        if not low <= value <= high:
            raise LinkAddressError(
                f"{self.url}: {option}={text}: a number from {low:g} to {high:g} is needed"
            )
        return value


@dataclass(frozen=True, slots=True)
class LinkRow:
    """One scheme. ``module`` has ``open_url(name, address) -> Link``, and ``settings(address)``,
    which returns the parts of an address that it uses. Both raise LinkAddressError."""

    module: str
    example: str
    options: tuple[str, ...] = ()
    rate: str = ""  # the option that sets the line's bit rate; "" if there is none


_ADMISSION = ("allow", "connections", "each", "idle", "handshake", "viewers")  # links.admission

LINKS: dict[str, LinkRow] = {
    "serial": LinkRow("links.serial", "serial:///dev/ttyUSB0?baud=9600", ("baud",), "baud"),
    "tcp": LinkRow("links.tcp", "tcp://192.168.1.10:9000"),
    "tcp-listen": LinkRow("links.tcp", "tcp-listen://127.0.0.1:9000", _ADMISSION),
    "tls": LinkRow("links.tls", "tls://192.168.1.10:9000?keys=keys/boat", ("keys", "handshake")),
    "tls-listen": LinkRow(
        "links.tls", "tls-listen://0.0.0.0:9000?keys=keys/vehicle", ("keys", *_ADMISSION)
    ),
    "memory": LinkRow("links.memory", "memory://name?delay=0.1&baud=9600", ("delay", "baud")),
    "acoustic": LinkRow(
        "links.acoustic",
        "acoustic://bay?range=1000&rate=1000&loss=0.1",
        ("range", "rate", "loss", "errors", "seed"),
    ),
    "can": LinkRow(
        "links.can",
        "can://can0?bitrate=500000",
        ("interface", "bitrate", "sensors", "baud"),
        "bitrate",
    ),
}


def parse_address(url: str) -> Address:
    """Parse a link's URL. Raises LinkAddressError."""
    parts = urlsplit(url)
    row = LINKS.get(parts.scheme)
    if row is None:
        known = ", ".join(row.example for row in LINKS.values())
        raise LinkAddressError(f"{url!r} is no link's URL; possible are {known}")
    try:
        port = parts.port
    except ValueError:
        raise LinkAddressError(f"{url}: the port must be a number from 0 to 65535") from None
    options = dict(parse_qsl(parts.query, keep_blank_values=True))
    unknown = sorted(set(options) - set(row.options))
    if unknown:
        allowed = ", ".join(row.options) or "none"
        raise LinkAddressError(f"{url}: unknown option {unknown[0]!r}; there are: {allowed}")
    return Address(url, parts.scheme, parts.hostname or "", port, parts.path, options)


def baud_of(url: str, otherwise: float) -> float:
    """The baud rate in a link's URL; ``otherwise`` if it has none, or is not a link's URL."""
    try:
        return parse_address(url).number("baud", otherwise, 1.0, 1e9)
    except LinkAddressError:
        return otherwise


def at_rate(url: str, bits_per_s: int) -> str:
    """Add the bit rate to the URL, if its scheme has a rate and the URL does not set it."""
    scheme, _, rest = url.partition("://")
    option = LINKS[scheme].rate if scheme in LINKS else ""
    if not option or f"{option}=" in rest.partition("?")[2]:
        return url
    return f"{url}{'&' if '?' in rest else '?'}{option}={bits_per_s}"


def check_url(url: str) -> None:
    """Raise LinkAddressError if the URL could never be opened, whatever is plugged in."""
    address = parse_address(url)
    importlib.import_module(LINKS[address.scheme].module).settings(address)


def open_link(name: str, url: str) -> Link:
    """Open a link under ``name``. Raises LinkAddressError, LinkBusy or LinkAbsent."""
    address = parse_address(url)
    module = importlib.import_module(LINKS[address.scheme].module)
    open_url: Callable[[str, Address], Link] = module.open_url
    return open_url(name, address)
