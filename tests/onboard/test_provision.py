"""Whatever is broken when serve begins: what may be under way comes up, and what is wrong is told."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest
from served import LINES, provided, running, silent_board, soon

from mission.model import STOPPED, SURFACED, SURFACING, UNKNOWN
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration, LinkUrls
from mission.onboard.kept import WORKING, Homes, write_summed
from mission.onboard.rates import rated
from mission.onboard.serve import health
from mission.onboard.serve.provision import BUILT_IN, Provision, Unusable, provide
from mission.onboard.serve.working import Working, find, keep
from mission.onboard.store import DiskStore, LostStore, MemoryStore, StoreError

NONE: dict[str, str | None] = {}
URL = "serial:///dev/ttyAUV"
OPENED = f"{URL}?baud=9600"  # at the rate of its role
KEYS = "tls-listen://0.0.0.0:4711?keys=/etc/auvmission/keys&allow=192.168.1.0/24"


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "home"))


def written(folder: Path, more: str = "") -> Path:
    path = folder / "serve.yaml"
    path.write_text(
        f"folder: {folder / 'pi'}\nlinks: {{vehicle: '{URL}', topside: '{KEYS}'}}\n"
        f"camera: record\n{more}"
    )
    return path


def begun(folder: Path, under_way: str = "autonomous/out") -> Path:
    """A serve has run with this configuration, and something was under way."""
    config = written(folder)
    got = provide(config, NONE, None, {})
    assert (got.faults, got.configuration.ascent_only) == ((), "")
    got.store.keep_lines(tuple(LINES))
    got.store.keep_under_way(under_way)
    got.keep()
    return config


def not_utf8(config: Path) -> None:
    config.write_bytes(b"\x00\xff{{{")


def no_yaml(config: Path) -> None:
    config.write_text(config.read_text() + "links: {{{\n")


def unknown_key(config: Path) -> None:
    config.write_text(config.read_text() + "nonsense: 3\n")


def no_link(config: Path) -> None:
    config.write_text(config.read_text().replace("serial:", "serail:"))


def a_folder(config: Path) -> None:
    config.unlink()
    config.mkdir()


CONFIGURATIONS = [Path.unlink, not_utf8, no_yaml, unknown_key, no_link, a_folder]


@pytest.mark.parametrize("break_it", CONFIGURATIONS)
def test_a_broken_configuration_gives_way_to_the_last_that_worked(tmp_path: Path, break_it) -> None:
    config = begun(tmp_path)
    break_it(config)
    got = provide(config, NONE, None, {})
    assert got.configuration.links.vehicle == OPENED
    assert got.configuration.folder == tmp_path / "pi"
    assert got.store.content.under_way == "autonomous/out"
    assert len(got.faults) == 1
    assert got.faults[0].splitlines()[0] in got.configuration.ascent_only


@pytest.mark.parametrize("break_it", CONFIGURATIONS)
def test_an_old_configuration_listens_on_loopback_alone_and_runs_no_command(
    tmp_path: Path, break_it
) -> None:
    config = begun(tmp_path)
    break_it(config)
    got = provide(config, NONE, None, {}).configuration
    assert got.links.topside == "tcp-listen://127.0.0.1:4711"
    assert (got.camera, got.set_system_clock) == (None, False)


def test_a_broken_vehicle_file_gives_way_to_the_last_that_worked_and_the_port_stays(
    tmp_path: Path,
) -> None:
    begun(tmp_path)
    config = written(tmp_path, "vehicle: nowhere\n")
    got = provide(config, NONE, None, {})
    assert got.vehicle == load_vehicle("auv")
    assert got.configuration.links.topside == KEYS
    assert "nowhere" in got.configuration.ascent_only


def test_where_nothing_was_under_way_somebody_has_to_mend_what_is_broken(tmp_path: Path) -> None:
    config = begun(tmp_path, "")
    unknown_key(config)
    with pytest.raises(Unusable, match="nonsense"):
        provide(config, NONE, None, {})


def test_everything_that_is_wrong_is_told_at_once_each_with_its_place(tmp_path: Path) -> None:
    config = tmp_path / "serve.yaml"
    config.write_text(
        "{vehicle: nosuch, manual_for: -1,\n"
        " links: {topside: foo, gps: bar, vehicle: 'serial:///dev/x?baud=abc'}}\n"
    )
    with pytest.raises(Unusable) as caught:
        provide(config, NONE, tmp_path / "pi", {})
    said = str(caught.value).splitlines()
    for line, begins in zip(said, (
        f"{config}:1:31: manual_for: ",
        f"{config}:2:19: links: topside: 'foo' is no link's URL",
        f"{config}:2:29: links: gps: 'bar' is no link's URL",
        f"{config}:2:43: links: vehicle: serial:///dev/x?baud=abc: baud=abc: a number from 50",
        "no such vehicle: nosuch",
    ), strict=True):  # fmt: skip
        assert line.startswith(begins)


def test_a_link_that_the_command_line_overrules_may_be_wrong_in_the_file(tmp_path: Path) -> None:
    config = written(tmp_path, "")
    config.write_text(config.read_text().replace(URL, "serail:///dev/x"))
    assert provide(config, {"vehicle": URL}, None, {}).configuration.links.vehicle == OPENED
    with pytest.raises(Unusable, match=r"(?m)^--gps: 'nonsense' .*\n.*links: vehicle: 'serail:"):
        provide(config, {"gps": "nonsense"}, None, {})


def test_the_folder_of_the_service_manager_is_looked_into(tmp_path: Path) -> None:
    config = begun(tmp_path)
    config.unlink()
    (tmp_path / "home").rename(tmp_path / "elsewhere")
    got = provide(config, NONE, None, {"STATE_DIRECTORY": str(tmp_path / "pi")})
    assert got.configuration.links.vehicle == OPENED


@pytest.mark.parametrize("said", ["", " ", " ~", " null", " # the usual one", "\n", " ''", "\r"])
def test_a_folder_that_is_not_said_is_none(tmp_path: Path, said: str) -> None:
    config = tmp_path / "serve.yaml"
    config.write_text(f"folder:{said}\nlinks: {{{{{{\n")
    assert Homes(config, None, {}).folder is None
    assert Homes(config, None, {"STATE_DIRECTORY": "/state"}).folder == Path("/state")


def test_without_anything_left_the_shipped_defaults_and_vehicle_serve_the_ascent(
    tmp_path: Path,
) -> None:
    got = provide(tmp_path / "serve.yaml", NONE, None, {})
    assert got.configuration == rated(replace(got.configuration, links=LinkUrls()), got.vehicle)
    assert got.vehicle == load_vehicle(BUILT_IN)
    assert got.store.content.under_way == UNKNOWN
    assert isinstance(got.store, LostStore)
    assert not (tmp_path / "home").exists(), "nothing is made where nothing was"


def test_links_of_the_command_line_count_for_an_old_configuration_as_well(tmp_path: Path) -> None:
    config = begun(tmp_path)
    not_utf8(config)
    given = {"vehicle": "serial:///dev/ttyOTHER", "gps": "none", "topside": "nonsense"}
    links = provide(config, given, None, {}).configuration.links
    assert (links.vehicle, links.gps) == ("serial:///dev/ttyOTHER?baud=9600", None)
    assert links.topside == "tcp-listen://127.0.0.1:4711"


@pytest.mark.parametrize("place", ["pi", "pi/store"])
def test_a_store_that_is_a_file_does_not_know_what_was_under_way(
    tmp_path: Path, place: str
) -> None:
    config = written(tmp_path)
    (tmp_path / place).parent.mkdir(exist_ok=True)
    (tmp_path / place).write_text("")
    got = provide(config, NONE, None, {})
    assert got.configuration.ascent_only == "", "no start can be made durable anyhow"
    assert got.store.content.under_way == UNKNOWN
    assert "store" in got.faults[0]
    for keeps in (lambda: got.store.keep_lines(tuple(LINES)), lambda: got.store.keep_under_way("")):
        with pytest.raises(StoreError):
            keeps()


def test_a_medium_that_is_read_only_with_a_half_written_file_can_be_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = begun(tmp_path)
    (tmp_path / "pi" / "store" / "under-way.new").write_bytes(b"half")

    def read_only(path: Path) -> None:
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(Path, "unlink", read_only)
    got = provide(config, NONE, None, {})
    assert (got.faults, got.damage) == ((), ())
    assert (got.store.content.lines, got.store.content.under_way) == (
        tuple(LINES),
        "autonomous/out",
    )


def test_a_file_of_the_store_without_rights_counts_as_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun(tmp_path)

    def no_rights(path: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", no_rights)
    found = DiskStore(tmp_path / "pi" / "store").content
    assert found.under_way == UNKNOWN
    assert len(found.damage) == 3


def test_a_library_that_cannot_be_imported_costs_features_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = begun(tmp_path)
    monkeypatch.setitem(__import__("sys").modules, "mission.model.yaml_tree", None)
    got = provide(config, NONE, None, {})
    assert (got.configuration.links.vehicle, got.vehicle.name) == (OPENED, "auv")
    assert "yaml" in got.faults[0]


# --- what is kept for then ------------------------------------------------------------------------


def test_the_first_configuration_is_kept_at_once_and_another_when_the_vehicle_is_heard(
    tmp_path: Path,
) -> None:
    homes = Homes(None, tmp_path, {})
    with silent_board() as (master, device):
        with running(tmp_path, f"serial://{device}"):
            soon(lambda: find(homes) is not None, "the first one")
        with running(tmp_path, f"serial://{device}", answer_no=False):
            soon((tmp_path / health.FILE).exists, "a running serve")
            first = find(homes)
            assert first is not None
            assert first.configuration.answer_no
            os.write(master, b"@ACK_ZAY$")

            def is_other() -> bool:
                kept = find(homes)
                return kept is not None and not kept.configuration.answer_no

            soon(is_other, "the one with which the vehicle was heard")


def test_what_only_brings_a_vehicle_up_is_not_kept(tmp_path: Path) -> None:
    got = provided(Configuration(folder=tmp_path, ascent_only="broken"), MemoryStore())
    got.keep()
    assert find(got.homes) is None


def test_what_is_kept_comes_back_equal_and_what_is_damaged_does_not(tmp_path: Path) -> None:
    homes = Homes(None, tmp_path, {})
    kept = Working(
        Configuration(folder=tmp_path, tolerances={"sd_crc": "off"}), load_vehicle("rov")
    )
    keep(kept, homes)
    assert find(homes) == kept
    data = (tmp_path / WORKING).read_bytes()
    for cut in (0, 20, len(data) // 2, len(data) - 1):
        (tmp_path / WORKING).write_bytes(data[:cut])
        assert find(homes) is None
    for text in ("[]", "{}", '{"configuration": {"unheard": 1}, "vehicle": {}}'):
        write_summed(tmp_path / WORKING, text)
        assert find(homes) is None


def test_what_has_not_changed_is_not_written_again(tmp_path: Path) -> None:
    homes, kept = (
        Homes(None, tmp_path, {}),
        Working(Configuration(folder=tmp_path), load_vehicle("auv")),
    )
    keep(kept, homes)
    before = (tmp_path / WORKING).stat().st_mtime_ns
    keep(kept, homes)
    assert (tmp_path / WORKING).stat().st_mtime_ns == before


# --- what serve does with it ----------------------------------------------------------------------


def test_for_the_ascent_alone_no_mission_is_taken_and_the_stored_one_stays(tmp_path: Path) -> None:
    from served import MISSION, asked, quiet

    from mission.authoring.language import digest, script
    from mission.topside.console import converse
    from mission.topside.upload import Refused, upload

    store = DiskStore(tmp_path / "store")
    store.keep_lines(tuple(LINES))
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}", store=store, ascent_only="all is broken") as pi,
    ):
        with pytest.raises(Refused, match="all is broken"):
            converse(pi.url, upload(script(MISSION), digest(MISSION), quiet))
        with pi.boat() as boat:
            assert asked(boat, b"@AA$") == b"@ACK_AAN$"
            soon((tmp_path / health.FILE).exists, "the health")
            assert '"ascent_only": "all is broken"' in (tmp_path / health.FILE).read_text()
    assert store.content.lines == tuple(LINES)


@pytest.mark.parametrize(
    ("under_way", "state"),
    [("autonomous/out", SURFACING), (UNKNOWN, STOPPED), (SURFACED, SURFACED)],
)
def test_a_serve_without_store_and_log_begins_by_what_is_known(
    tmp_path: Path, under_way: str, state: str
) -> None:
    (tmp_path / "file").write_text("")
    configuration = replace(Configuration(), folder=tmp_path / "file")
    store = LostStore("no disk", under_way)
    with (
        silent_board() as (_, device),
        running(configuration.folder, f"serial://{device}", store=store) as pi,
    ):
        soon(lambda: pi.has_told(f"now {state}"), state)


def test_a_provision_names_every_fault(tmp_path: Path) -> None:
    begun(tmp_path)
    store = tmp_path / "pi" / "store"
    store.rename(tmp_path / "pi" / "was")
    store.write_text("")
    config = written(tmp_path, "vehicle: nowhere\n")
    got: Provision = provide(config, NONE, None, {})
    assert len(got.faults) == 2
