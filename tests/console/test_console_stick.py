"""The stick of a page: what it takes until it moves anything again."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mission.console.line import Line
from mission.console.steering import FRESH_S, Steering
from mission.topside.helm import Push
from protocol.messages import StateReport

AHEAD = Push(surge=1.0)
NOTHING = StateReport("idle/ready", "asker", *(None,) * 9, alarms=0, setpoint="", leg="")


class Answered(Line):
    """By a vehicle that is commanded from here."""

    def __init__(self) -> None:
        super().__init__("tcp://127.0.0.1:1")
        self.state = replace(NOTHING)

    def silence(self, now: float) -> float | None:
        return 0.1


@pytest.fixture
def steering() -> Steering:
    return Steering(Answered())


def pushed(steering: Steering, now: float, page: str = "page") -> str:
    steering.axes(page, AHEAD, now, now)
    return str(steering.told(page, now)["is"])


def test_a_page_that_was_silent_behind_an_order_has_not_let_go(steering: Steering) -> None:
    assert pushed(steering, 10.0) == "driving"
    steering.drop()
    steering.hold(10.0 + 2 * FRESH_S)
    assert pushed(steering, 12.0) == "refused"
    steering.axes("page", None, 12.1, 12.1)
    assert pushed(steering, 12.2) == "driving"


def test_a_page_that_is_gone_has_let_go(steering: Steering) -> None:
    assert pushed(steering, 10.0) == "driving"
    steering.drop()
    assert steering.told("other", 10.0)["is"] == "refused"
    steering.let_go("page")
    assert pushed(steering, 10.2, "other") == "driving"


def test_an_order_given_while_no_axes_came_is_told_with_the_next(steering: Steering) -> None:
    assert pushed(steering, 10.0) == "driving"
    steering.hold(10.0 + 2 * FRESH_S)
    steering.drop()
    assert pushed(steering, 12.0) == "refused"
    steering.hold(12.0 + 2 * FRESH_S)
    assert pushed(steering, 14.0) == "refused"
    steering.axes("page", None, 14.1, 14.1)
    assert pushed(steering, 14.2) == "driving"
