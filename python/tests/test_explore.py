"""The explorer from Python."""

from __future__ import annotations

import json
import urllib.error
import urllib.request
from pathlib import Path

import pytest

import arcmin


def state(url: str) -> dict[str, object]:
    with urllib.request.urlopen(url.replace("/?", "/api/state?"), timeout=60) as answer:
        found: dict[str, object] = json.load(answer)
    return found


def test_an_explorer_responds_until_it_is_closed(tmp_path: Path) -> None:
    design = arcmin.Design.template("nema17-19")
    with arcmin.explore(design, open_browser=False) as explorer:
        assert explorer.url.startswith("http://127.0.0.1:") and explorer.url in repr(explorer)
        assert state(explorer.url)
    assert "closed" in repr(explorer)
    with pytest.raises(urllib.error.URLError):
        state(explorer.url)
    explorer.close()
    path = tmp_path / "d.toml"
    path.write_text(design.to_toml())
    other = arcmin.explore(path, open_browser=False)
    assert state(other.url)
    other.close()


def test_an_explorer_that_cannot_start_reports_the_reason(tmp_path: Path) -> None:
    with pytest.raises(arcmin.ComputeError, match="none.toml"):
        arcmin.explore(tmp_path / "none.toml", open_browser=False)
