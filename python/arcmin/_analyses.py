"""One function and one class of results for every analysis, generated from the library's declarations."""

from __future__ import annotations

import inspect
import os
import textwrap
from collections.abc import Callable, Mapping
from typing import Any

from arcmin import _arcmin
from arcmin._errors import ComputeError, OptionError
from arcmin._progress import reporter
from arcmin._results import Result

#: Parameters of every function in addition to the options of its analysis.
_COMMON = (
    (
        "progress",
        "Function of stage and share (0…1), called from the calling thread; True for a bar, False for "
        "none, None for a bar in an interactive session after one second.",
    ),
    ("threads", "Threads for the parallel parts; results do not depend on it. None: all cores."),
)


def _design(given: object) -> _arcmin.Design:
    if isinstance(given, _arcmin.Design):
        return given
    if isinstance(given, (str, os.PathLike)):
        return _arcmin.Design.read(given)
    kind = type(given).__name__
    raise TypeError(
        f"design is a Design or the path of a design file, not a {kind}: Design.read(path) reads one"
    )


def _columns(name: str, given: Any) -> bytes:
    """Columns given as data, in the form of the file that the analysis reads."""
    columns: dict[str, list[object]] = {}
    for key in list(given.keys()):
        values = given[key]
        values = values.tolist() if hasattr(values, "tolist") else values
        if isinstance(values, (str, bytes)) or not hasattr(values, "__iter__"):
            raise OptionError(f"column `{key}` of `{name}` is a list of numbers, one a row", key=name)
        columns[str(key)] = list(values)
    lengths = {len(values) for values in columns.values()}
    if len(lengths) != 1:
        raise OptionError(f"columns of `{name}` have equal lengths of at least one row", key=name)
    for key in columns:
        if any(mark in key for mark in ',"\n\r'):
            raise OptionError(f"a column of `{name}` cannot be called {key!r}", key=name)
    lines = [",".join(columns)]
    for row in zip(*columns.values(), strict=True):
        lines.append(",".join(_cell(name, value) for value in row))
    return ("\n".join(lines) + "\n").encode()


def _cell(name: str, value: object) -> str:
    if value is None:
        return ""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise OptionError(f"`{name}` holds {value!r}, which is not a number", key=name) from None
    return "" if number != number else repr(number)


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"<{type(value).__name__}>"


def _make(entry: Mapping[str, Any]) -> tuple[Callable[..., Result], type[Result]]:
    name = entry["name"]
    kind = _result_class(entry)
    files = {option["name"] for option in entry["options"] if option["kind"] in ("file", "files")}
    required = [option["name"] for option in entry["options"] if option["required"]]
    places = [option["name"] for option in entry["options"] if option["positional"]]

    def analysis(
        design: Any, *positional: Any, progress: Any = None, threads: Any = None, **options: Any
    ) -> Result:
        asked = _design(design)
        if len(positional) > len(places):
            raise TypeError(f"{name}() takes {1 + len(places)} positional arguments; options go by name")
        for key, value in zip(places, positional, strict=False):
            if key in options:
                raise TypeError(f"{name}() got {key} twice")
            options[key] = value
        for key in required:
            if options.get(key) is None:
                raise OptionError(f"{name}() needs `{key}`", key=key)
        given: dict[str, bytes] = {}
        shown = [f"{key}={_shown(value)}" for key, value in options.items()] if options else []
        for key in files & options.keys():
            if hasattr(options[key], "keys") and not isinstance(options[key], type):
                given[f"<{key}>"] = _columns(key, options[key])
                options[key] = f"<{key}>"
        if not (threads is None or (isinstance(threads, int) and 1 <= threads <= 1024)):
            raise OptionError(
                f"`threads` is a whole number from 1 to 1024, not {_shown(threads)}", key="threads"
            )
        report, close = reporter(progress)
        try:
            core = _arcmin.run(name, asked, options, given, threads, report)
        finally:
            close()
        result = kind(core, f"arcmin.{name}({', '.join([repr(asked.file_name), *shown])})")
        if core.failure is not None:
            raise ComputeError(core.failure, result=result)
        return result

    analysis.__name__ = analysis.__qualname__ = name
    analysis.__module__ = "arcmin"
    analysis.__doc__ = _documentation(entry, kind)
    analysis.__signature__ = _signature(entry, kind)  # type: ignore[attr-defined]
    return analysis, kind


def _result_class(entry: Mapping[str, Any]) -> type[Result]:
    name = entry["name"].capitalize() + "Result"
    lines = [f"Answer of :func:`{entry['name']}`: {entry['about'][0].lower()}{entry['about'][1:]}.", ""]
    for table in entry["tables"]:
        columns = ", ".join(column["key"] for column in table["columns"])
        lines += textwrap.wrap(f"tables[{table['name']!r}]: {table['what']}. Columns {columns}.", 98)
    body: dict[str, Any] = {"__doc__": "\n".join(lines), "__module__": "arcmin"}
    for figure in entry["summary"]:
        key = figure["key"]
        if "." not in key and not hasattr(Result, key):
            body[key] = _figure(key, figure["what"], figure["unit"])
    return type(name, (Result,), body)


def _figure(key: str, what: str, unit: str) -> property:
    def get(self: Result) -> Any:
        return self.summary[key]

    return property(get, doc=f"{what} Unit: {unit}." if unit else what)


def _option_line(option: Mapping[str, Any]) -> str:
    parts = [option["documentation"].rstrip(".") + "."]
    if option["unit"]:
        parts.append(f"Unit: {option['unit']}.")
    if option["choices"]:
        parts.append("; ".join(f'"{word}": {meaning}' for word, meaning in option["choices"]) + ".")
    if option["range"] and option["kind"] in ("number", "count"):
        low, high = option["range"]
        parts.append(f"From {low:g} to {high:g}.")
    if option["kind"] in ("file", "files"):
        parts.append("A path, or the columns themselves as a mapping of names to arrays of shape (rows,).")
    return " ".join(parts)


def _documentation(entry: Mapping[str, Any], kind: type[Result]) -> str:
    lines = textwrap.wrap(entry["about"] + ".", 98) + [""]
    for paragraph in entry["guide"].split("\n\n"):
        lines += textwrap.wrap(" ".join(paragraph.split()), 98) + [""]
    lines += ["Parameters", "----------", "design : Design, or path of a design file"]
    for option in entry["options"]:
        default = "" if option["required"] else f", default {option['default']!r}"
        lines.append(f"{option['name']} : {_type(option)}{default}")
        lines += ["    " + line for line in textwrap.wrap(_option_line(option), 94)]
    for name, what in _COMMON:
        lines.append(f"{name} : default None")
        lines += ["    " + line for line in textwrap.wrap(what, 94)]
    lines += ["", "Returns", "-------", kind.__name__]
    for table in entry["tables"]:
        lines += ["", f"``tables[{table['name']!r}]``: {table['what']}. Arrays of shape (rows,):"]
        for column in table["columns"]:
            unit = f" Unit: {column['unit']}." if column["unit"] else ""
            text = f"{column['key']}: {column['what']}{unit}"
            lines += textwrap.wrap(text, 98, initial_indent="    ", subsequent_indent="        ")
    lines += ["", "``summary``:"]
    for figure in entry["summary"]:
        unit = f" Unit: {figure['unit']}." if figure["unit"] else ""
        text = f"{figure['key']}: {figure['what']}{unit}"
        lines += textwrap.wrap(text, 98, initial_indent="    ", subsequent_indent="        ")
    return "\n".join(lines) + "\n"


def _type(option: Mapping[str, Any]) -> str:
    """Type of an option as a stub writes it."""
    if option["choices"]:
        words = ", ".join(f'"{word}"' for word, _ in option["choices"])
        kind = f"Literal[{words}]"
    else:
        kind = {
            "number": "float",
            "count": "int",
            "flag": "bool",
            "file": "File",
            "files": "Sequence[File]",
            "texts": "Sequence[str]",
            "numbers": "Sequence[float]",
        }.get(option["kind"], "str")
    return kind if option["required"] or option["default"] is not None else f"{kind} | None"


def _signature(entry: Mapping[str, Any], kind: type[Result]) -> inspect.Signature:
    positional = inspect.Parameter.POSITIONAL_OR_KEYWORD
    named = inspect.Parameter.KEYWORD_ONLY
    parameters = [inspect.Parameter("design", positional)]
    places = [option for option in entry["options"] if option["positional"]]
    others = [option for option in entry["options"] if not option["positional"]]
    for option in places:
        default = inspect.Parameter.empty if option["required"] else option["default"]
        parameters.append(inspect.Parameter(option["name"], positional, default=default))
    parameters += [inspect.Parameter(option["name"], named, default=option["default"]) for option in others]
    parameters += [inspect.Parameter(name, named, default=None) for name, _ in _COMMON]
    return inspect.Signature(parameters, return_annotation=kind.__name__)


#: The library's declarations, for stubs and documentation.
registry: list[dict[str, Any]] = _arcmin.analyses()
__all__: list[str] = []

for _entry in registry:
    _function, _class = _make(_entry)
    globals()[_entry["name"]] = _function
    globals()[_class.__name__] = _class
    __all__ += [_entry["name"], _class.__name__]
