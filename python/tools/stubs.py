"""Writes the stubs of the analyses from the library's declarations: ``python python/tools/stubs.py``.

A test fails until they have been written anew.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import arcmin
from arcmin import _analyses, _arcmin, _errors, _explore, _results, _robot, _study
from arcmin._analyses import _type, registry
from arcmin._results import Result

modules = {
    "_analyses": _analyses,
    "_arcmin": _arcmin,
    "_errors": _errors,
    "_explore": _explore,
    "_results": _results,
    "_robot": _robot,
    "_study": _study,
}

PACKAGE = Path(__file__).parents[1] / "arcmin"

HEAD = """# Written by python/tools/stubs.py from the declarations of the library.

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from arcmin._arcmin import Design
from arcmin._progress import Progress
from arcmin._results import Result

# A path, or the columns of the table themselves.
_File = str | os.PathLike[str] | Mapping[str, Any]

registry: list[dict[str, Any]]
"""


def written(option: Mapping[str, Any]) -> str:
    return _type(option).replace("File", "_File")


def function(entry: Mapping[str, Any]) -> str:
    def parameter(option: Mapping[str, Any]) -> str:
        default = f'"{option["default"]}"' if isinstance(option["default"], str) else repr(option["default"])
        given = "" if option["required"] else f" = {default}"
        return f"    {option['name']}: {written(option)}{given},"

    lines = [f"def {entry['name']}(", "    design: Design | str | os.PathLike[str],"]
    lines += [parameter(option) for option in entry["options"] if option["positional"]]
    lines.append("    *,")
    lines += [parameter(option) for option in entry["options"] if not option["positional"]]
    lines += ["    progress: Progress = None,", "    threads: int | None = None,"]
    lines.append(f") -> {entry['name'].capitalize()}Result: ...")
    return "\n".join(lines)


def result(entry: Mapping[str, Any]) -> str:
    lines = [f"class {entry['name'].capitalize()}Result(Result):"]
    for figure in entry["summary"]:
        if "." not in figure["key"] and not hasattr(Result, figure["key"]):
            lines += ["    @property", f"    def {figure['key']}(self) -> Any: ..."]
    return "\n".join(lines)


def of_package() -> str:
    """``__init__.pyi``: mypy does not know names that are created at run time."""
    names = [name for entry in registry for name in (entry["name"], f"{entry['name'].capitalize()}Result")]
    origins = {"_analyses": names}
    for name in arcmin.__all__:
        if name in names:
            continue
        value = getattr(arcmin, name)
        homes = ("_arcmin", "_errors", "_explore", "_results", "_robot", "_study")
        module = next(home for home in homes if hasattr(modules[home], name))
        assert value is getattr(modules[module], name)
        origins.setdefault(module, []).append(name)
    lines = ["# Written by python/tools/stubs.py.", ""]
    for module, exported in sorted(origins.items()):
        lines.append(f"from arcmin.{module} import (")
        lines += [f"    {name} as {name}," for name in sorted(exported)]
        lines.append(")")
    lines += ["", "__all__ = ["] + [f'    "{name}",' for name in arcmin.__all__] + ["]"]
    return "\n".join(lines) + "\n"


def texts() -> dict[Path, str]:
    """Every generated stub, by its path."""
    return {PACKAGE / "_analyses.pyi": text(), PACKAGE / "__init__.pyi": of_package()}


def text() -> str:
    names = [name for entry in registry for name in (entry["name"], f"{entry['name'].capitalize()}Result")]
    exported = "__all__ = [\n" + "".join(f'    "{name}",\n' for name in names) + "]"
    parts = [HEAD, exported]
    for entry in registry:
        parts += [result(entry), function(entry)]
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


if __name__ == "__main__":
    for target, content in texts().items():
        target.write_text(content)
        sys.stdout.write(f"{target}\n")
