"""The console under water: one line, on which X goes before all."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest
from console_world import Page, console_of, heard, said
from programs import process
from served import TEXT, soon

pytestmark = pytest.mark.proof


def test_a_vehicle_under_water_is_watched_uploaded_to_and_stopped(tmp_path: Path) -> None:
    ready = tmp_path / "ready.json"
    water = ("--range", "150", "--rate", "20000", "--folder", str(tmp_path / "water"))
    with process("water", *water, "--json") as channel:
        assert channel.stdout is not None
        ends = json.loads(channel.stdout.readline())
        place = ("--folder", str(tmp_path / "auv"), "--modem", ends["vehicle"], "--port", "0")
        with process("vehicle", "auv", *place, "--json") as sea:
            assert sea.stdout is not None
            config = json.loads(sea.stdout.readline())["config"]
            with (
                process("serve", "-c", config, "--ready-file", str(ready)),
                console_of(ends["boat"], tmp_path / "boat") as (console, vehicle),
            ):
                soon(ready.exists, "serve")
                dive(console, vehicle.under_water)


def dive(console: object, under_water: bool) -> None:
    assert under_water
    with (
        console.socket("frames") as frames,  # type: ignore[attr-defined]
        console.socket("commands") as commands,  # type: ignore[attr-defined]
        console.socket("orders") as orders,  # type: ignore[attr-defined]
        console.socket("stick") as stick,  # type: ignore[attr-defined]
    ):
        page = Page(frames)
        page.until(lambda s: s.get("state") == "idle/empty", "a look by modem")
        (about,) = console.get("/api/setup")["vehicles"]  # type: ignore[attr-defined]
        assert (about["source"], about["under_water"]) == ("frames", True)
        said(stick, surge=1.0, turn=0.0, heave=0.0)
        assert "modem" in heard(stick, "refused")["says"]
        said(commands, do="upload", text=TEXT, source="pool.mission")
        done = heard(commands, "acknowledged", "refused", "unanswered")
        assert done["is"] == "acknowledged", done
        said(orders, do="stop", at=time.time() - 100.0)
        assert heard(orders, "acknowledged", "unanswered")["is"] == "acknowledged"
        page.until(lambda s: s.get("state") == "emergency/stopped", "stopped")
        assert page.state["plan"] == page.state["mission"]  # it was uploaded from here
