"""The shipped missions and vehicles, by name."""

from __future__ import annotations

from pathlib import Path

from mission.model.diagnostics import Stage, whole
from mission.model.vehicle import Vehicle, VehicleError
from mission.model.vehicle_file import LONGEST, read_vehicle


def missions_folder() -> Path:
    """Return the shipped missions/: inside the package in a wheel, beside it in a checkout."""
    here = Path(__file__).resolve().parents[1]
    shipped = here / "missions"
    return shipped if shipped.is_dir() else here.parent / "missions"


def shipped_missions() -> dict[str, Path]:
    """Return the missions of the AUV and, from the folder others/, of other vehicles, by name."""
    folder = missions_folder()
    found = (*folder.glob("*.yaml"), *(folder / "others").glob("*.yaml"))
    return {path.stem: path for path in sorted(found, key=lambda path: path.stem)}


def shipped_vehicles() -> list[str]:
    return sorted(path.stem for path in (missions_folder() / "vehicles").glob("*.yaml"))


def vehicle_file(name: str | Path) -> Path:
    """Return the path for the name of a shipped vehicle; a path is returned as it is."""
    path = Path(name)
    if path.suffix in (".yaml", ".yml"):
        return path
    return missions_folder() / "vehicles" / f"{name}.yaml"


def load_vehicle(name: str | Path) -> Vehicle:
    """Load a vehicle by the name of a shipped file or by path. Raises VehicleError."""
    path = vehicle_file(name)
    try:
        with path.open(encoding="utf-8") as file:
            text = file.read(LONGEST + 1)
    except FileNotFoundError:
        missed = f"no vehicle file {path}" if path == Path(name) else f"no such vehicle: {name}"
        hint = f"shipped ones: {', '.join(shipped_vehicles())}; or give a file, .yaml or .yml"
        raise _unreadable(missed, hint) from None
    except (OSError, UnicodeDecodeError) as error:
        raise _unreadable(f"{path}: cannot be read: {error}", "give a vehicle file") from error
    return read_vehicle(text, str(path))


def _unreadable(message: str, hint: str) -> VehicleError:
    return VehicleError([whole("unreadable", message, hint, Stage.VEHICLE)])
