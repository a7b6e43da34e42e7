"""The cockpit in a real Chromium, against the real serve and a simulated vehicle.

It has to be there: apt-get install chromium. Without one these tests are skipped.
"""

from __future__ import annotations

import http.server
import json
import re
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from browser_world import DROP, IN_A_BROWSER, playwright, seated, until
from console_world import at_sea, cockpit, console, console_of
from programs import process
from served import TEXT, running, silent_board

from mission.authoring.prepare import prepare
from mission.console.charts.shelf import Shelf
from mission.console.ghost import LONGEST_S
from mission.console.recorded import Recorded
from mission.console.recording import Recording
from mission.onboard.runtime.records import ListRecorder
from mission.verification.simulation.flight import fly

pytestmark = IN_A_BROWSER


def test_a_dive_from_the_first_start_to_the_ascent(chromium: object, tmp_path: Path) -> None:
    (tmp_path / "pool.mission").write_text(TEXT)
    with at_sea(tmp_path) as (_, running, _), seated(chromium, running) as seat:
        page = seat.page
        seat.shows("#state", "idle/empty")
        assert "#" not in page.url  # the token is out of sight
        page.locator("#command input[type=file]").set_input_files(tmp_path / "pool.mission")
        seat.press_twice("Upload")
        seat.shows("#state", "idle/ready")
        seat.start()
        page.get_by_role("tab", name="Legs").first.click()
        playwright.expect(page.locator('[data-path="dive"]')).to_be_visible()
        seat.drive()
        page.keyboard.up("ArrowUp")
        page.keyboard.up("Shift")
        seat.shows("#state", "manual/waiting")
        page.get_by_role("tab", name="Command").first.click()
        seat.start()
        page.keyboard.press("w")
        seat.shows("#state", re.compile("emergency/surfac"))
        seat.shows("#surface .became", re.compile("acknowledged|confirmed|obeyed", re.IGNORECASE))
        page.locator("#stop").click()
        seat.shows("#state", "emergency/stopped")


def test_of_two_missions_the_one_that_was_chosen_last_is_uploaded(
    chromium: object, tmp_path: Path
) -> None:
    files = [tmp_path / f"{name}.mission" for name in ("first", "second")]
    for file in files:
        file.write_text(TEXT.replace("mission pool", f"mission {file.stem}"))
    checks: list[playwright.Route] = []  # type: ignore[name-defined]
    nobody = console_of("tcp://127.0.0.1:1", tmp_path)
    with nobody as (running, _), seated(chromium, running) as seat:
        seat.page.route("**/api/check", lambda route: checks.append(route))
        for number, file in enumerate(files, 1):
            seat.page.locator("#command input[type=file]").set_input_files(file)
            until(seat.page, lambda number=number: len(checks) == number)
        checks[1].continue_()
        playwright.expect(seat.page.get_by_role("button", name="Upload")).to_be_enabled()
        with seat.page.expect_response("**/api/check"):
            checks[0].continue_()
        seat.page.wait_for_timeout(500)
        seat.page.get_by_role("button", name="Upload").click()
        again = seat.page.get_by_role("button", name=re.compile("^Press again"))
        playwright.expect(again).to_contain_text("second")


def test_a_browser_that_is_gone_lets_the_vehicle_go(chromium: object, tmp_path: Path) -> None:
    with at_sea(tmp_path) as (_, running, _), seated(chromium, running) as watching:
        watching.shows("#state", "idle")
        with seated(chromium, running) as seat:
            seat.shows("#commander", re.compile("nobody", re.IGNORECASE))
            seat.drive()
        watching.shows("#state", "manual/waiting")


def test_a_console_that_hangs_is_noticed_and_told_its_orders_when_it_goes_on(
    chromium: object, tmp_path: Path
) -> None:
    with silent_board() as (_, board), running(tmp_path, f"serial://{board}") as pi:
        words = ["--to", pi.url, "--monitor", "none", "--no-browser"]
        with process("console", *words) as hanging:
            assert hanging.stdout is not None
            page = chromium.new_page()  # type: ignore[attr-defined]
            page.goto(hanging.stdout.readline().removeprefix("open ").strip())
            playwright.expect(page.locator("#state")).to_contain_text("idle")
            hung = page.locator("#banner").get_by_text("The console does not answer")
            playwright.expect(hung.first).to_be_hidden()
            hanging.send_signal(signal.SIGSTOP)
            playwright.expect(hung.first).to_be_visible()
            page.keyboard.press("x")
            hanging.send_signal(signal.SIGCONT)
            playwright.expect(page.locator("#state")).to_contain_text("emergency/stopped")
            playwright.expect(hung.first).to_be_hidden()
            page.close()


BELOW = """() => {
  const lines = document.querySelector('#journal ol');
  return lines.clientHeight ? lines.scrollHeight - lines.scrollTop - lines.clientHeight : Infinity;
}"""


NOTE_ENDS = "() => document.querySelector('#review .note').getBoundingClientRect().right"


def test_a_recording_is_played_and_scrubbed(chromium: object) -> None:
    prepared, recorder = prepare("float-test"), ListRecorder()
    fly(prepared.mission, prepared.vehicle, recorder=recorder)
    recorded = [Recorded("1", "dive.mcap", Recording(recorder.records), None)]
    with console(lambda: recorded) as running, seated(chromium, running) as seat:
        review = seat.page.locator("#review")
        playwright.expect(review).to_be_visible()
        review.get_by_label("Speed", exact=True).select_option("100")
        seat.shows("#review .at", re.compile(r"([0-9:]+) / \1 "))  # at its end
        seat.shows("#state", "idle/ready")
        for width in (390, 1400):
            seat.page.set_viewport_size({"width": width, "height": 900})
        until(seat.page, lambda: seat.page.evaluate(BELOW) < 2)
        review.locator("input[type=range]").fill("60")
        seat.shows("#state", "autonomous")
        strips = playwright.expect(seat.page.locator("#strips canvas"))
        strips.to_have_attribute("aria-label", re.compile(r"Altitude \d"))  # of before the jump
        review.locator("input[type=range]").fill("1")
        seat.shows("#review .at", "0:0")
        seat.page.get_by_text("Compare", exact=True).click()
        seat.page.get_by_role("button", name="Known now").click()
        seat.shows("#review .note", "at most")
        seat.page.set_viewport_size({"width": 390, "height": 844})
        until(seat.page, lambda: seat.page.evaluate(NOTE_ENDS) <= 390)
        playwright.expect(seat.page.locator("#stop")).to_be_disabled()


def test_charts_lie_under_the_vehicle_and_tell_the_depth_there(
    chromium: object, tmp_path: Path
) -> None:
    prepared, recorder = prepare("first-dive"), ListRecorder()
    home = prepared.mission.home
    assert home is not None
    lat, lon = home.latitude_deg, home.longitude_deg
    head = f"ncols 2\nnrows 2\nxllcorner {lon - 1}\nyllcorner {lat - 1}\ncellsize 1\n"
    (tmp_path / "floor.asc").write_text(head + "-7 -7 -7 -7")
    near = {"type": "Point", "coordinates": [lon, lat]}
    (tmp_path / "rock.geojson").write_text(json.dumps(near))
    fly(prepared.mission, prepared.vehicle, recorder=recorder)
    recorded = [Recorded("1", "dive.mcap", Recording(recorder.records), None)]
    shelf = Shelf(tmp_path, (tmp_path / "floor.asc",))
    with console(lambda: recorded, shelf) as running, seated(chromium, running) as seat:
        page = seat.page
        playwright.expect(page.locator("#review")).to_be_visible()
        page.locator("#layers").click()
        page.locator("#chart-layers input[type=file]").set_input_files(tmp_path / "rock.geojson")
        seat.shows("#chart-layers", "rock.geojson")
        seat.shows("#chart-layers", "heights, turned into depths")
        (tmp_path / "broken.geojson").write_text("[")
        page.locator("#chart-layers input[type=file]").set_input_files(tmp_path / "broken.geojson")
        seat.shows("#chart-layers", "broken.geojson: no GeoJSON")
        page.mouse.move(300, 400)
        seat.shows("#chart-pointer", "charted 7.0 m")
        page.get_by_label("floor.asc", exact=True).uncheck()
        playwright.expect(page.locator("#chart-pointer")).not_to_contain_text("charted")


GPX = """<gpx xmlns="http://www.topografix.com/GPX/1/1"><rte><name>bay</name>
<rtept lat="30.288" lon="120.154"/><rtept lat="30.289" lon="120.154"/></rte></gpx>"""
FLOWN_MS = 1000 * LONGEST_S  # a flight yields to all else, and the product bounds it


def has_still_track(plan: playwright.Locator) -> None:  # type: ignore[name-defined]
    chart = playwright.expect(plan.locator(".draft-chart"))
    chart.to_have_attribute("data-still", "planned", timeout=FLOWN_MS)


STILL_BANNER = "document.querySelector('#banner').style.height = '90px'"  # whatever it says
SLID = "px => { document.body.style.paddingTop = px + 'px'; }"


def drags_a_place_and_undoes_it(
    page: playwright.Page,  # type: ignore[name-defined]
    chart: playwright.Locator,  # type: ignore[name-defined]
    code: playwright.Locator,  # type: ignore[name-defined]
) -> None:
    """The first behind home, and has it where it was dragged to in the end: one line is another."""
    expect, first = playwright.expect, code.input_value()
    page.evaluate(STILL_BANNER)
    chart.press("n")  # home
    chart.press("n")  # what is chosen stands in the middle
    box = chart.bounding_box()
    assert box is not None
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 5, middle[1] + 4, steps=4)  # its purpose holds at any scale
    page.mouse.up()
    says = page.locator(".plan-says").text_content()
    seen = f"chart at {box}, then at {chart.bounding_box()}; the plan says {says!r}"
    expect(code, seen).not_to_have_value(first)
    moved = code.input_value()
    rows = zip(first.split("\n"), moved.split("\n"), strict=True)
    assert sum(before != after for before, after in rows) == 1
    chart.press("Control+z")
    expect(code).to_have_value(first)
    chart.press("Control+y")
    expect(code).to_have_value(moved)


def holds_a_place_while_an_alarm_moves_the_page(
    page: playwright.Page,  # type: ignore[name-defined]
    chart: playwright.Locator,  # type: ignore[name-defined]
    code: playwright.Locator,  # type: ignore[name-defined]
) -> None:
    """It stays where it was: under the finger is another place now."""
    edits: list[str] = []
    page.on("request", lambda asked: edits.append(asked.url) if "/api/edit" in asked.url else None)
    box, before = chart.bounding_box(), code.input_value()
    assert box is not None
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    for moves_on in (True, False):
        chart.press("p")
        chart.press("n")
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0] + 9, middle[1], steps=3)
        page.evaluate(SLID, 56)
        if moves_on:
            page.mouse.move(middle[0] + 12, middle[1], steps=3)
        page.mouse.up()
        page.evaluate(SLID, 0)
    assert code.input_value() == before
    assert not edits


def test_a_plan_from_a_template_to_the_vehicle_and_another_by_drop(
    chromium: object, tmp_path: Path
) -> None:
    with cockpit(tmp_path) as (_, running, _), seated(chromium, running) as seat:
        page, expect = seat.page, playwright.expect
        page.get_by_role("tab", name="Plan").first.click()
        plan = page.locator("#planner")
        code, verdict = plan.locator("textarea"), plan.locator(".verdict")
        plan.get_by_label("Template …").select_option("transect")
        expect(verdict).to_contain_text("from home")
        has_still_track(plan)
        first = code.input_value()
        code.press("Control+End")
        page.keyboard.type("wrong")
        expect(plan.locator(".marks .wrong")).to_be_visible()
        expect(verdict).to_contain_text("Refused: 1")
        expect(plan.get_by_role("button", name="Upload")).to_be_disabled()
        code.press("Control+z")
        expect(code).to_have_value(first)
        expect(verdict).to_contain_text("from home")
        seat.shows("#banner", "old report")  # of a silent board: it moves the page once
        has_still_track(plan)
        chart = plan.locator("canvas")
        drags_a_place_and_undoes_it(page, chart, code)
        holds_a_place_while_an_alarm_moves_the_page(page, chart, code)
        expect(verdict).to_contain_text("from home")
        plan.get_by_role("button", name="Fly").click()
        expect(plan.locator(".ghost-says")).to_contain_text("COMPLETED", timeout=FLOWN_MS)
        expect(plan.locator(".ghost-says")).to_contain_text("current=0.2@45")
        seat.press_twice("Upload")
        seat.shows("#state", "idle/ready")
        expect(plan.locator(".digests")).to_contain_text("the same")
        chart.press("Control+z")
        expect(plan.locator(".digests")).to_contain_text("DIFFERENT")
        plan.get_by_role("button", name="Compare").click()
        expect(plan.locator(".changes li").first).to_contain_text("first/run")
        page.evaluate(DROP, ["bay.gpx", GPX])
        expect(plan.locator(".importing .why")).to_contain_text("where the vehicle starts")
        plan.locator(".importing").get_by_role("button", name="Import").click()
        expect(code).to_have_value(re.compile("Imported from bay.gpx"))
        code.press("Control+z")
        expect(code).to_have_value(first)
        with page.expect_download() as saved:
            plan.get_by_role("button", name="Save").click()
        assert saved.value.suggested_filename == "transect.yaml"
        expect(verdict).to_contain_text("from home")
        page.evaluate(DROP, ["huge.yaml", "# " + "x" * ((1 << 20) - 3)])
        expect(plan.locator(".plan-says")).to_contain_text("huge.yaml")
        expect(verdict).to_have_text("")
        code.press("Control+z")
        expect(verdict).to_contain_text("from home")


def test_what_was_proved_of_an_older_text_is_grey_and_says_so(
    chromium: object, tmp_path: Path
) -> None:
    held: list[playwright.Route] = []  # type: ignore[name-defined]
    nobody = console_of("tcp://127.0.0.1:1", tmp_path)
    with nobody as (running, _), seated(chromium, running) as seat:
        page, expect = seat.page, playwright.expect
        page.route_web_socket("**/ws/ghost*", lambda _: None)  # it flies, and is never there
        seat.tab("Plan")
        plan = page.locator("#planner")
        verdict = plan.locator(".verdict")
        plan.get_by_label("Template …").select_option("transect")
        expect(verdict).to_have_attribute("data-level", "good")
        expect(plan.locator(".draft-chart")).to_have_attribute("data-still", "flown")
        page.route("**/api/check", lambda route: held.append(route))
        plan.locator("textarea").press("Control+End")
        page.keyboard.type("# more")
        expect(plan.locator(".findings")).to_have_attribute("data-old", "")
        expect(verdict).not_to_have_attribute("data-level", "good")
        expect(verdict).to_contain_text("the newest is being proved")
        held[0].continue_()
        until(page, lambda: len(held) == 2)  # that of the newest
        held[1].continue_()
        expect(verdict).to_have_attribute("data-level", "good")
        page.route("**/api/import", lambda route: held.append(route))
        page.evaluate(DROP, ["bay.gpx", GPX])
        expect(plan.locator(".importing .why")).to_contain_text("bay.gpx is being imported")
        until(page, lambda: len(held) == 3)
        held[2].continue_()
        expect(plan.locator(".importing .why")).to_contain_text("where the vehicle starts")


# --- others ---------------------------------------------------------------------------------------

STEAL = """async ([host, token]) => {
  const tried = {};
  const shown = {headers: {Authorization: `Bearer ${token}`}};
  for (const [name, how] of Object.entries({plain: {}, token: shown, blind: {mode: 'no-cors'}})) {
    try {
      const answer = await fetch(`http://${host}/api/setup`, how);
      tried[name] = answer.type === 'opaque' ? 'opaque' : await answer.text();
    } catch (error) { tried[name] = 'refused'; }
  }
  tried.socket = await new Promise((done) => {
    const socket = new WebSocket(`ws://${host}/ws/orders?vehicle=1`, ['auvmission', `token.${token}`]);
    socket.onopen = () => { socket.send('{"id": 1, "at": 0, "do": "stop"}'); done('open'); };
    socket.onerror = () => done('refused');
  });
  return tried;
}"""


@contextmanager
def elsewhere() -> Iterator[str]:
    """Another server of this computer."""

    class Bare(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!doctype html><title>other</title>")

        def log_message(self, *said: object) -> None:
            """Not told."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Bare) as server:
        threading.Thread(target=server.serve_forever).start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/"
        finally:
            server.shutdown()


def test_a_page_of_another_origin_gets_nothing_even_with_the_token(
    chromium: object, tmp_path: Path
) -> None:
    with console_of("tcp://127.0.0.1:1", tmp_path) as (running, vehicle), elsewhere() as other:
        page = chromium.new_page()  # type: ignore[attr-defined]
        page.goto(other)
        tried = page.evaluate(STEAL, [running.host, running.token])
        assert tried == {
            "plain": "refused", "token": "refused", "blind": "refused", "socket": "refused",
        }  # fmt: skip
        page.close()
        assert vehicle.orders.as_objects(0.0) == []


def test_another_name_and_a_missing_token_open_nothing(chromium: object, tmp_path: Path) -> None:
    with console_of("tcp://127.0.0.1:1", tmp_path) as (running, _):
        page = chromium.new_page()  # type: ignore[attr-defined]
        port = running.host.partition(":")[2]
        answer = page.goto(f"http://evil.example:{port}/#{running.token}")
        assert answer.status == 421
        page.goto(f"http://{running.host}/")
        alarm = page.locator("#banner [role=alert]")
        playwright.expect(alarm).to_be_visible()
        assert page.locator("#state").inner_text() == "—"
        page.close()
