"""Pictures of every view of the cockpit in three sizes, of the real program in a real Chromium.

python tests/console/pictures.py      into docs/pictures/cockpit, where the site takes them

They have so few colours because they are kept with the code. Look at each before it is.
"""

from __future__ import annotations

import io
import re
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "worlds"), str(ROOT / "docs")]

from browser_world import Seat, browser, playwright  # noqa: E402
from from_code.cockpit import FOLDER, SIZES, VIEWS, file_of  # noqa: E402
from programs import process  # noqa: E402

POINTS = "Hatches closed\nDrop weight armed\nBeacon heard\n"
SHOWN_MS = 1500  # what a view asks for has come
FLOWN_MS = 20_000
COLOURS = 64


@contextmanager
def opened(chromium: object, *words: str) -> Iterator[Seat]:
    with process("console", *words, "--no-browser") as program:
        assert program.stdout is not None
        lines = iter(program.stdout.readline, "")
        address = next(line for line in lines if line.startswith("open "))
        context = chromium.new_context(locale="en-GB")  # type: ignore[attr-defined]
        seat = Seat(context.new_page())
        seat.page.goto(address.removeprefix("open ").strip())
        yield seat
        context.close()
        program.send_signal(signal.SIGINT)  # with the sea that it began
        program.wait()


def take(seat: Seat, *views: str) -> None:
    for size, (width, height) in SIZES.items():
        seat.page.set_viewport_size({"width": width, "height": height})
        for view in views:
            seat.tab(VIEWS[view])
            if view == "plan" and size == next(iter(SIZES)):
                plan = seat.page.locator("#planner")
                plan.get_by_label("Template …").select_option("transect")
                still = playwright.expect(plan.locator(".draft-chart"))
                still.to_have_attribute("data-still", "planned")
            seat.page.wait_for_timeout(SHOWN_MS)
            shown = Image.open(io.BytesIO(seat.page.screenshot())).convert("RGB")
            small = shown.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            small.save(file_of(view, size), optimize=True)


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as made, browser() as chromium:
        points = Path(made) / "points.txt"
        points.write_text(POINTS)
        sea = ("--simulate", "harbour-survey", "--speed", "8", "--out", f"{made}/sea")
        with opened(chromium, *sea, "--checklist", str(points)) as seat:
            seat.shows("#state", re.compile("autonomous"))
            seat.page.wait_for_timeout(FLOWN_MS)
            take(seat, *(view for view in VIEWS if view != "review"))
        with opened(chromium, "float-test") as seat:
            review = seat.page.locator("#review")
            playwright.expect(review).to_be_visible()
            review.locator("input[type=range]").fill("60")
            take(seat, "review")


if __name__ == "__main__":
    main()
