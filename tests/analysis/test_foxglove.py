"""Laws of what Foxglove is served: by its own protocol, every topic by its schema, nothing lost."""

from __future__ import annotations

import json
import math
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner
from recorded_flight import recorded
from served import PATIENCE, running, silent_board, soon
from websockets import Subprotocol
from websockets.sync.client import ClientConnection, connect

from mission.analysis.foxglove import live, playing
from mission.analysis.foxglove.layout import layout
from mission.analysis.foxglove.serving import Server
from mission.analysis.journal import recordings
from mission.analysis.replay.playback import Playback
from mission.commands.foxglove import foxglove
from mission.model import Record
from mission.navigation.distribution import PLANE_95
from mission.onboard.stream import topics
from mission.onboard.stream.derived import Message
from mission.topside.monitor import Watched

SHORT = Path(__file__).parent / "recorded" / "short-time.mcap"


@pytest.fixture(scope="module")
def dive() -> list[Message]:
    (items,) = recordings([SHORT])
    return list(playing.messages(items))


@pytest.fixture(scope="module")
def watched() -> list[Message]:
    """The same dive, as a viewer of its monitor would have seen it."""
    (items,) = recordings([SHORT])
    played = Playback([item for item in items if isinstance(item, Record)])
    seen, made, told = Watched(), live.Live(), list[Message]()
    t = 0.0
    while not played.over:
        t += 2.0
        frames, answers = seen.receive(played.until(t), t)
        played.answer(answers)
        for frame in frames:
            told += made.receive(seen, frame, 1e9 + t)
    return told


@contextmanager
def serving(names: tuple[str, ...]) -> Iterator[tuple[Server, str]]:
    server = Server("127.0.0.1", 0, names)
    try:
        yield server, f"ws://127.0.0.1:{server.port}"
    finally:
        server.close()


def joined(url: str) -> ClientConnection:
    return connect(url, subprotocols=[Subprotocol("foxglove.sdk.v1")])


class Viewer:
    """It knows the protocol, and nothing of ours."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self.info = json.loads(socket.recv(PATIENCE))
        self.channels: dict[int, dict[str, Any]] = {}
        while not self.channels:
            said = json.loads(socket.recv(PATIENCE))
            if said["op"] == "advertise":
                self.channels = {one["id"]: one for one in said["channels"]}

    def subscribe(self, last: str = "") -> None:
        """To all; to the topic ``last`` behind the others."""
        numbers = sorted(self.channels, key=lambda number: self.channels[number]["topic"] == last)
        wanted = [{"id": number, "channelId": number} for number in numbers]
        self._socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))

    def next(self) -> tuple[str, float, Any]:
        """Topic, time in s, and the message, which its own schema allows."""
        while True:
            said = self._socket.recv(PATIENCE)
            if isinstance(said, bytes) and said[0] == 1:
                number, t = struct.unpack_from("<IQ", said, 1)
                channel, value = self.channels[number], json.loads(said[13:])
                assert (channel["encoding"], channel["schemaEncoding"]) == ("json", "jsonschema")
                jsonschema.validate(value, json.loads(channel["schema"]))
                return channel["topic"], t / 1e9, value


@pytest.mark.proof
def test_a_client_of_the_protocol_decodes_every_topic_by_its_schema(tmp_path: Path) -> None:
    (items,) = recordings([recorded(tmp_path / "dive.mcap", "first-dive.yaml", "doppler=0.03")])
    first = {message.topic: message for message in reversed(list(playing.messages(items)))}
    assert set(first) == set(playing.TOPICS)
    with serving(playing.TOPICS) as (server, url), joined(url) as socket:
        viewer = Viewer(socket)
        assert {one["topic"] for one in viewer.channels.values()} == set(playing.TOPICS)
        viewer.subscribe()
        for topic, message in first.items():
            server.send(message, 1e9 + message.t)
            while (got := viewer.next())[0] != topic:
                pass
            assert got[1] == pytest.approx(1e9 + message.t, abs=1e-6)
            assert got[2] == json.loads(json.dumps(message.value))


def test_who_comes_later_is_told_what_was_said_once_and_nobody_else_is_told_again(
    dive: list[Message],
) -> None:
    plan = next(message for message in dive if message.topic == topics.PLAN)
    lines = [message for message in dive if message.topic == topics.JOURNAL][:5]
    with serving(playing.TOPICS) as (server, url), joined(url) as early:
        first = Viewer(early)
        first.subscribe(last=topics.STATE)
        state = next(message for message in dive if message.topic == topics.STATE)
        server.send(state, state.t)
        assert first.next()[0] == topics.STATE, "it is subscribed to the others, too"
        for message in (*lines, plan):
            server.send(message, message.t)
        told = [first.next()[0] for _ in range(6)]
        with joined(url) as late:
            second = Viewer(late)
            second.subscribe()
            kept = [said for said in (second.next() for _ in range(7)) if said[0] != topics.STATE]
        server.send(lines[0], 99.0)
        told.append(first.next()[0])
    assert sorted(one[0] for one in kept) == sorted([topics.PLAN, *[topics.JOURNAL] * 5])
    assert [one[2]["message"] for one in kept if one[0] == topics.JOURNAL] == [
        line.value["message"] for line in lines
    ]
    assert sorted(told) == sorted([topics.PLAN, *[topics.JOURNAL] * 6])


def test_no_client_is_offered_to_say_anything() -> None:
    with serving(playing.TOPICS) as (_, url), joined(url) as socket:
        assert Viewer(socket).info["capabilities"] == ["time"]


def test_what_a_monitor_tells_has_the_topics_and_schemas_of_the_black_box(
    watched: list[Message],
) -> None:
    assert {message.topic for message in watched} == set(live.TOPICS)
    for topic in live.TOPICS:
        judge = jsonschema.Draft202012Validator(topics.TOPICS[topic].schema)
        for message in [message for message in watched if message.topic == topic][:50]:
            judge.validate(message.value)


def test_a_monitor_tells_the_same_of_a_dive_as_its_black_box(
    watched: list[Message], dive: list[Message]
) -> None:
    def states(messages: list[Message]) -> list[str]:
        said = [m.value["state"] for m in messages if m.topic == topics.STATE and m.value["state"]]
        return [state for i, state in enumerate(said) if i == 0 or said[i - 1] != state]

    lasting = [state for state in states(dive) if state in states(watched)]
    assert lasting == states(watched)
    assert len(lasting) > 3
    last = {
        name: next(m.value for m in reversed(told) if m.topic == topics.STATE)
        for name, told in (("live", watched), ("box", dive))
    }
    for name in ("depth_m", "latitude_deg", "longitude_deg", "radius_95_m", "to_radius_m"):
        assert last["live"][name] == pytest.approx(last["box"][name], abs=0.11), name
    spread = {
        name: next(m.value for m in reversed(told) if m.topic == topics.POSITION)
        for name, told in (("live", watched), ("box", dive))
    }
    a, b = (spread[name]["position_covariance"] for name in ("live", "box"))
    assert a == pytest.approx(b, rel=0.1, abs=0.5)


def test_a_monitor_tells_the_fixes_and_poses_that_the_black_box_has(
    watched: list[Message], dive: list[Message]
) -> None:
    for topic in (topics.FIX, topics.FIXES):
        live_, box = ([m for m in told if m.topic == topic] for told in (watched, dive))
        by_time = {round(m.t, 6): dict(m.value) for m in box}
        assert len(live_) > 3
        for message in live_:
            wanted, got = by_time[round(message.t, 6)], dict(message.value)
            if topic == topics.FIXES:  # at the time of the viewer's computer
                assert wanted.pop("timestamp")
                assert got.pop("timestamp")
                spread = got.pop("position_covariance")
                assert spread == pytest.approx(wanted.pop("position_covariance"), abs=1e-3)
            same = {name: pytest.approx(v, abs=1e-4) if isinstance(v, float) else v
                    for name, v in wanted.items()}  # fmt: skip
            assert got == same
    poses, box = ([m for m in told if m.topic == topics.POSE] for told in (watched, dive))
    assert len(poses) > 10
    for message in poses[5:]:
        near = min(box, key=lambda one: abs(one.t - message.t)).value["pose"]
        here = message.value["pose"]
        for axis in "xyz":
            assert here["position"][axis] == pytest.approx(near["position"][axis], abs=2.5)
        turned = sum(here["orientation"][a] * near["orientation"][a] for a in "xyzw")
        assert abs(turned) > 0.98


def test_the_ellipse_of_a_monitor_lies_on_the_map_as_it_lies_on_the_sea() -> None:
    """20 m towards 30 degrees, 5 m across: so much along each, and nothing between them."""
    state = {
        "state": "idle/ready",
        "latitude": 30.0,
        "longitude": 120.0,
        "ellipse": [20.0, 5.0, 30.0],
    }
    seen, frame = Watched(), {"n": 1, "t": 2.0, "state": state}
    seen.take(frame, 2.0)
    (place,) = [
        m.value for m in live.Live().receive(seen, frame, 1e9) if m.topic == topics.POSITION
    ]
    ee, ne, _, _, nn = place["position_covariance"][:5]
    spread = np.array([[nn, ne], [ne, ee]])
    along = np.array([math.cos(math.radians(30.0)), math.sin(math.radians(30.0))])
    across = np.array([-along[1], along[0]])
    assert PLANE_95 * math.sqrt(along @ spread @ along) == pytest.approx(20.0)
    assert PLANE_95 * math.sqrt(across @ spread @ across) == pytest.approx(5.0)
    assert along @ spread @ across == pytest.approx(0.0, abs=1e-9)


def fields(schema: dict[str, Any], path: str) -> bool:
    for name in path.split("."):
        schema = schema.get("properties", {}).get(name)
        if schema is None:
            return False
    return True


def test_every_topic_and_field_of_the_layout_exists() -> None:
    panels = layout()["configById"]
    paths = [one["value"] for panel in panels.values() for one in panel.get("paths", ())]
    assert len(paths) > 10
    for path in paths:
        topic, _, field = path.partition(".")
        assert fields(topics.TOPICS[topic].schema, field), path
    shown = panels["Map!place"]
    named = [*shown["topicConfig"], shown["followTopic"]]
    assert {topics.TOPICS[name].schema_name for name in named} <= {
        "foxglove.LocationFix",
        "foxglove.GeoJSON",
    }
    assert topics.TOPICS[panels["RosOut!log"]["topicToRender"]].schema_name == "foxglove.Log"
    assert panels["RawMessages!state"]["topicPath"] in topics.TOPICS


def test_the_layout_shows_every_panel_once() -> None:
    def leaves(part: Any) -> list[str]:
        if isinstance(part, str):
            return [part]
        assert 0.0 < part["splitPercentage"] < 100.0
        return [*leaves(part["first"]), *leaves(part["second"])]

    assert sorted(leaves(layout()["layout"])) == sorted(layout()["configById"])


def test_the_layout_is_a_file_and_what_is_no_black_box_is_refused(tmp_path: Path) -> None:
    ran = CliRunner().invoke(foxglove, ["--layout", str(tmp_path / "dive.json")])
    assert ran.exit_code == 0, ran.output
    assert json.loads((tmp_path / "dive.json").read_text()) == layout()
    (tmp_path / "notes.txt").write_text("no black box")
    for words, code, says in (
        (["--to", str(tmp_path / "notes.txt")], 2, "no black box"),
        (["--to", str(SHORT), "--listen", "here"], 2, "no HOST:PORT"),
        (["--to", "tcp://127.0.0.1:9"], 1, "127.0.0.1:9"),
        (["--layout", str(tmp_path / "no" / "dive.json")], 2, "cannot be written"),
    ):
        ran = CliRunner().invoke(foxglove, words)
        assert (ran.exit_code, says in ran.output) == (code, True), ran.output


def test_a_dive_is_played_at_its_speed_and_ends_when_it_is_told_to() -> None:
    ran = CliRunner().invoke(
        foxglove, ["--to", str(SHORT), "--listen", "127.0.0.1:0", "--speed", "500", "--for", "0.5"]
    )
    assert ran.exit_code == 0, ran.output
    assert ran.stdout.startswith("viewers connect to ws://127.0.0.1:")


@pytest.mark.proof
def test_a_vehicle_under_way_is_served_from_its_monitor(tmp_path: Path) -> None:
    with (
        silent_board() as (_, board),
        running(tmp_path, f"serial://{board}", monitor="tcp://127.0.0.1:0") as pi,
    ):
        assert pi.server is not None
        viewing: Any = pi.server.viewing
        soon(lambda: viewing.port.link is not None, "the monitor's port")
        words = ["--to", f"tcp://127.0.0.1:{viewing.port.link.port}", "--listen", "127.0.0.1:0"]
        command = [sys.executable, "-m", "mission", "foxglove", *words]
        served = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            assert served.stdout is not None
            with joined(served.stdout.readline().split()[-1]) as socket:
                viewer = Viewer(socket)
                assert {one["topic"] for one in viewer.channels.values()} == set(live.TOPICS)
                viewer.subscribe()
                assert _state_of(viewer) == "idle/empty"
                with pi.boat() as boat:
                    boat.sendall(b"@ZAX0$")
                    while _state_of(viewer) != "emergency/stopped":
                        pass
        finally:
            served.terminate()
            served.communicate()


def _state_of(viewer: Viewer) -> str:
    """As it is told next."""
    while (told := viewer.next())[0] != topics.STATE:
        pass
    return str(told[2]["state"])
