"""A server of Foxglove's WebSocket protocol. Clients can only subscribe.

The protocol stores nothing for late clients. So the server sends the last message, and the newest
lines of the journal, again to each new subscriber. The package foxglove-sdk (an extra) implements
the protocol.
"""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Iterable
from typing import Any

from mission.onboard.blackbox.form import NS, schema_text
from mission.onboard.stream import topics
from mission.onboard.stream.derived import Message

KEPT_LINES = 200  # lines of the journal
_BACKLOG = 4096  # messages that wait for one client: older ones are dropped


class Server:
    """Raises ImportError without the extra, OSError or RuntimeError if the port is in use."""

    def __init__(self, host: str, port: int, names: Iterable[str]) -> None:
        import foxglove

        self._context = context = foxglove.Context()  # a reference to it keeps the channels open
        self._channels = {name: _channel(foxglove, context, name) for name in names}
        self._names = {channel.id(): name for name, channel in self._channels.items()}
        self._kept: dict[str, deque[tuple[bytes, int]]] = {
            name: deque(maxlen=KEPT_LINES if name == topics.JOURNAL else 1)
            for name in self._channels
        }
        self._lock = threading.Lock()
        self._server = foxglove.start_server(
            name="auvmission",
            host=host,
            port=port,
            capabilities=[foxglove.websocket.Capability.Time],
            server_listener=_listener(foxglove, self),
            context=context,
            message_backlog_size=_BACKLOG,
        )

    @property
    def port(self) -> int:
        return int(self._server.port)

    def send(self, message: Message, wall: float) -> None:
        """``wall``: the time at which it is shown, s since 1970 UTC."""
        data = json.dumps(message.value, separators=(",", ":"), allow_nan=False).encode()
        at = round(wall * NS)
        with self._lock:
            self._kept[message.topic].append((data, at))
            self._channels[message.topic].log(data, log_time=at)

    def time(self, wall: float) -> None:
        """Send the current time if it is not the real one: of a dive that is played."""
        self._server.broadcast_time(round(wall * NS))

    def again(self, channel: int, client: int) -> None:
        """Send the stored messages to a new subscriber."""
        name = self._names.get(channel)
        if name is None:
            return
        with self._lock:
            for data, at in self._kept[name]:
                self._channels[name].log(data, log_time=at, sink_id=client)

    def close(self) -> None:
        self._server.stop()


def _listener(foxglove: Any, server: Server) -> Any:
    class Listener(foxglove.websocket.ServerListener):  # type: ignore[misc]
        def on_subscribe(self, client: Any, channel: Any) -> None:
            server.again(channel.id, client.id)

    return Listener()


def _channel(foxglove: Any, context: Any, name: str) -> Any:
    topic = topics.TOPICS[name]
    data = schema_text(topic)
    schema = foxglove.Schema(name=topic.schema_name, encoding="jsonschema", data=data)
    said = dict(topic.metadata)
    return foxglove.Channel(
        name, schema=schema, message_encoding="json", context=context, metadata=said
    )
