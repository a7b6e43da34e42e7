"""What serve starts with, even if the configuration is broken: it may have a vehicle to surface.

    configuration, vehicle file, store are good       --> these
    the store is broken                               --> a store that keeps nothing, and does not
                                                          know what was under way
    configuration or vehicle file are broken, and
       nothing was under way                          --> Unusable: the operator has to repair them
       something was, or may have been                --> the last that worked (working), else the
                                                          shipped ones; for an ascent alone

``ascent_only``: no mission is accepted, and none starts. With an old configuration the operator's
port is on loopback, because a revoked key or an old list of addresses must not come back.

What does not live here: the ascent (engine), the files themselves (configuration, vehicle, store,
working).
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from links import LinkAddressError, check_url, parse_address
from links.base import LinkError
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle, VehicleError
from mission.onboard.configuration import (
    Configuration,
    ConfigurationError,
    LinkUrls,
    load_configuration,
)
from mission.onboard.kept import Homes
from mission.onboard.rates import rated
from mission.onboard.serve.listening import listening
from mission.onboard.serve.working import Working, find, keep
from mission.onboard.store import DiskStore, LostStore, Store, StoreError

BUILT_IN = "auv"
TOPSIDE_PORT = 4000
_NEEDED = ("vehicle", "gps", "topside", "modem")


class Unusable(ValueError):
    """The operator must act; nothing was under way that would have to surface."""


@dataclass(frozen=True, slots=True)
class Provision:
    """``faults``: what is broken, as text; ``damage``: what of the store is."""

    configuration: Configuration
    vehicle: Vehicle
    store: Store
    homes: Homes
    faults: tuple[str, ...] = ()
    damage: tuple[str, ...] = ()

    def keep(self) -> None:
        """Keep a configuration that worked, but not one for an ascent alone. Raises OSError."""
        if not self.configuration.ascent_only:
            keep(Working(self.configuration, self.vehicle), self.homes)


def provide(
    config: Path | None,
    given: Mapping[str, str | None],
    folder: Path | None,
    environment: Mapping[str, str] = os.environ,
) -> Provision:
    """Return what serve starts with. ``given``: the command line's links, by name. Raises
    Unusable."""
    homes = Homes(config, folder, environment)
    faults: list[str] = []
    configuration, named = _configuration(config, given, folder, faults)
    vehicle = _vehicle(named, faults)
    if configuration is None or vehicle is None:
        configuration, vehicle, store = _fall_back(configuration, given, homes, faults)
    else:
        store = _store(configuration.store)
    if isinstance(store, LostStore):
        faults.append(store.why)
    configuration = rated(configuration, vehicle)
    return Provision(configuration, vehicle, store, homes, tuple(faults), store.content.damage)


def _configuration(
    config: Path | None,
    given: Mapping[str, str | None],
    folder: Path | None,
    faults: list[str],
) -> tuple[Configuration | None, str]:
    """Return the configuration, None if broken, and the vehicle that it names: a fault of the
    vehicle file is reported as well."""
    named = [BUILT_IN]

    def judge(key: tuple[str, ...], value: Any) -> None:
        if key == ("vehicle",):
            named.append(value)
        elif key[0] == "links" and value is not None and not given.get(key[1]):
            _check(key[1], value)

    try:
        faults += _wrong(given)
        read = load_configuration(config, judge)
    except ConfigurationError as error:
        faults.append(error.brief)
    except Exception as error:  # a missing library, a user without a home
        faults.append(f"the configuration cannot be read: {type(error).__name__}: {error}")
    else:
        if not faults:
            links = _with(read.links, given)
            return replace(read, links=links, folder=folder or read.folder), named[-1]
    return None, named[-1]


def _vehicle(name: str, faults: list[str]) -> Vehicle | None:
    try:
        return load_vehicle(name)
    except VehicleError as error:
        faults.append(error.brief)
    except Exception as error:
        faults.append(f"the vehicle file {name} cannot be read: {type(error).__name__}: {error}")
    return None


def _store(folder: Path) -> Store:
    try:
        return DiskStore(folder)
    except StoreError as error:
        return LostStore(str(error))


def _fall_back(
    configuration: Configuration | None,
    given: Mapping[str, str | None],
    homes: Homes,
    faults: list[str],
) -> tuple[Configuration, Vehicle, Store]:
    kept = find(homes)
    base = configuration or _old(kept, given, homes)
    known = configuration is not None or kept is not None or homes.folder is not None
    store = _left_behind(base.store, known)
    if not store.content.under_way:
        raise Unusable("\n".join(faults))
    vehicle = kept.vehicle if kept is not None else load_vehicle(BUILT_IN)
    why = f"serve brings the vehicle up, and nothing else: {faults[0].splitlines()[0]}"
    return replace(base, ascent_only=why), vehicle, store


def _old(kept: Working | None, given: Mapping[str, str | None], homes: Homes) -> Configuration:
    base = kept.configuration if kept is not None else Configuration()
    sound = {name: url for name, url in given.items() if url and _opens(name, url)}
    links = _with(base.links, sound)
    return replace(
        base,
        links=replace(links, topside=f"tcp-listen://127.0.0.1:{_port(links.topside)}"),
        folder=homes.folder or base.folder,
        camera=None,
        set_system_clock=False,
    )


def _left_behind(folder: Path, known: bool) -> Store:
    """Open the store if there is one. Create none, so that the next start finds none, either."""
    if os.path.lexists(folder):
        return _store(folder)
    if known:
        return LostStore(f"there is no store {folder}", under_way="")
    return LostStore("nobody knows where the store is")


def _with(links: LinkUrls, given: Mapping[str, str | None]) -> LinkUrls:
    urls = {n: None if n == "gps" and u == "none" else u for n, u in given.items() if u}
    return replace(links, **urls)  # type: ignore[arg-type]


def _check(name: str, url: str) -> None:
    """Check a URL without which serve does not begin (_NEEDED). Raises LinkError."""
    if name in _NEEDED:
        check_url(listening(url) if name == "topside" else url)


def _wrong(given: Mapping[str, str | None]) -> list[str]:
    """The faults of links of the command line that can never be opened."""
    found = []
    for name, url in given.items():
        try:
            if url and (name, url) != ("gps", "none"):
                _check(name, url)
        except LinkError as error:
            found.append(f"--{name}: {error}")
    return found


def _opens(name: str, url: str) -> bool:
    return not _wrong({name: url})


def _port(topside: str) -> int:
    try:
        return parse_address(listening(topside)).port or 0
    except LinkAddressError:
        return TOPSIDE_PORT
