"""Laws of calls that cannot be carried out as they were said: exit 2, before any work is done."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from mission.cli import main
from mission.model.shipped import missions_folder, shipped_vehicles

RECORDED = Path(__file__).parents[1] / "analysis" / "recorded" / "short-time.mcap"


def refused(*call: object) -> Result:
    ran = CliRunner().invoke(main, list(map(str, call)))
    assert ran.exit_code == 2, ran.output
    assert ran.stdout == ""
    return ran


# --- what nothing can be written to --------------------------------------------------------------


@pytest.fixture(params=["/proc/x", "file/x"])
def nowhere(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """No file and no folder can be made there."""
    (tmp_path / "file").write_text("")
    return tmp_path / request.param


def test_a_folder_for_black_boxes_that_cannot_be_made_is_no_fault_of_the_flight(
    nowhere: Path,
) -> None:
    ran = refused("faults", "--seed", 1, "--flight", 1, "--report", nowhere)
    assert f"{nowhere}: cannot be written: " in ran.stderr
    assert "raised" not in ran.stderr


def test_a_track_that_cannot_be_written_is_refused_before_the_vehicle_runs(
    nowhere: Path, tmp_path: Path
) -> None:
    ran = refused("vehicle", "--folder", tmp_path / "room", "--track", nowhere)
    assert f"{nowhere}: cannot be written: " in ran.stderr
    assert not (tmp_path / "room").exists()


def test_a_picture_of_a_rehearsal_that_cannot_be_written_is_refused_before_it(
    nowhere: Path,
) -> None:
    picture = nowhere.with_suffix(".png")
    ran = refused("rehearse", "first-dive", "-o", picture)
    assert f"{picture}: cannot be written: " in ran.stderr


def test_looking_whether_a_file_can_be_written_leaves_it_as_it_is(tmp_path: Path) -> None:
    track, config = tmp_path / "track.csv", tmp_path / "room" / "serve.yaml"
    config.parent.mkdir()
    config.write_text("# somebody's\n")
    for before in (None, "kept\n"):
        if before is not None:
            track.write_text(before)
        refused("vehicle", "--folder", config.parent, "--track", track)
        assert (track.read_text() if track.exists() else None) == before


# --- what flies nothing --------------------------------------------------------------------------


@pytest.mark.parametrize("command", [["campaign"], ["exhaustive"], ["faults"]])
def test_a_vehicle_that_there_is_not_is_told_with_those_that_there_are(command: list[str]) -> None:
    ran = refused(*command, "--vehicle", "foo")
    there = [name for name in shipped_vehicles() if name not in ("auv-documented", "motorboards")]
    assert "foo" in ran.stderr
    assert all(name in ran.stderr for name in there)
    assert "cell" not in ran.stderr


@pytest.mark.parametrize("command", ["campaign", "exhaustive"])
def test_a_vehicle_that_no_shipped_mission_flies_on_is_no_green_campaign(command: str) -> None:
    ran = refused(command, "--vehicle", "motorboards")
    assert "no shipped mission flies on motorboards" in ran.stderr


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["campaign", "--word", "9999"], "9999: the words have the numbers 0 to "),
        (["campaign", "--missions", "0"], "0 is not in the range"),
        (["faults", "--soak", "0"], "0.0 is not in the range"),
    ],
)
def test_a_choice_that_leaves_no_flight_is_no_green_campaign(words: list[str], says: str) -> None:
    assert says in refused(*words).stderr


# --- what is none --------------------------------------------------------------------------------


def test_a_parameter_that_there_is_not_is_no_error_of_the_mission() -> None:
    for given in (["--param", "foo=3"], ["--vehicle", "nosuch"]):
        ran = refused("check", "first-dive", *given)
        assert given[1].partition("=")[0] in ran.stderr
        assert "first-dive.yaml" not in ran.stderr
    assert "no such vehicle: nosuch" in ran.stderr


def test_a_mission_given_as_a_vehicle_is_told_so_in_a_word() -> None:
    path = missions_folder() / "loiter.yaml"
    ran = refused("check", "first-dive", "--vehicle", path)
    assert ran.stderr.startswith(f"{path}:3:1: this is a mission, no vehicle file")
    assert ran.stderr.endswith(f"{path}: 1 error\n")


@pytest.mark.parametrize("mission", ["rov-dive", "bay"])
def test_a_mission_that_can_be_read_and_is_refused_is_exit_1(
    mission: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a vehicle that cannot fly it, and with a leg without a clock."""
    monkeypatch.chdir(tmp_path)
    Path("bay").write_text("mission bay vehicle auv\nout: heading 90 gear 6\n")
    ran = CliRunner().invoke(main, ["check", mission, "--vehicle", "auv"])
    assert ran.exit_code == 1
    assert "one-speed" in ran.stderr or "no-time-bound" in ran.stderr


@pytest.mark.parametrize("name", ["x.foo", "x", "x.PNG"])
def test_a_page_of_a_suffix_that_says_nothing_is_refused(name: str, tmp_path: Path) -> None:
    ran = refused("report", RECORDED, "-o", tmp_path / name)
    assert "the suffix says what to write: .html" in ran.stderr
    assert not list(tmp_path.iterdir())


def test_a_shipped_mission_is_laid_out_by_its_name_where_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shown = CliRunner().invoke(main, ["fmt", "first-dive", "--stdout"])
    assert (shown.exit_code, shown.stdout[:1]) == (0, "#")
    assert CliRunner().invoke(main, ["fmt", "first-dive", "--check"]).exit_code == 0
    assert "is a shipped mission" in refused("fmt", "first-dive").stderr
    assert "no shipped mission" in refused("fmt", "frist-dive", "--check").stderr
    Path("first-dive").write_text("mission first-dive vehicle auv\n a: gear 6 for 5\n")
    assert CliRunner().invoke(main, ["fmt", "first-dive"]).exit_code == 0


# --- values that no vehicle, file or port takes --------------------------------------------------


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("limits --depth 1e99", "--depth: 1e+99: a number above 0, at most 65535, is needed"),
        ("limits --voltage nan", "--voltage: nan: a number above 0, at most 65535, is needed"),
        ("limits --radius 0", "--radius: 0: a number above 0"),
        ("send SP depth_m=1e99", "depth_m: 1e+99 is outside 0..65535"),
        ("time --at 1900-01-01T00:00:00", "the year of time is 1970 to 2099, not 1900"),
        ("nodes Pi=closed", "names: STM32, BDGPS, UACM, CAMERA, AUTO"),
        ("send --port serial:///dev/x --hex zz", "'zz': write bytes of two hexadecimal digits"),
        ("start --wait -4", "-4 is not in the range"),
        ("monitor --rate -1", "-1.0 is not in the range"),
        ("monitor --bytes -1", "-1 is not in the range"),
        ("foxglove --listen foo", "--listen: 'foo' is no HOST:PORT, as 127.0.0.1:8765"),
        ("simulate first-dive --set depth_noise=inf", "inf is not a finite number"),
        ("simulate harbr-survey", "did you mean harbour-survey?"),
        (f"log {RECORDED} --from 50 --to 10", "nothing lies between --from 50 and --to 10"),
    ],
)
def test_a_value_that_cannot_be_is_refused_with_its_option_and_what_can(
    words: str, says: str
) -> None:
    ran = refused(*words.split())
    assert says in ran.stderr
    assert "fromhex" not in ran.stderr
    assert "{" not in ran.stderr


def test_bytes_that_are_not_hexadecimal_are_told_without_a_word_of_python() -> None:
    ran = CliRunner().invoke(main, ["decode", "--link", "auv.any", "--hex"], input="zz\n")
    assert ran.exit_code == 2
    assert "line 1: not hexadecimal: 'zz'; write bytes of two digits each" in ran.stderr


def test_the_help_of_serve_and_nodes_says_what_can_be_said() -> None:
    serve, nodes = (
        CliRunner().invoke(main, [name, "--help"]).stdout for name in ("serve", "nodes")
    )
    assert "tcp-listen://127.0.0.1:4000" in serve
    assert "the Pi is shown, too, and never closed" in nodes


# --- where jobs are done ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "why"),
    [
        ("faults --soak 1 --on local", "--soak flies here and keeps nothing: leave out --on, or"),
        ("faults --soak 1 --workers 2 --resume x", "leave out --workers, --resume, or say --soaks"),
        ("faults --flight 1 --on dask://127.0.0.1:1", "--flight flies here and keeps nothing"),
        ("faults --flight 1 --patience 3", "leave out --patience"),
        ("faults --on local --workers 8", "none with --on local"),
        ("campaign --on dask://127.0.0.1:1 --workers 8", "none with --on dask://127.0.0.1:1"),
        ("rehearse first-dive --on local --patience 5", "there is none with --on local"),
        ("campaign --generated 1 --show --resume x", "--show flies nothing: leave out --resume"),
        ("campaign --show", "say --generated NUMBER"),
        ("faults --report x", "--report needs --flight"),
        ("faults --search --flight 1", "--flight and --search are kinds of flights: say one"),
        ("faults --soak 1 --broken all", "--broken and --soak are kinds of flights: say one"),
        ("faults --calm --search", "--calm and --search are kinds of flights: say one"),
    ],
)
def test_an_option_that_would_be_ignored_is_refused(call: str, why: str) -> None:
    assert why in " ".join(refused(*call.split()).stderr.split())
