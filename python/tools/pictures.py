"""Draws figures of the book from output of the command: ``python python/tools/pictures.py [NAME …]``.

Needs the ``arcmin`` command (of the package, or on the PATH) and matplotlib. To be run when the content of
the figures has changed; the numbers are those of the present version.
"""

from __future__ import annotations

import csv
import math
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  the backend comes first

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "docs" / "src" / "images"
DESIGN = ROOT / "designs" / "rv-40e-81.toml"
BLUE, ORANGE, GREY = "#0072b2", "#d55e00", "#777777"


def arcmin(*words: object) -> None:
    subprocess.run(["arcmin", *map(str, words)], check=True, stdout=subprocess.DEVNULL)


def columns(path: Path, keep: Callable[[dict[str, str]], bool], *names: str) -> list[list[float]]:
    with path.open() as file:
        rows = [row for row in csv.DictReader(file) if keep(row)]
    return [[float(row[name]) for row in rows] for name in names]


def save(name: str) -> None:
    plt.tight_layout()
    plt.savefig(IMAGES / f"{name}.svg", metadata={"Date": None})
    plt.close()


def joint_loop(work: Path) -> None:
    arcmin("export", "joint", DESIGN, "--hours", "0,6000", "--out", work)
    plt.figure(figsize=(7, 4.5))
    for hours, colour, words in [("0", BLUE, "new"), ("6000", ORANGE, "after 6000 h")]:
        torque, measured, model = columns(
            work / "joint.wind_up.csv",
            lambda row, hours=hours: row["hours"] == hours,
            "torque_n_m",
            "wind_up_arcmin",
            "wind_up_model_arcmin",
        )
        plt.plot(measured, torque, color=colour, label=f"{words}, measured on the bench")
        plt.plot(model, torque, color=colour, linestyle="none", marker=".", markersize=4, label=f"{words}, model")
    plt.xlabel("wind-up of the output in ′")
    plt.ylabel("torque at the output in N·m")
    plt.legend(frameon=False)
    plt.grid(alpha=0.3)
    save("joint-loop")


def log_of_a_robot(path: Path) -> tuple[list[float], list[float]]:
    """Pick, swing, place, swing back, in 4 s: speed in rpm and torque in N·m at the output."""

    def swing(t: float) -> float:
        return max(0.0, min(1.0, t / 0.3, (1.6 - t) / 0.3))

    def speed(t: float) -> float:
        t %= 4.0
        return 15.0 * (swing(t) - swing(t - 2.0))

    speeds, torques = [], []
    with path.open("w") as file:
        file.write("time_s,torque_n_m,output_speed_rpm\n")
        for index in range(20_000):
            t = 0.01 * index
            acceleration = (speed(t + 0.005) - speed(t - 0.005)) / 0.01
            held = (180.0 if t % 4.0 < 1.8 else 90.0) * math.cos(0.4 * math.sin(0.5 * math.pi * t))
            torque = held + 4.0 * acceleration + 8.0 * math.sin(37.0 * t)
            speeds.append(speed(t))
            torques.append(torque)
            file.write(f"{t:.2f},{torque:.3f},{speeds[-1]:.4f}\n")
    return speeds, torques


def exchange_duty(work: Path) -> None:
    speeds, torques = log_of_a_robot(work / "log.csv")
    arcmin("import", "duty", DESIGN, work / "log.csv", "--rows", 12, "--out", work)
    rows = tomllib.loads((work / "duty.toml").read_text())["duty"]
    plt.figure(figsize=(7, 4.5))
    readings = list(zip(speeds, torques, strict=True))[::17]
    moving = [(n, t) for n, t in readings if abs(n) > 0.015]
    plt.scatter(*zip(*moving, strict=True), s=3, color=GREY, alpha=0.3, linewidths=0, label="log, in motion")
    plt.scatter(
        [row["input_speed_rpm"] / 81.0 for row in rows],
        [row["torque_n_m"] for row in rows],
        s=[1500.0 * row["share"] for row in rows],
        facecolors="none",
        edgecolors=ORANGE,
        linewidths=1.5,
        label=f"{len(rows)} rows of duty, area as their share",
    )
    plt.xlabel("speed of the output in rpm")
    plt.ylabel("torque at the output in N·m")
    legend = plt.legend(frameon=False)
    for handle in legend.legend_handles:
        handle.set_sizes([30])
    plt.grid(alpha=0.3)
    save("exchange-duty")


def exchange_like(work: Path) -> None:
    sheet = {"ratio": 105, "torque-nm": 167, "outer-diameter-mm": 145}
    stiffness, lost_motion = 49.0, 0.8
    words = [word for key, value in sheet.items() for word in (f"--{key}", value)]
    machine = work / "rv-20e.toml"
    calibrated = ["--stiffness-nm-per-arcmin", stiffness, "--lost-motion-arcmin", lost_motion]
    arcmin("new", "--like", "rv-40e", *words, *calibrated, machine)
    arcmin("export", "joint", machine, "--hours", "0", "--out", work)
    torque, measured = columns(
        work / "joint.wind_up.csv", lambda row: True, "torque_n_m", "wind_up_arcmin"
    )
    plt.figure(figsize=(7, 4.5))
    plt.plot(measured, torque, color=BLUE, label="model on the bench")
    rated = float(sheet["torque-nm"])
    # Both branches meet the sheet's line at full load.
    for sign in (1.0, -1.0):
        from_share = 0.5
        ends = [from_share * rated * sign, rated * sign]
        top = max(measured) if sign > 0 else min(measured)
        line = [top - sign * (rated - abs(end)) / stiffness for end in ends]
        label = f"{stiffness:.0f} N·m/′ of the data sheet" if sign > 0 else None
        plt.plot(line, ends, color=ORANGE, linestyle="--", linewidth=2.5, label=label)
    plt.axhspan(-0.03 * rated, 0.03 * rated, color=GREY, alpha=0.2, label="±3 %: lost motion is read here")
    plt.xlabel("wind-up of the output in ′")
    plt.ylabel("torque at the output in N·m")
    plt.legend(frameon=False)
    plt.grid(alpha=0.3)
    save("exchange-like")


PICTURES = {"joint-loop": joint_loop, "exchange-duty": exchange_duty, "exchange-like": exchange_like}


def main() -> None:
    plt.rcParams["svg.hashsalt"] = "arcmin"
    for name in sys.argv[1:] or PICTURES:
        with tempfile.TemporaryDirectory() as work:
            PICTURES[name](Path(work))


if __name__ == "__main__":
    main()
