"""Whoever cannot see well, or sees by night, or reads Chinese: axe-core finds nothing to mend.

It looks at every view, in each light and language, in a real Chromium.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from browser_world import DROP, IN_A_BROWSER, Seat, playwright, seated
from console_world import at_sea, console, console_of
from from_code.cockpit import SIZES
from served import TEXT

from mission.authoring.prepare import prepare
from mission.console.recorded import Recorded
from mission.console.recording import Recording
from mission.onboard.runtime.records import ListRecorder
from mission.verification.simulation.flight import fly

axe = pytest.importorskip("axe_playwright_python", reason="pip install axe-playwright-python")
pytestmark = IN_A_BROWSER
SCRIPT = (Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8")
LIT = """async ([light, language]) => {
  const choice = document.getElementById('theme');
  choice.value = light;
  choice.dispatchEvent(new Event('change'));
  if (document.documentElement.lang !== language) document.getElementById('language').click();
  for (let n = 0; n < 3; n += 1) await new Promise(requestAnimationFrame);  // it is shown
  const tags = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'];
  const {violations, passes} = await axe.run(document, {runOnly: tags});
  if (!passes.some((one) => one.id === 'color-contrast')) throw new Error('nothing was looked at');
  return violations.flatMap((one) => one.nodes.map(
    (node) => `${one.id}: ${node.target} ${node.any.concat(node.all).map((why) => why.message)}`));
}"""
CUT_OFF = """async () => {
  for (let n = 0; n < 3; n += 1) await new Promise(requestAnimationFrame);
  const right = (at) => at.getBoundingClientRect().right;
  const rooms = [...document.querySelectorAll('.room')].filter((room) => room.clientWidth);
  const state = document.getElementById('state');
  const wide = rooms.filter((room) => [...room.children].some((one) => right(one) > right(room) + 1));
  return [...wide, ...(state.scrollWidth > state.clientWidth ? [state] : [])].map((one) => one.id);
}"""
LOOKS = (  # colours know no language; the names of buttons are English for what follows
    ("dark", "zh-Hans"),
    ("dark", "en"),
    ("sun", "en"),
    ("red", "en"),
)


def found(seat: Seat, view: str) -> list[str]:
    """What is wrong with a view, in each light and language."""
    return [
        f"{view}, {light}, {language}: {what}"
        for light, language in LOOKS
        for what in seat.page.evaluate(LIT, [light, language])
    ]


def test_nothing_under_way_is_hard_to_see_to_read_or_to_reach(
    chromium: object, tmp_path: Path
) -> None:
    (tmp_path / "pool.mission").write_text(TEXT)
    with at_sea(tmp_path) as (_, running, _), seated(chromium, running) as seat:
        page = seat.page
        page.evaluate(SCRIPT)
        seat.shows("#state", "idle/empty")
        page.locator("#command input[type=file]").set_input_files(tmp_path / "pool.mission")
        seat.press_twice("Upload")
        seat.shows("#state", "idle/ready")
        seat.start()
        wrong = found(seat, "Fly")
        for view in ("Legs", "Stick", "Checklist"):
            seat.tab(view)
            wrong += found(seat, view)
        seat.tab("Plan")
        plan = page.locator("#planner")
        plan.get_by_label("Template …").select_option("transect")
        playwright.expect(plan.locator(".verdict")).to_contain_text("from home")
        wrong += found(seat, "Plan")
        plan.locator("textarea").press("Control+End")
        page.keyboard.type("wrong")
        playwright.expect(plan.locator(".marks .wrong")).to_be_visible()
        wrong += found(seat, "Plan with a mistake")
        page.evaluate(DROP, [f"{'a-long-name-' * 40}.yaml", "# " + "x" * ((1 << 20) - 3)])
        playwright.expect(plan.locator(".plan-says")).to_contain_text("a-long-name")
        wrong += found(seat, "Plan with words that scroll")
        assert wrong == []


def test_nothing_in_a_recording_is_hard_to_see_to_read_or_to_reach(chromium: object) -> None:
    prepared, recorder = prepare("float-test"), ListRecorder()
    fly(prepared.mission, prepared.vehicle, recorder=recorder)
    recorded = [Recorded("1", "dive.mcap", Recording(recorder.records), None)]
    with console(lambda: recorded) as running, seated(chromium, running) as seat:
        seat.page.evaluate(SCRIPT)
        playwright.expect(seat.page.locator("#review")).to_be_visible()
        seat.shows("#state", "idle")
        seat.page.get_by_text("Compare", exact=True).click()
        seat.page.locator("#layers").click()
        assert found(seat, "Review") == []
        seat.page.locator("#review input[type=range]").fill("60")
        seat.shows("#state", "autonomous/rises/")  # a long one
        for size, (width, height) in {**SIZES, "turned": (768, 1024)}.items():
            seat.page.set_viewport_size({"width": width, "height": height})
            assert (size, seat.page.evaluate(CUT_OFF)) == (size, [])


def test_what_was_chosen_stays_where_a_tablet_is_turned(chromium: object, tmp_path: Path) -> None:
    nobody = console_of("tcp://127.0.0.1:1", tmp_path)
    with nobody as (running, _), seated(chromium, running) as seat:
        for size, room in (((1024, 768), "Plan"), ((768, 1024), "Legs")):
            seat.page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))
            seat.page.get_by_role("tab", name=room, exact=True).locator("visible=true").click()
            seat.page.set_viewport_size(dict(zip(("height", "width"), size, strict=True)))
            tab = seat.page.get_by_role("tab", name=room, exact=True).locator("visible=true")
            playwright.expect(tab).to_have_attribute("aria-selected", "true")
