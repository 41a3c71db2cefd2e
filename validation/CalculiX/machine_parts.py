"""Reference values of two single parts of the machine: the disc with held means of its rims, and the crankshaft.

Usage: python machine_parts.py (packages and folder of compliances as for make_machine_reference.py). Writes disc_rims.csv
and crankshaft.csv here.
"""
import csv
import math
import os

import numpy as np

import machine_bodies as solids
from machine_bodies import A, CRANK_AT, FLANK, ORDERS, SPAN, WIDTH
from make_machine_reference import HERE, kept

# Indices of x, y, expansion, then cosine and sine of the orders from 2 on, among the harmonics of a rim.
WAYS = {"x": 1, "y": 2, "expansion": 0, "cos2": 3, "sin2": 4, "cos3": 5, "sin3": 6, "cos4": 7, "sin4": 8}
# Positions on the flank: lobes (the second over a bore) and stations on them.
PLACES = [(0, 7), (10, 7), (20, 17)]


def disc_rims(variant):
    """Compliance of the disc with all means b of the rims held, K u = f + F b_force, b = 0, from that of the disc held at three
    points."""
    found = kept(f"disc0_{variant.name}", lambda: solids.disc(variant, 0))
    count = found.shape[1]
    c, own = found[:count], found[count]
    taus, waves = solids.stations()[0], 1 + 2 * ORDERS
    flank = len(taus)
    held = [flank + waves * k + wave for k in range(variant.cranks) for wave in WAYS.values()]
    names = [f"bore{k}_{way}" for k in range(variant.cranks) for way in WAYS]
    rigid = np.zeros((count, 3))
    for i, tau in enumerate(taus):
        (x, y), (nx, ny) = FLANK.point(tau), FLANK.normal(tau)
        rigid[i] = -nx, -ny, y * nx - x * ny
    for k, angle in enumerate(variant.crank_angles):
        at = flank + waves * k
        rigid[at + 1], rigid[at + 2] = (1, 0, -CRANK_AT * math.sin(angle)), (0, 1, CRANK_AT * math.cos(angle))
    n, unit = len(held), 1e-6
    small = np.zeros((n + 3, n + 3))
    small[:n, :n], small[:n, n:], small[n:, :n] = c[np.ix_(held, held)] / unit, rigid[held], rigid[held].T
    inverse = np.linalg.inv(small)

    def way(i, wanted):
        found = inverse @ wanted
        return c[i, held] @ found[:n] / unit + rigid[i] @ found[n:]
    places = [lobe * solids.STATIONS + station for lobe, station in PLACES]
    rows = [(f"place{i}_tau", f"{taus[p]:.9f}", "rad") for i, p in enumerate(places)]
    for i, p in enumerate(places):
        for j, q in enumerate(places[i:], i):
            under = way(p, -np.concatenate([c[held, q], unit * rigid[q]]))
            rows.append((f"held_place{i}_place{j}", f"{((own[p] if i == j else c[p, q]) + under) * 1e-3:.6e}", "m/N"))
    stiffness = inverse[:n, :n] / unit
    for i in range(n):
        for j in range(i, n):
            rows.append((f"stiffness_{names[i]}_{names[j]}", f"{0.5e3 * (stiffness[i, j] + stiffness[j, i]):.5e}", "N/m"))
    for i, p in enumerate(places):
        rows += [(f"flank_place{i}_{name}", f"{way(p, np.eye(n + 3)[k]):.6f}", "1") for k, name in enumerate(names)]
    return rows


def crankshaft():
    """Compliance between deviations from the straight line through the supports, along and perpendicular to the eccentricity."""
    stiffness = kept("crankshaft", lambda: solids.crankshaft()[0])
    names = ["disc0", "disc1", "slope_support0", "slope_support1", "slope_disc0", "slope_disc1"]
    heights = [0.5 * SPAN + s * 0.55 * WIDTH for s in (-1, 1)]
    flexible, rows = np.linalg.pinv(stiffness, rcond=1e-9), []
    for axis, word in enumerate(("along", "across")):
        loads = np.zeros((17, 6))
        for k in range(6):
            # Supports, then discs; displacements, then slopes.
            first, second = (z / SPAN if k < 2 else 1 / SPAN for z in (SPAN - heights[k % 2], heights[k % 2]))
            loads[axis, k], loads[4 + axis, k] = (-first, -second) if k < 2 else (first, -second)
            loads[8 + 4 * k + axis if k < 2 else 4 * (k - 2) + 2 + axis, k] = 1
            if axis == 1 and k < 2:
                # The torque of a force on an eccentric is held at the planet.
                loads[16, k] = -A * math.cos(math.pi * k)
        found = loads.T @ flexible @ loads
        for i in range(6):
            for j in range(6):
                unit, scale = (("m/N", 1e-3), ("1/N", 1.0), ("1/(N m)", 1e3))[(i > 1) + (j > 1)]
                rows.append((f"{word}_{names[i]}_{names[j]}", f"{0.5 * scale * (found[i, j] + found[j, i]):.5e}", unit))
    return rows


def main():
    for name, rows in (("disc_rims", disc_rims(solids.Variant(2, 5.12))), ("crankshaft", crankshaft())):
        with open(os.path.join(HERE, f"{name}.csv"), "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(("quantity", "value", "unit"))
            writer.writerows(rows)


if __name__ == "__main__":
    main()
