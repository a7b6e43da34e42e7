"""A small authority: what is there is kept, and secrets are nobody else's."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from mission.commands.keys import keys
from mission.onboard.serve.keys import KeysError, make_keys

needs_openssl = pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl is driven")


@needs_openssl
def test_called_again_it_adds_and_changes_nothing(tmp_path: Path) -> None:
    first = CliRunner().invoke(keys, [str(tmp_path / "k")])
    assert first.exit_code == 0, first.output
    before = {p: p.read_bytes() for p in (tmp_path / "k").rglob("*") if p.is_file()}
    assert {p.name for p in before} == {"ca.pem", "ca.key", "cert.pem", "key.pem"}
    made: list[Path] = []
    make_keys(tmp_path / "k", ["boat", "tablet"], made.append)
    assert made == [tmp_path / "k" / "tablet"]
    assert all(path.read_bytes() == data for path, data in before.items())
    again = CliRunner().invoke(keys, [str(tmp_path / "k")])
    assert "nothing was changed" in again.output


@needs_openssl
def test_secret_keys_are_readable_by_their_owner_alone(tmp_path: Path) -> None:
    make_keys(tmp_path, ["boat"], lambda _: None)
    secrets = [*tmp_path.rglob("key.pem"), *tmp_path.rglob("ca.key")]
    assert len(secrets) == 3
    assert all(path.stat().st_mode & 0o077 == 0 for path in secrets)
    assert {p.name for p in tmp_path.iterdir()} == {"authority", "vehicle", "boat"}


@needs_openssl
def test_who_asks_for_a_viewer_gets_nothing_that_commands(tmp_path: Path) -> None:
    ran = CliRunner().invoke(keys, [str(tmp_path / "k"), "--viewer", "guest"])
    assert ran.exit_code == 0, ran.output
    assert {p.name for p in (tmp_path / "k").iterdir()} == {"authority", "vehicle", "guest"}
    assert "monitor: tls-listen://" in ran.output
    assert "topside" not in ran.output


@needs_openssl
def test_who_is_there_in_the_other_role_is_refused_and_nothing_is_made(tmp_path: Path) -> None:
    make_keys(tmp_path, ["deck"], lambda _: None, ["guest"])
    before = {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}
    for word, name, says in (
        ("--viewer", "deck", "a boat's, who may command the vehicle"),
        ("--boat", "guest", "a viewer's, who may only look"),
    ):
        ran = CliRunner().invoke(keys, [str(tmp_path), "--viewer", "new", word, name])
        assert ran.exit_code == 2
        assert says in ran.output
        assert "another name" in ran.output
    assert {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()} == before
    again = CliRunner().invoke(keys, [str(tmp_path), "--boat", "deck", "--viewer", "guest"])
    assert again.exit_code == 0, again.output


@needs_openssl
def test_one_name_is_no_boat_and_viewer_at_once(tmp_path: Path) -> None:
    with pytest.raises(KeysError, match="a boat and a viewer"):
        make_keys(tmp_path / "k", ["deck"], lambda _: None, ["deck"])
    assert not (tmp_path / "k").exists()


@pytest.mark.parametrize("name", ["../boat", "", "authority", "vehicle", "a b"])
def test_a_name_that_is_no_folder_of_its_own_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(KeysError):
        make_keys(tmp_path / "k", [name], lambda _: None)
    assert not (tmp_path / "k").exists()


def test_without_openssl_it_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    ran = CliRunner().invoke(keys, [str(tmp_path)])
    assert ran.exit_code == 2
    assert "apt install openssl" in ran.output


@pytest.mark.parametrize("arguments", [["/proc/x"], ["{folder}/k", "--boat", "../x"]])
def test_keys_that_cannot_be_made_there_are_an_error_of_the_call(
    arguments: list[str], tmp_path: Path
) -> None:
    ran = CliRunner().invoke(keys, [one.format(folder=tmp_path) for one in arguments])
    assert ran.exit_code == 2
    assert not list(tmp_path.iterdir())
