"""Stubs are correct by mypy's strict mode and stubtest; those of the analyses agree with declarations."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_stubs_of_the_analyses_are_current() -> None:
    sys.path.insert(0, str(ROOT / "python" / "tools"))
    import stubs

    for target, content in stubs.texts().items():
        assert target.read_text() == content, "`python python/tools/stubs.py` writes them"


def run(*words: str) -> None:
    ran = subprocess.run(
        [sys.executable, "-m", *words], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr


def test_types_are_strict() -> None:
    pytest.importorskip("mypy")
    run("mypy", "--strict", "python/arcmin")


def test_stubs_are_those_of_the_module() -> None:
    pytest.importorskip("mypy")
    run("mypy.stubtest", "arcmin", "--mypy-config-file", "pyproject.toml")
