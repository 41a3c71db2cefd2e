"""Executes the examples as notebooks, writes them and their pages of the book.

``python python/tools/notebooks.py [NAME …]``

``--check`` executes them again and compares: the text of all outputs must agree with the stored notebooks,
numbers within a thousandth, and the same outputs must be figures. Needs nbclient, ipykernel and the packages
of the examples. A test fails if code, notebook and page differ.
"""

from __future__ import annotations

import json
import math
import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "python" / "examples"
NOTEBOOKS = ROOT / "docs" / "notebooks"
PAGES = ROOT / "docs" / "src" / "notebooks"
#: Limit of the size of outputs, which are for readers, not data storage.
MOST_BYTES = 100_000
#: Relative tolerance of numbers between two executions, for different rounding on other processors.
TOLERANCE = 1e-3

#: Drawings as reproducible text.
SETUP = """
import matplotlib

%config InlineBackend.figure_formats = ["svg"]
%config InlineBackend.print_figure_kwargs = {"metadata": {"Date": None}}
matplotlib.rcParams.update({"svg.hashsalt": "arcmin", "svg.fonttype": "none", "font.family": "sans-serif"})
"""
SVG = "image/svg+xml"
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def cells(script: str) -> list[dict[str, Any]]:
    """Cells of a script whose parts are marked with ``# %%``."""
    out = []
    for part in script.split("# %%")[1:]:
        head, _, body = part.partition("\n")
        source = body.strip("\n")
        if "[markdown]" in head:
            lines = [line.removeprefix("#").removeprefix(" ") for line in source.splitlines()]
            out.append({"cell_type": "markdown", "metadata": {}, "source": "\n".join(lines)})
        else:
            out.append(
                {
                    "cell_type": "code",
                    "metadata": {},
                    "source": source,
                    "outputs": [],
                    "execution_count": None,
                }
            )
    return out


def text_of(value: str | list[str]) -> str:
    """Text as notebooks keep it, in one piece or line by line."""
    return value if isinstance(value, str) else "".join(value)


def shown(output: dict[str, Any]) -> tuple[str, str] | None:
    """Kind and content of an output that readers see: "text" or "figure"."""
    if output.get("name") == "stderr":
        # Progress bars and warnings are omitted.
        return None
    if output["output_type"] == "stream":
        return "text", text_of(output["text"])
    data = output.get("data", {})
    if SVG in data:
        return "figure", text_of(data[SVG])
    plain = text_of(data.get("text/plain", ""))
    # The representation of a matplotlib object with its memory address is omitted.
    return None if not plain or re.search(r"<.* at 0x", plain) or "Text(" in plain else ("text", plain)


def execute(path: Path) -> dict[str, Any]:
    """The notebook of an example, executed."""
    import nbformat
    from nbclient import NotebookClient

    setup = {"cell_type": "code", "metadata": {}, "source": SETUP, "outputs": [], "execution_count": None}
    content = {"cells": [setup, *cells(path.read_text())], "metadata": {}, "nbformat": 4, "nbformat_minor": 4}
    book = nbformat.reads(json.dumps(content), as_version=4)
    NotebookClient(book, timeout=1200, kernel_name="python3").execute()
    del book.cells[0]
    for cell in book.cells:
        cell.metadata.clear()
        if cell.cell_type == "code":
            cell.execution_count -= 1
            cell.outputs = [one for one in cell.outputs if shown(one)]
            for output in cell.outputs:
                if "execution_count" in output:
                    output.execution_count = cell.execution_count
                if SVG in output.get("data", {}):
                    output.data = nbformat.from_dict({SVG: output.data[SVG]})
    book.metadata = nbformat.from_dict({"kernelspec": {"name": "python3", "display_name": "Python 3"}})
    written: dict[str, Any] = json.loads(nbformat.writes(book, version=4))
    return written


def page(name: str, book: dict[str, Any]) -> dict[str, str]:
    """Files of the page of a notebook by their names, Markdown and drawings. It begins with its title."""
    files: dict[str, str] = {}
    parts: list[str] = []
    title = text_of(book["cells"][0]["source"]).splitlines()[0].removeprefix("# ")
    for cell in book["cells"]:
        source = text_of(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        parts.append(f"```python\n{source}\n```")
        for output in cell["outputs"]:
            found = shown(output)
            if found and found[0] == "text":
                parts.append("```text\n" + found[1].rstrip("\n") + "\n```")
            elif found:
                figure = f"{name}-{len(files) + 1}.svg"
                files[figure] = "\n".join(line.rstrip() for line in found[1].splitlines()) + "\n"
                parts.append(f"![{title}: figure {len(files)}]({figure})")
    tool = "`python/tools/notebooks.py`"
    end = f"This page is `docs/notebooks/{name}.ipynb` of the repository, executed by {tool}."
    return {f"{name}.md": "\n\n".join([*parts, "---", end]) + "\n", **files}


def same_text(stored: str, found: str) -> bool:
    """Whether two texts are equal except for numbers within the tolerance."""
    if NUMBER.sub("0", stored) != NUMBER.sub("0", found):
        return False
    pairs = zip(NUMBER.findall(stored), NUMBER.findall(found), strict=True)
    return all(math.isclose(float(a), float(b), rel_tol=TOLERANCE) for a, b in pairs)


def differences(stored: dict[str, Any], found: dict[str, Any]) -> list[str]:
    """Cells whose outputs differ, in words."""
    out = []
    pairs = zip(stored["cells"], found["cells"], strict=True)
    for number, (before, now) in enumerate(pairs, 1):
        kept, made = ([shown(one) for one in cell.get("outputs", [])] for cell in (before, now))
        if [one and one[0] for one in kept] != [one and one[0] for one in made]:
            out.append(f"cell {number} has other outputs than the stored notebook")
            continue
        for one, other in zip(kept, made, strict=True):
            if one and other and one[0] == "text" and not same_text(one[1], other[1]):
                out.append(f"cell {number} prints\n{other[1]}\nwhere the stored notebook has\n{one[1]}")
    return out


def main() -> None:
    check = "--check" in sys.argv
    wanted = {word for word in sys.argv[1:] if word != "--check"}
    wrong = False
    for path in sorted(EXAMPLES.glob("*.py")):
        if wanted and path.stem not in wanted:
            continue
        book = execute(path)
        target = NOTEBOOKS / f"{path.stem}.ipynb"
        if check:
            found = differences(json.loads(target.read_text()), book)
            sys.stdout.write(f"{path.stem}: {'; '.join(found) or 'as stored'}\n")
            wrong = wrong or bool(found)
            continue
        text = json.dumps(book, indent=1, ensure_ascii=False, sort_keys=True) + "\n"
        if len(text.encode()) > MOST_BYTES:
            raise SystemExit(f"{path.stem}: {len(text)} bytes are too much for a notebook of the docs")
        NOTEBOOKS.mkdir(parents=True, exist_ok=True)
        PAGES.mkdir(parents=True, exist_ok=True)
        target.write_text(text)
        for name, content in page(path.stem, book).items():
            (PAGES / name).write_text(content)
        sys.stdout.write(f"{path.stem}: {len(text)} bytes\n")
    if wrong:
        raise SystemExit("`python python/tools/notebooks.py` writes the notebooks and their pages anew")


if __name__ == "__main__":
    main()
