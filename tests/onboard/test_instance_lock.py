"""One serve for one folder."""

from __future__ import annotations

import errno
import fcntl
import os
import subprocess
import sys
from pathlib import Path

import pytest
from served import PATIENCE, silent_board, soon

from mission.onboard.serve.instance_lock import AnotherServe, only_one


def test_a_second_one_is_refused_until_the_first_has_ended(tmp_path: Path) -> None:
    with only_one(tmp_path):
        with pytest.raises(AnotherServe, match=f"folder {tmp_path}: stop that one first"):
            only_one(tmp_path).__enter__()
        (tmp_path / "other").mkdir()
        with only_one(tmp_path / "other"):
            pass
    with only_one(tmp_path):
        pass


def test_a_disk_that_knows_no_locks_keeps_nobody_from_beginning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", refuse)
    with only_one(tmp_path), only_one(tmp_path), only_one(tmp_path / "absent"):
        pass


@pytest.mark.proof
def test_a_serve_by_hand_beside_the_service_ends_with_the_reason(tmp_path: Path) -> None:
    ready = tmp_path / "ready.json"
    with silent_board() as (_, device):
        call = [sys.executable, "-m", "mission", "serve", "--vehicle", f"serial://{device}"]
        call += ["--gps", "none", "--topside", "tcp://127.0.0.1:0", "--folder", str(tmp_path)]
        with subprocess.Popen([*call, "--ready-file", str(ready)]) as first:
            try:
                soon(lambda: ready.exists() and (tmp_path / "status.json").exists(), "ready")
                second = subprocess.run(
                    call, capture_output=True, text=True, check=False, timeout=PATIENCE
                )
                assert second.returncode == 2
                assert f"another serve (process {first.pid}) runs" in second.stderr
                assert first.poll() is None
            finally:
                first.kill()
        third = [*call, "--ready-file", str(ready)]
        ready.unlink()
        with subprocess.Popen(third) as after:  # a lock does not outlive its process
            soon(ready.exists, "ready again")
            after.terminate()
        assert after.returncode == 0
