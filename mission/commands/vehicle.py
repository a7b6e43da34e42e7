"""``auvmission vehicle``: simulate a vehicle to practise with, as a process of its own."""

from __future__ import annotations

import signal
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import AS_JSON, PROFILE, SEED, SETTINGS, VEHICLE_NAME
from mission.commands.output import refuse_unwritable

if TYPE_CHECKING:
    from links.simulated.pty import Simulated

BUS = "can://239.74.163.2?interface=udp_multicast"
MARK = "# Written by auvmission vehicle"


@click.command()
@click.argument("name", type=VEHICLE_NAME, metavar="[VEHICLE]", default="auv")
@PROFILE
@SEED
@SETTINGS
@click.option("--speed", type=click.FloatRange(0.1, 20.0), default=1.0, show_default=True,
              help="Times real time; serve needs the same.")  # fmt: skip
@click.option("--position", "place", metavar="LAT,LON",
              help="Where it lies at the beginning, in degrees.")  # fmt: skip
@click.option("--port", type=click.IntRange(0, 65535), default=4000, show_default=True,
              help="Of its serve for the boat, the next one for viewers; 0: free.")  # fmt: skip
@click.option("--modem", metavar="URL", help="Of its acoustic modem, e.g. one end of `water`.")
@click.option("--bus", metavar="URL",
              help="The CAN bus of mainboard and motorboards; two at a time need one each, e.g. "
                   "can://239.74.163.9:43119?interface=udp_multicast.")  # fmt: skip
@click.option("--folder", type=click.Path(path_type=Path, file_okay=False),
              help="For serve.yaml, the ports, serve; default: out/VEHICLE.")  # fmt: skip
@click.option("--track", type=click.Path(path_type=Path, dir_okay=False),
              help="Write its true track here in the end.")  # fmt: skip
@AS_JSON
def vehicle(
    name: str,
    profile: str | None,
    seed: int,
    settings: tuple[str, ...],
    speed: float,
    place: str | None,
    port: int,
    modem: str | None,
    bus: str | None,
    folder: Path | None,
    track: Path | None,
    as_json: bool,
) -> None:
    """Simulate a vehicle (auv, coreboard, rov, robot, mainboard, motorboards) on ports made here.

    Its board is at FOLDER/vehicle, the AUV's GPS receiver at FOLDER/gps, and sensors that --set
    adds at FOLDER/sensors, as if plugged in. FOLDER/serve.yaml is a configuration for them. Then
    run serve and the commands of the boat in other terminals. Ctrl-C ends it. The motor boards are
    on a CAN bus: by default one by UDP multicast, which needs neither hardware nor root.
    """
    from links.base import LinkError
    from links.simulated.boards import ON_BUS, SimulatedBoard
    from links.simulated.process import position, serve, serve_on_bus
    from links.simulated.pty import ports as ports_of
    from links.simulated.settings import SettingError

    try:
        made = _made(name, profile, seed, settings, position(place))
    except (SettingError, ValueError) as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    if track is not None:
        refuse_unwritable(track)
    on_bus = made if isinstance(made, SimulatedBoard) and made.name in ON_BUS else None
    config = _room(where := (folder or Path("out") / Path(name).stem).resolve())

    def ready(*paths: str) -> None:
        ports = (
            _plugged(where, ports_of(made), paths)
            if on_bus is None
            else {"vehicle": _on_bus(bus or BUS, paths)}
        )
        viewers = port + 1 if 0 < port < 65535 else 0
        urls = {"gps": None, **ports, "topside": f"tcp://127.0.0.1:{port}", "modem": modem,
                "monitor": f"tcp-listen://127.0.0.1:{viewers}"}  # fmt: skip
        config.write_text(_configuration(name, where, urls), encoding="utf-8")
        _tell(name, config, ports, port, speed, as_json)

    try:
        if on_bus is None:
            told = serve(made, speed, ready, track)
        else:
            told = serve_on_bus(on_bus, bus or BUS, speed, ready, track)
    except LinkError as error:
        click.echo(str(error), err=True)
        raise SystemExit(1) from None
    finally:
        for label in ports_of(made):
            (where / label).unlink(missing_ok=True)
    if told == signal.SIGINT:
        raise KeyboardInterrupt


def _made(
    name: str, profile: str | None, seed: int, texts: tuple[str, ...], place: tuple[float, float]
) -> Simulated:
    """The simulated vehicle. Raises ValueError."""
    from links.simulated.settings import parse_settings
    from mission.model.shipped import load_vehicle
    from mission.verification.rig.vehicle import in_dialect, simulated

    loaded = in_dialect(load_vehicle(name), profile)
    settings = parse_settings(texts)
    return simulated(loaded, seed, settings, position=place, start=datetime.now(UTC))


def _room(folder: Path) -> Path:
    """Make the folder; return the path of its configuration. Exit 2 if that is another's."""
    config = folder / "serve.yaml"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if config.exists() and not config.read_text(encoding="utf-8").startswith(MARK):
            raise click.UsageError(f"{config} is not of a simulated vehicle: give another --folder")
    except OSError as error:
        raise click.UsageError(f"{folder}: {error.strerror or error}") from None
    return config


def _on_bus(bus: str, paths: tuple[str, ...]) -> str:
    """The bus's URL, with the line of the sensor board if there is one."""
    return "".join((bus, *(f"{'&' if '?' in bus else '?'}sensors={path}" for path in paths)))


def _plugged(folder: Path, names: tuple[str, ...], paths: tuple[str, ...]) -> dict[str, str]:
    """Link the ports to fixed names in ``folder``. Return their URLs by name."""
    ports = {}
    for label, path in zip(names, paths, strict=True):
        (folder / label).unlink(missing_ok=True)
        (folder / label).symlink_to(path)
        ports[label] = f"serial://{folder / label}"
    return ports


def _configuration(name: str, folder: Path, urls: Mapping[str, str | None]) -> str:
    import json

    file = str(Path(name).resolve()) if Path(name).is_file() else name
    return (
        f"{MARK}: the configuration of its serve.\n"
        f"vehicle: {json.dumps(file)}\n"
        f"folder: {json.dumps(str(folder / 'pi'))}\n"
        f"links: {json.dumps(urls)}\n"
    )


def _tell(
    name: str, config: Path, ports: dict[str, str], port: int, speed: float, as_json: bool
) -> None:
    import json
    import time

    if as_json:
        click.echo(json.dumps({**ports, "config": str(config), "wall": time.time()}))
        return
    factor = "" if speed == 1.0 else f" --speed {speed:g}"
    click.echo(f"simulated {name}: {', '.join(ports.values())}")
    click.echo(f"  auvmission serve -c {config}{factor}")
    click.echo(f"  auvmission status --to tcp://127.0.0.1:{port}")
