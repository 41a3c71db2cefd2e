"""Writes the reference chapter from the docstrings: ``python python/tools/reference.py``.

A test fails until it has been written anew.
"""

from __future__ import annotations

import inspect
import sys
from pathlib import Path

import arcmin
from arcmin._analyses import registry

TARGET = Path(__file__).parents[2] / "docs" / "src" / "python-reference.md"

HEAD = """# Python: reference

Written by `python/tools/reference.py` from the documentation of the package; `help(arcmin.life)` shows the
same. Units stand at the end of every name; arrays have the shape that is said with them.
"""


def plain(text: str | None) -> str:
    """A docstring as Markdown."""
    return inspect.cleandoc(text or "").replace(":meth:", "").replace(":func:", "").replace(":class:", "")


def of_class(name: str) -> str:
    kind = getattr(arcmin, name)
    parts = [f"### `{name}`", plain(kind.__doc__)]
    for member, value in sorted(vars(kind).items()):
        if member.startswith("_"):
            continue
        call = ""
        if callable(value) or isinstance(value, staticmethod):
            try:
                call = str(inspect.signature(getattr(kind, member))).replace("self, ", "").replace("self", "")
            except (TypeError, ValueError):
                call = "(…)"
        # The attribute of the class: the object in `vars` of a static method documents `staticmethod` itself.
        documentation = " ".join(plain(getattr(getattr(kind, member), "__doc__", "")).split())
        if documentation:
            parts.append(f"* `{member}{call}`: {documentation}")
    return "\n\n".join(parts[:2]) + "\n\n" + "\n".join(parts[2:])


def of_errors() -> str:
    names = ["ArcminError", "DesignError", "UnknownKeyError", "OptionError", "InputError", "ComputeError"]
    rows = []
    for name in names:
        kind = getattr(arcmin, name)
        bases = ", ".join(f"`{base.__name__}`" for base in kind.__bases__)
        rows.append(f"| `{name}` | {bases} | {plain(kind.__doc__)} |")
    return "| exception | is also | means |\n|---|---|---|\n" + "\n".join(rows)


def text() -> str:
    parts = [HEAD, "## Designs, results, simulation, geometry"]
    parts += [
        of_class(name)
        for name in ("Design", "Key", "Result", "Verdict", "Table", "Simulation", "State", "Flank")
    ]
    signature = str(inspect.signature(arcmin.sample))
    parts.append(f"### `sample{signature}`\n\n{plain(arcmin.sample.__doc__)}")
    parts += ["## Exceptions", of_errors(), "## Analyses"]
    for entry in registry:
        function = getattr(arcmin, entry["name"])
        parts.append(f"### `{entry['name']}`\n\n```text\n{plain(function.__doc__)}\n```")
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


if __name__ == "__main__":
    TARGET.write_text(text())
    sys.stdout.write(f"{TARGET}\n")
