"""The chapters of the book on the package agree with it."""

from __future__ import annotations

import json
import os
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "python" / "tools"))


def test_the_reference_is_current() -> None:
    import reference

    assert reference.TARGET.read_text() == reference.text(), "`python python/tools/reference.py` writes it"


def test_static_methods_have_their_own_documentation() -> None:
    import reference

    import arcmin

    page = reference.of_class("Design")
    assert "Convert a function" not in page
    for name in ("parse", "read", "template", "templates"):
        documentation = " ".join(getattr(arcmin.Design, name).__doc__.split())
        assert re.search(rf"\* `{name}\(.*?\)`: {re.escape(reference.plain(documentation))}", page), name


@pytest.mark.parametrize("page", ["python.md", "tutorials/simulate.md"])
def test_the_code_of_a_page_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The code of the page in one session, top to bottom."""
    chapter = (ROOT / "docs" / "src" / page).read_text()
    monkeypatch.chdir(tmp_path)
    session: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", chapter, re.DOTALL):
        exec(compile(block, f"docs/src/{page}", "exec"), session)  # noqa: S102
    assert os.listdir(tmp_path)


@pytest.mark.parametrize("name", sorted(path.stem for path in (ROOT / "python" / "examples").glob("*.py")))
def test_notebooks_are_the_examples(name: str) -> None:
    import notebooks

    book = json.loads((notebooks.NOTEBOOKS / f"{name}.ipynb").read_text())
    code = [cell for cell in book["cells"] if cell["cell_type"] == "code"]

    def source(cell: dict[str, object]) -> str:
        lines = cell["source"]
        return lines if isinstance(lines, str) else "".join(lines)  # type: ignore[arg-type]

    script = (notebooks.EXAMPLES / f"{name}.py").read_text()
    assert [source(cell) for cell in book["cells"]] == [cell["source"] for cell in notebooks.cells(script)]
    assert any(cell["outputs"] for cell in code), "`python python/tools/notebooks.py` executes them"
    assert (notebooks.NOTEBOOKS / f"{name}.ipynb").stat().st_size < notebooks.MOST_BYTES


@pytest.mark.parametrize("name", sorted(path.stem for path in (ROOT / "python" / "examples").glob("*.py")))
def test_pages_of_the_book_are_the_notebooks(name: str) -> None:
    """Text, outputs and drawings of a page are those of its notebook, and the book lists it."""
    import notebooks

    files = notebooks.page(name, json.loads((notebooks.NOTEBOOKS / f"{name}.ipynb").read_text()))
    for file, content in files.items():
        assert (notebooks.PAGES / file).read_text() == content, "`python python/tools/notebooks.py` writes it"
    assert {path.name for path in notebooks.PAGES.glob(f"{name}*")} == set(files)
    assert f"(notebooks/{name}.md)" in (ROOT / "docs" / "src" / "SUMMARY.md").read_text()


@pytest.mark.parametrize(
    ("found", "same"),
    [
        ("k = 1.2005e-18 of 24", True),
        ("k = 1.203e-18 of 24", False),
        ("k = 1.2e-18 in 24", False),
        ("", False),
    ],
)
def test_outputs_are_compared(found: str, same: bool) -> None:
    """Numbers may differ by a thousandth, words may not, nor may an output be missing."""
    import notebooks

    def book(text: str) -> dict[str, object]:
        outputs = [{"output_type": "stream", "name": "stdout", "text": text}] if text else []
        return {"cells": [{"cell_type": "code", "source": "print(k)", "outputs": outputs}]}

    assert (not notebooks.differences(book("k = 1.2e-18 of 24"), book(found))) == same
