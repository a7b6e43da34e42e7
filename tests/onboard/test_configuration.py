"""One YAML file, defaults for everything, every fault told."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest
from click.testing import CliRunner

from mission.commands.serve import serve
from mission.onboard.configuration import (
    _KEYS,
    Configuration,
    ConfigurationError,
    load_configuration,
    parse_configuration,
)


@pytest.mark.parametrize("text", ["", "# only a comment\n", "{}"])
def test_everything_has_a_default(text: str) -> None:
    assert parse_configuration(text) == Configuration() == load_configuration(None)


def test_every_field_can_be_written() -> None:
    assert list(_KEYS) == [f.name for f in fields(Configuration) if f.name != "ascent_only"]


def test_loopback_unless_told() -> None:
    assert Configuration().links.topside.startswith("tcp-listen://127.0.0.1")


def test_what_is_written_replaces_the_default_alone() -> None:
    found = parse_configuration(
        "links: {topside: 'tcp-listen://0.0.0.0:4000', gps: null}\nmanual_for: 2 min\n"
        "time_zone: '-03:30'\nfolder: /tmp/x\ntolerances: {st_commas: off, order_aw: high}\n"
    )
    assert found.links.topside == "tcp-listen://0.0.0.0:4000"
    assert found.links.gps is None
    assert found.links.vehicle == Configuration().links.vehicle
    assert found.manual_for == 120.0
    assert found.utc_offset == -3.5 * 3600
    assert found.store == Path("/tmp/x/store")
    assert found.tolerances == {"st_commas": "off", "order_aw": "high"}
    assert found.answer_no is True


def test_all_faults_are_told_at_once_with_file_and_key() -> None:
    with pytest.raises(ConfigurationError) as caught:
        parse_configuration(
            "vehicel: auv\nmanual_for: -1\nanswer_no: maybe\ntime_zone: 8\nlinks: {vehicle: 3, x: 1}",
            "serve.yaml",
        )
    found = caught.value.diagnostics
    places = [(d.where.line, d.where.column, d.offending) for d in found]
    assert places == [
        (1, 1, "vehicel"),
        (2, 13, "-1"),
        (3, 12, "maybe"),
        (4, 12, "8"),
        (5, 18, "3"),
        (5, 21, "x"),
    ]
    assert all(d.file == "serve.yaml" and d.code and d.hint for d in found)
    words = ("vehicel", "manual_for", "answer_no", "time_zone", "links: vehicle", "links")
    for word, diagnostic in zip(words, found, strict=True):
        assert word in diagnostic.message


@pytest.mark.parametrize("text", ["- a\n", "a: [", "3"])
def test_what_is_no_table_is_refused(text: str) -> None:
    with pytest.raises(ConfigurationError):
        parse_configuration(text)


@pytest.mark.parametrize(
    ("text", "instead"),
    [
        ("link: {gps: null}", "did you mean links?"),
        ("gps: null", "it stands below links: write links: {gps: ...}"),
        ("baud: 9600", "write links: {vehicle: serial:///dev/serial0?baud=9600}"),
        ("colour: red", "there are: vehicle, links, folder"),
        ("links: {modm: null}", "did you mean modem?"),
    ],
)
def test_a_key_that_there_is_not_is_told_with_what_to_write(text: str, instead: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        parse_configuration(text, "serve.yaml")
    (found,) = caught.value.diagnostics
    assert "unknown key" in found.message
    assert found.hint.startswith(instead)
    written = re.fullmatch(r"write (.*\{vehicle.*)", found.hint)
    assert written is None or parse_configuration(written[1]).links.vehicle.endswith("baud=9600")


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"absent\.yaml"):
        load_configuration(tmp_path / "absent.yaml")


def test_a_tolerance_that_does_not_exist_is_told_before_anything_begins() -> None:
    with pytest.raises(
        ConfigurationError, match=r"serve.yaml:1:13: tolerances: .*'nope'(.|\n)*aw_zero_based"
    ):
        parse_configuration("tolerances: {nope: 3}", "serve.yaml")


def test_a_link_that_is_wrong_is_named_by_its_key() -> None:
    with pytest.raises(ConfigurationError) as caught:
        parse_configuration("links: {gps: 3}", "serve.yaml")
    (found,) = caught.value.diagnostics
    assert found.brief == (
        "serve.yaml:1:14: links: gps: a text is needed, not 3; default: serial:///dev/ttyUSB0"
    )


def test_what_is_no_yaml_is_told_in_one_line_with_its_place(tmp_path: Path) -> None:
    with pytest.raises(
        ConfigurationError, match=r"^serve.yaml:2:1: this is no YAML: .*'\]'"
    ) as caught:
        parse_configuration("links: [a, b\n", "serve.yaml")
    assert "\n" not in caught.value.brief
    (tmp_path / "latin.yaml").write_bytes(b"folder: \xe9")
    with pytest.raises(ConfigurationError, match="cannot be read: it is not UTF-8"):
        load_configuration(tmp_path / "latin.yaml")
    with pytest.raises(ConfigurationError, match="cannot be read: No such file"):
        load_configuration(tmp_path / "absent.yaml")


@pytest.mark.parametrize("form", ["- *a{last}\n", "folder: *a{last}\n", "camera: *a{last}\n"])
def test_aliases_that_multiply_and_brackets_without_end_are_no_trap(form: str) -> None:
    text = "x0: &a0 [x, x, x, x, x, x, x, x, x]\n"
    for i in range(1, 10):
        text += f"x{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n"
    if form.startswith("-"):
        text = "\n".join("- " + row.partition(": ")[2] for row in text.splitlines()) + "\n"
    with pytest.raises(ConfigurationError) as caught:
        parse_configuration(text + form.format(last=9), "serve.yaml")
    assert len(str(caught.value)) < 20_000
    with pytest.raises(ConfigurationError, match="nested too deep"):
        parse_configuration("folder: " + "[" * 20_000, "serve.yaml")


def test_serve_does_not_begin_with_a_wrong_configuration_and_calls_it_a_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("JOURNAL_STREAM", raising=False)
    path = tmp_path / "serve.yaml"
    path.write_text("tolerances: {nope: 3}\n")
    ran = CliRunner().invoke(serve, ["--config", str(path), "--folder", str(tmp_path / "pi")])
    assert ran.exit_code == 2
    assert f" fault   {path}:1:13: tolerances: " in ran.stderr
    assert not (tmp_path / "pi").exists()
