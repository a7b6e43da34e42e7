"""The page's own tests, which are written in its language."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from served import PATIENCE

NODE = shutil.which("node")
TESTS = sorted(Path(__file__).with_name("page").glob("*.test.js"))


@pytest.mark.skipif(NODE is None, reason="no node here: apt-get install nodejs")
def test_the_modules_of_the_page_do_what_their_own_tests_say() -> None:
    assert NODE is not None
    assert TESTS
    ran = subprocess.run(
        [NODE, "--test", *TESTS], capture_output=True, text=True, timeout=5 * PATIENCE, check=False
    )
    assert ran.returncode == 0, ran.stdout
