"""Display of a result in a notebook: headline, key results, main plot; plain HTML and SVG."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any

__all__ = ["glance", "plot"]

_WIDTH, _HEIGHT = 640.0, 300.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 62.0, 12.0, 10.0, 42.0
#: Okabe and Ito's colours, distinguishable by colour-blind readers.
_PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_TONES = {"good": "#009e73", "caution": "#b37400", "bad": "#c0392b", "neutral": "#57606a"}
#: Number of points of a line that a figure of this width can resolve, including the lobes of a flank.
_POINTS = 1200
_MARKS = 120


def glance(data: Mapping[str, Any]) -> str:
    """Headline, key results and main plot of a result."""
    colour = _TONES.get(data["tone"], _TONES["neutral"])
    parts = [
        '<div style="max-width:660px;font-family:sans-serif">',
        f'<div style="opacity:.7;font-size:85%">{escape(data["title"])} – {escape(data["subtitle"])}</div>',
        f'<div style="border-left:4px solid {colour};padding-left:8px;font-weight:600">'
        f"{escape(data['headline'])}</div>",
    ]
    if data["figures"]:
        parts.append('<div style="display:flex;flex-wrap:wrap;gap:18px;margin:8px 0">')
        for figure in data["figures"]:
            parts.append(
                f'<div title="{escape(figure["note"])}"><div style="opacity:.7;font-size:80%">'
                f"{escape(figure['label'])}</div><b>{escape(figure['value'])}</b> "
                f"{escape(figure['unit'])}</div>"
            )
        parts.append("</div>")
    if data["plot"]:
        parts.append(plot(data["plot"]))
    parts.append("</div>")
    return "".join(parts)


def _ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Round numbers within a range."""
    span = high - low
    raw = span / count
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= raw * (1 - 1e-9))
    first = math.ceil(low / step - 1e-9)
    last = math.floor(high / step + 1e-9)
    return [index * step for index in range(first, last + 1)]


class _Axis:
    """Map of a range of numbers to a range of the page."""

    def __init__(self, axis: Mapping[str, Any], values: Sequence[float], start: float, end: float) -> None:
        self.is_log = axis["scale"] == "log"
        self._is_counted = axis["counted"]
        self._start, self._end = start, end
        known = [value for value in values if math.isfinite(value) and (value > 0 or not self.is_log)]
        if axis["range"]:
            self.low, self.high = axis["range"]
        else:
            self.low, self.high = (min(known), max(known)) if known else (0.0, 1.0)
            if axis["include_zero"] and not self.is_log:
                self.low, self.high = min(self.low, 0.0), max(self.high, 0.0)
        if not self.high > self.low:
            margin = abs(self.low) * 0.05 or 1.0
            self.low, self.high = self.low - margin, self.high + margin
        if self.is_log:
            self.low, self.high = max(self.low, 1e-300), max(self.high, 1e-299)

    def at(self, value: float) -> float:
        if self.is_log:
            share = math.log(value / self.low) / math.log(self.high / self.low) if value > 0 else math.nan
        else:
            share = (value - self.low) / (self.high - self.low)
        return self._start + share * (self._end - self._start)

    def ticks(self) -> list[float]:
        if self.is_log:
            powers = range(
                math.ceil(math.log10(self.low) - 1e-9), math.floor(math.log10(self.high) + 1e-9) + 1
            )
            return [10.0**power for power in powers]
        ticks = _ticks(self.low, self.high)
        return [tick for tick in ticks if tick.is_integer()] if self._is_counted else ticks


def _equal(x: _Axis, y: _Axis) -> None:
    """Equal scales of both axes."""
    wide, tall = _WIDTH - _LEFT - _RIGHT, _HEIGHT - _TOP - _BOTTOM
    per_pixel = max((x.high - x.low) / wide, (y.high - y.low) / tall)
    for axis, pixels in ((x, wide), (y, tall)):
        middle = (axis.low + axis.high) / 2
        axis.low, axis.high = middle - per_pixel * pixels / 2, middle + per_pixel * pixels / 2


def _colour(choice: Any, index: int) -> str:
    if choice == "reference":
        return "#6e7781"
    if isinstance(choice, dict) and "palette" in choice:
        return _PALETTE[choice["palette"] % len(_PALETTE)]
    if isinstance(choice, dict) and "ordered" in choice:
        return f"hsl({220 - 200 * float(choice['ordered']):.0f},70%,45%)"
    return _PALETTE[index % len(_PALETTE)]


def plot(data: Mapping[str, Any]) -> str:
    """A plot of a report as an image without scripts."""
    series = [one for one in data["series"] if not one["hidden"]]
    xs = [value for one in series for value in one["points"]["x"]]
    ys = [value for one in series for name in ("y", "low") for value in one["points"].get(name, ())]
    for mark in data["annotations"]:
        if mark["kind"] == "horizontal":
            ys.append(mark["at"])
    x = _Axis(data["x"], xs, _LEFT, _WIDTH - _RIGHT)
    y = _Axis(data["y"], [value for value in ys if value is not None], _HEIGHT - _BOTTOM, _TOP)
    if data.get("equal_scales"):
        _equal(x, y)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" width="100%" '
        f'role="img" aria-label="{escape(data["title"])}" font-size="11" fill="currentColor" '
        'font-family="sans-serif">'
    ]
    for value in x.ticks():
        at = x.at(value)
        parts.append(_line(at, _TOP, at, _HEIGHT - _BOTTOM) + _text(at, _HEIGHT - _BOTTOM + 14, f"{value:g}"))
    for value in y.ticks():
        at = y.at(value)
        parts.append(_line(_LEFT, at, _WIDTH - _RIGHT, at) + _text(_LEFT - 5, at + 4, f"{value:g}", "end"))
    for index, one in enumerate(series):
        parts.append(_series(one, _colour(one["colour"], index), x, y))
    for mark in data["annotations"]:
        if mark["kind"] == "horizontal" and y.low <= mark["at"] <= y.high:
            at = y.at(mark["at"])
            colour = _TONES.get(mark["tone"], _TONES["neutral"])
            parts.append(
                f'<path d="M{_LEFT:g} {at:.1f}H{_WIDTH - _RIGHT:g}" '
                f'stroke="{colour}" stroke-dasharray="5 4"/>'
                + _text(_WIDTH - _RIGHT - 3, at - 4, mark["label"], "end")
            )
    parts.append(_text((_LEFT + _WIDTH - _RIGHT) / 2, _HEIGHT - 10, _label(data["x"])))
    middle = (_TOP + _HEIGHT - _BOTTOM) / 2
    parts.append(
        f'<text transform="translate(13 {middle:g}) rotate(-90)" text-anchor="middle">'
        f"{escape(_label(data['y']))}</text></svg>"
    )
    named = [(one["name"], _colour(one["colour"], index)) for index, one in enumerate(series)]
    if len(named) > 1:
        parts.append('<div style="font-size:80%">')
        for name, colour in named[:12]:
            parts.append(f'<span style="color:{colour}">■</span> {escape(name)} &emsp;')
        parts.append("</div>")
    return f'<div style="font-size:85%;margin-top:6px">{escape(data["title"])}</div>' + "".join(parts)


def _label(axis: Mapping[str, Any]) -> str:
    return f"{axis['label']} in {axis['unit']}" if axis["unit"] else str(axis["label"])


def _line(x1: float, y1: float, x2: float, y2: float) -> str:
    return f'<path d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}" stroke="#888" stroke-opacity=".25"/>'


def _text(x: float, y: float, text: str, anchor: str = "middle") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _thinned(count: int, most: int) -> range:
    return range(0, count, max(1, -(-count // most)))


def _series(one: Mapping[str, Any], colour: str, x: _Axis, y: _Axis) -> str:
    points, style = one["points"], one["style"]
    xs, ys = points["x"], points["y"]
    width = 2.4 if one["strong"] else 1.5
    if style == "band":
        low = points.get("low", ())
        there = [i for i in range(len(xs)) if ys[i] is not None and low[i] is not None]
        upper = [f"{x.at(xs[i]):.1f} {y.at(ys[i]):.1f}" for i in there]
        lower = [f"{x.at(xs[i]):.1f} {y.at(low[i]):.1f}" for i in reversed(there)]
        return f'<path d="M{"L".join(upper + lower)}Z" fill="{colour}" fill-opacity=".18"/>' if there else ""
    out = ""
    if style in ("line", "dashed", "line_markers", "step"):
        dash = ' stroke-dasharray="5 3"' if style == "dashed" else ""
        out += f'<path d="{_path(xs, ys, x.at, y.at, style == "step")}" fill="none" stroke="{colour}" '
        out += f'stroke-width="{width:g}"{dash}/>'
    if style == "bars":
        zero = y.at(max(0.0, y.low)) if not y.is_log else y.at(y.low)
        for i in _thinned(len(xs), _POINTS):
            if ys[i] is not None and (ys[i] > 0 or not y.is_log):
                out += f'<path d="M{x.at(xs[i]):.1f} {zero:.1f}V{y.at(ys[i]):.1f}" stroke="{colour}"/>'
    if style in ("markers", "line_markers"):
        for i in _thinned(len(xs), _MARKS):
            if ys[i] is not None and (ys[i] > 0 or not y.is_log):
                out += f'<circle cx="{x.at(xs[i]):.1f}" cy="{y.at(ys[i]):.1f}" r="2.4" fill="{colour}"/>'
    return out


def _path(
    xs: Sequence[float],
    ys: Sequence[float | None],
    px: Callable[[float], float],
    py: Callable[[float], float],
    is_step: bool,
) -> str:
    out, is_open = "", False
    places = list(_thinned(len(xs), _POINTS))
    if places and places[-1] != len(xs) - 1:
        places.append(len(xs) - 1)
    for i in places:
        value = ys[i]
        at = math.nan if value is None else py(value)
        if math.isnan(at):
            is_open = False
            continue
        if is_open and is_step:
            out += f"H{px(xs[i]):.1f}V{at:.1f}"
        else:
            out += f"{'L' if is_open else 'M'}{px(xs[i]):.1f} {at:.1f}"
        is_open = True
    return out
