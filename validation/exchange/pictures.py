"""Draws the figures of the book's pages on exchange with other programs.

Usage: pictures.py ARCMIN DESIGN OUT. Runs the exports and imports for the design, with a flank and a log generated from
known deviations and loads, and writes SVG files into OUT.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "arcmin"
import matplotlib.pyplot as plt


def table(path):
    rows = [row for row in path.read_text().splitlines() if not row.startswith("#")]
    return np.genfromtxt(rows, delimiter=",", names=True, dtype=None, encoding="utf-8")


def save(figure, path):
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def joint(run, out):
    place = run("export", "joint", "--hours", "0,6000", "--te-positions", "64")
    rows = table(place / "joint.wind_up.csv")
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for hours, colour in zip(sorted(set(rows["hours"])), ("tab:blue", "tab:red")):
        of = rows[rows["hours"] == hours]
        axes.plot(of["wind_up_arcmin"], of["torque_n_m"], ".", color=colour, ms=4, label=f"bench, {hours:g} h")
        axes.plot(of["wind_up_model_arcmin"], of["torque_n_m"], color=colour, lw=1, label=f"model, {hours:g} h")
    axes.set_xlabel("wind-up of the output in ′")
    axes.set_ylabel("torque in N·m")
    axes.legend()
    axes.grid(alpha=0.3)
    save(figure, out / "joint-loop.svg")


def profile(run, out):
    place = run("export", "profile", "--format", "csv", "--tolerance-um", "20")
    rows = table(place / "profile.csv")
    figure, (whole, lobe) = plt.subplots(1, 2, figsize=(8, 4), layout="constrained")
    x, y = np.append(rows["x_mm"], rows["x_mm"][0]), np.append(rows["y_mm"], rows["y_mm"][0])
    whole.plot(x, y, lw=0.8)
    lobe.plot(x, y, ".-", lw=0.8, ms=5)
    lobe.set_xlim(58.5, 63.5)
    lobe.set_ylim(-2, 12)
    for axes, title in ((whole, "disc"), (lobe, "corners at a tolerance of 20 µm")):
        axes.set_aspect("equal")
        axes.set_title(title)
        axes.set_xlabel("x in mm")
    save(figure, out / "exchange-profile.svg")
    return rows


def flank(run, out, rows, where):
    """The exported flank with known deviations, displaced, with noise."""
    rng = np.random.default_rng(7)
    angle = np.arctan2(rows["y_mm"], rows["x_mm"])
    depth = 4 * np.cos(angle - 0.4) + 1.5 * np.cos(7 * angle) + 0.3 * rng.standard_normal(len(angle))
    x = rows["x_mm"] - 1e-3 * depth * rows["outward_normal_x"]
    y = rows["y_mm"] - 1e-3 * depth * rows["outward_normal_y"]
    turn = 0.002
    points = np.column_stack([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)])
    file = where / "points.csv"
    np.savetxt(file, points, delimiter=",", header="x_mm,y_mm", comments="", fmt="%.6f")
    place = run("import", "flank", str(file), "--centred")
    found = table(place / "measured-flank.csv")
    figure, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
    order = np.argsort(angle % (2 * np.pi))
    axes.plot(np.degrees(angle % (2 * np.pi))[order], depth[order], ".", ms=2, label="put on, with noise of 0.3 µm")
    names = found.dtype.names
    axes.plot(found[names[0]], found[names[1]], lw=1, label="found")
    axes.set_xlabel("angle around the disc in °")
    axes.set_ylabel("depth in µm")
    axes.legend()
    save(figure, out / "exchange-flank.svg")


def duty(run, out, where):
    t = np.arange(0, 120, 2e-3)
    speed = 12 * np.sin(2 * np.pi * t / 6) * np.clip(2 * np.abs(np.sin(2 * np.pi * t / 24)), 0, 1)
    torque = 180 * np.cos(2 * np.pi * t / 6) + 90 * np.sin(2 * np.pi * t / 13)
    file = where / "log.csv"
    np.savetxt(
        file,
        np.column_stack([t, torque, speed]),
        delimiter=",",
        header="time_s,torque_n_m,output_speed_rpm",
        comments="",
        fmt="%.5f",
    )
    place = run("import", "duty", str(file), "--rows", "24")
    text = (place / "duty.toml").read_text()
    numbers = lambda key: np.array([float(v) for v in re.findall(rf"^{key} = ([-0-9.e+]+)", text, re.M)])
    torques, speeds, shares = numbers("torque_n_m"), numbers("input_speed_rpm"), numbers("share")
    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    axes.plot(speed[::100], torque[::100], ".", ms=1.5, alpha=0.3, label="readings")
    axes.scatter(speeds / 81, torques, s=20 + 1500 * shares, facecolor="none", edgecolor="tab:red", label="rows, area ∝ share")
    axes.set_xlabel("speed of the output in rpm")
    axes.set_ylabel("torque in N·m")
    axes.legend()
    save(figure, out / "exchange-duty.svg")


def main():
    arcmin, design, out = sys.argv[1], sys.argv[2], Path(sys.argv[3])
    with tempfile.TemporaryDirectory() as directory:
        where = Path(directory)

        def run(kind, what, *options):
            place = where / what
            files = [o for o in options[:1] if o.endswith(".csv")]
            more = options[len(files) :]
            command = [arcmin, kind, what, design, *files, *more, "--out", str(place)]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            return place

        rows = profile(run, out)
        flank(run, out, rows, where)
        duty(run, out, where)
        joint(run, out)


if __name__ == "__main__":
    main()
