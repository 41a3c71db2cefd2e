"""Writes the stubs of the analyses from what the library declares: ``python python/tools/stubs.py``.

A test fails until they have been written anew.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from arcmin._analyses import _type, registry
from arcmin._results import Result

TARGET = Path(__file__).parents[1] / "arcmin" / "_analyses.pyi"

HEAD = """# Written by python/tools/stubs.py from what the library declares.

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from arcmin._arcmin import Design
from arcmin._progress import Progress
from arcmin._results import Result

#: A path, or the columns of the table themselves.
File = str | os.PathLike[str] | Mapping[str, Any]

registry: list[dict[str, Any]]
"""


def function(entry: Mapping[str, Any]) -> str:
    required = [option for option in entry["options"] if option["required"]]
    others = [option for option in entry["options"] if not option["required"]]
    lines = [f"def {entry['name']}(", "    design: Design | str | os.PathLike[str],"]
    lines += [f"    {option['name']}: {_type(option)}," for option in required]
    lines.append("    *,")
    for option in others:
        default = f'"{option["default"]}"' if isinstance(option["default"], str) else repr(option["default"])
        lines.append(f"    {option['name']}: {_type(option)} = {default},")
    lines += ["    progress: Progress = None,", "    threads: int | None = None,"]
    lines.append(f") -> {entry['name'].capitalize()}Result: ...")
    return "\n".join(lines)


def result(entry: Mapping[str, Any]) -> str:
    lines = [f"class {entry['name'].capitalize()}Result(Result):"]
    for figure in entry["summary"]:
        if "." not in figure["key"] and not hasattr(Result, figure["key"]):
            lines += ["    @property", f"    def {figure['key']}(self) -> Any: ..."]
    return "\n".join(lines)


def text() -> str:
    names = [name for entry in registry for name in (entry["name"], f"{entry['name'].capitalize()}Result")]
    exported = "__all__ = [\n" + "".join(f'    "{name}",\n' for name in names) + "]"
    parts = [HEAD, exported]
    for entry in registry:
        parts += [result(entry), function(entry)]
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


if __name__ == "__main__":
    TARGET.write_text(text())
    sys.stdout.write(f"{TARGET}\n")
