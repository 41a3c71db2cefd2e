"""Writes the examples as executed notebooks: ``python python/tools/notebooks.py``.

Needs nbclient, ipykernel and what the examples use. A test fails where code and notebook differ.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "python" / "examples"
NOTEBOOKS = ROOT / "docs" / "notebooks"
#: Outputs stay small: a notebook is read, not stored data.
MOST_BYTES = 100_000


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


def main() -> None:
    import nbformat
    from nbclient import NotebookClient

    NOTEBOOKS.mkdir(parents=True, exist_ok=True)
    wanted = set(sys.argv[1:])
    for path in sorted(EXAMPLES.glob("*.py")):
        if wanted and path.stem not in wanted:
            continue
        content = {"cells": cells(path.read_text()), "metadata": {}, "nbformat": 4, "nbformat_minor": 4}
        book = nbformat.reads(json.dumps(content), as_version=4)
        NotebookClient(book, timeout=1200, kernel_name="python3").execute()
        for cell in book.cells:
            cell.metadata.clear()
            # Bars and warnings of this machine teach nobody.
            if cell.cell_type == "code":
                cell.outputs = [one for one in cell.outputs if one.get("name") != "stderr"]
        book.metadata = nbformat.from_dict({"kernelspec": {"name": "python3", "display_name": "Python 3"}})
        text = nbformat.writes(book, version=4)
        if len(text.encode()) > MOST_BYTES:
            raise SystemExit(f"{path.stem}: {len(text)} bytes are too much for a notebook of the docs")
        (NOTEBOOKS / f"{path.stem}.ipynb").write_text(text + "\n")
        sys.stdout.write(f"{path.stem}: {len(text)} bytes\n")


if __name__ == "__main__":
    main()
