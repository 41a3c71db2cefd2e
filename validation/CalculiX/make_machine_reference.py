"""Reference for the whole elastic machine: pin forces and output angle of the RV-40E-81 of designs/tao2024.toml at rated torque.

Discs, carrier, housing and crankshafts are elastic bodies of gmsh and CalculiX (`machine_bodies`) with their full compliance.
This script assembles them with 40 pins per disc, all rollers and the gears as unilateral contacts, with the analytic laws of a
line contact, of a roller and of a pin in its groove: Newton's method for the positions of the bodies and the approaches of the
contacts. It is independent of arcmin. README.md describes the scope of the comparison.

Usage: python make_machine_reference.py [compliances] [2|3] [5.12|12.7] (Python packages gmsh, numpy, scipy, pypardiso;
program ccx). Compliances are kept in the folder MACHINE_CACHE; balances go to machine.csv here.
"""
import csv
import math
import os
import sys

import numpy as np

import machine_bodies as solids
from machine_bodies import A, CRANK_AT, FLANK, GAP, LOBES, ORDERS, PIN, PINS, RP, SPAN, WIDTH
from machine_solids import by_waves

HERE = os.path.dirname(os.path.abspath(__file__))
CACHE = os.environ.get("MACHINE_CACHE", os.path.join(HERE, "compliances"))
TORQUE = 412e3
ARCMIN = math.pi / 180 / 60
# Crank angles in degrees.
ANGLES = (10.0, 70.0, 130.0)
VARIANTS = [(cranks, rim) for cranks in (2, 3) for rim in (5.12, 12.7)]
CAST = (169000.0, 0.257)
STEEL = (219000.0, 0.3)
# Turning arm and crank support: rollers, their diameter, length, pitch diameter, contact angle, diametral clearance.
ARM = (14, 4.5, 8.0, 22.5, 0.0, 0.005)
SUPPORT = (15, 4.5, 9.0, 26.0, math.radians(12), 0.0)
# Orders of a rim's ovalisation at a roller; in arcmin they are limited to 4.
ROLLER_ORDERS = 4
# Gauss points that represent the length of a line contact.
SLICES = [(0.5 * w, x) for x, w in zip(*np.polynomial.legendre.leggauss(4))]
SUN_TEETH, PLANET_TEETH, MODULE, PRESSURE = 18, 36, 1.5, math.radians(30)
MESH_STIFFNESS, SUN_STIFFNESS = 2e5, 5e4
SPLINE = solids.spline()


def unit(angle):
    return np.array([math.cos(angle), math.sin(angle)])


def across(v):
    return np.array([-v[1], v[0]])


def rotation(angle):
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


class Roller:
    """Q = 3.73e4 l^(8/9) delta^(10/9) between both raceways (Harris)."""

    def __init__(self, bearing):
        self.count, d, self.length, pitch, angle, clearance = bearing
        self.cos, self.half = math.cos(angle), 0.5 * clearance
        self.share = 0.5 * (1 - d * self.cos / pitch)
        self.stiffness = 3.73e4 * self.length ** (8 / 9)

    def force(self, approach):
        if approach <= 0:
            return 0.0, 0.0
        q = self.stiffness * approach ** (10 / 9)
        return q, 10 / 9 * q / approach


class PinLaw:
    """Approach of flank and pin (Johnson, section 5.6), for the flank from its surface to a depth, for the whole pin; plus the
    additional compliance of a groove with clearance (Persson), while the groove's own compliance is that of the solid."""

    def __init__(self, depth=1.0, groove="secant"):
        e, nu = STEEL
        self.c = (1 - nu ** 2) / (math.pi * WIDTH * e)
        self.effective = e / (2 * (1 - nu ** 2))
        self.nu, self.depth, self.groove = nu / (1 - nu), depth, groove
        self.clearance = 0.003
        self.seat_modulus = 1 / ((1 - nu ** 2) / e + (1 - CAST[1] ** 2) / CAST[0])
        # Tabulated: beyond(q) for line loads q.
        self.table = None
        if groove != "none":
            b = np.concatenate([[0], np.geomspace(1e-6, 0.8344, 4000)])
            n = 2 - np.log1p(b) - 2 * b * b
            q = 2 * math.pi * self.seat_modulus * self.clearance * b * (1 + b) / n
            with np.errstate(divide="ignore", invalid="ignore"):
                way = (2 - 2 * b * (1 + b) * np.where(b > 0, np.log(b / (1 + b)), 0) - 2 * b + b / (1 + b)) / n - 1
            way[0] = 0.0
            beyond = self.clearance * way - 0.33587 * q / self.seat_modulus
            self.table = q, np.maximum(beyond, 0)
        if groove == "secant":
            # At the mean force of the pins under rated torque.
            mean = 4 * TORQUE / (2 * A * LOBES * PINS) * 2 / math.pi
            self.secant = np.interp(mean / (GAP / 2), *self.table) / mean

    def seat(self, force):
        if self.groove == "none":
            return 0.0, 0.0
        if self.groove == "secant":
            return self.secant * force, self.secant
        q = force / (GAP / 2)
        h = 1e-3 * max(q, 1e-3)
        low, here, high = (np.interp(v, *self.table) for v in (q - h, q, q + h))
        return here, (high - low) / (2 * h) / (GAP / 2)

    def approach(self, force, radius):
        """And its slope. b^2 = 4 F R/(pi B E*)."""
        b = math.sqrt(4 * force * radius / (math.pi * WIDTH * self.effective))
        ends = 2 * math.log(2 * self.depth / b) + 2 * math.log(4 * PIN / b) - 2 * self.nu
        seat, soft = self.seat(force)
        return self.c * force * ends + seat, self.c * (ends - 2) + soft

    def force(self, approach, radius):
        if approach <= 0:
            return 0.0, 0.0
        f = approach * 2e5
        for _ in range(100):
            here, slope = self.approach(f, radius)
            step = (approach - here) / slope
            f = max(f + step, 0.2 * f)
            if abs(step) < 1e-11 * f:
                break
        return f, 1 / self.approach(f, radius)[1]


class MainPair:
    """Two rows of balls, contact angle 40 degrees, back to back (Jones), preloaded by 5 um each; (x, y, z, about x, about y)."""

    def __init__(self):
        room, pitch = 0.12 * RP, 2.12 * RP
        d = 0.6 * room
        self.count, self.radius, self.alpha = int(0.9 * math.pi * pitch / d), pitch / 2, math.radians(40)
        self.apart, self.preload, self.height = 0.04 * d, 0.005, 0.5 * SPAN
        one = []
        for side in (1, -1):
            rolling = 0.5 * d * (1 - side * d * math.cos(self.alpha) / pitch)
            groove = 0.52 * d / 0.04
            ratio, r = groove / rolling, 1 / (1 / rolling + 1 / groove)
            kappa, second, first = 1.0339 * ratio ** 0.636, 1.0003 + 0.5968 / ratio, 1.5277 + 0.6023 * math.log(ratio)
            one.append(math.pi * kappa * 206e3 / 0.91 * math.sqrt(r * second / (4.5 * first ** 3)))
        self.k = (one[0] ** (-2 / 3) + one[1] ** (-2 / 3)) ** -1.5

    def react(self, u):
        force, tangent = np.zeros(5), np.zeros((5, 5))
        for s in (1, -1):
            h, facing = s * self.height, -s
            for psi in 2 * math.pi * np.arange(self.count) / self.count:
                c, n = math.cos(psi), math.sin(psi)
                radial = np.array([c, n, 0, -h * n, h * c])
                axial = facing * np.array([0, 0, 1, self.radius * n, -self.radius * c])
                r, a = self.apart * math.cos(self.alpha) + radial @ u, self.apart * math.sin(self.alpha) + axial @ u + self.preload
                distance = math.hypot(r, a)
                delta = distance - self.apart
                if delta > 0:
                    q = self.k * delta ** 1.5
                    along, aside = (r * radial + a * axial) / distance, (a * radial - r * axial) / distance
                    force += q * along
                    tangent += 1.5 * q / delta * np.outer(along, along) + q / distance * np.outer(aside, aside)
        return force, tangent


class Machine:
    """All bodies of a variant at a crank angle, and the static equilibrium of their positions and contacts.

    Coordinates: carrier (x, y, rotation, about x, about y, z), crankshafts (17 each, see `solids.crankshaft`), discs (x, y,
    rotation, slopes), sun (x, y), all as deviations from the nominal machine.
    """

    def __init__(self, variant, crank, compliances, law, rigid=()):
        self.variant, self.crank, self.law = variant, crank, law
        self.output = -crank / LOBES
        n = variant.cranks
        self.at_crank = [6 + 17 * k for k in range(n)]
        self.at_disc = [6 + 17 * n + 5 * j for j in range(2)]
        self.at_sun = 6 + 17 * n + 10
        self.size = self.at_sun + 2
        self.arm, self.support, self.pair = Roller(ARM), Roller(SUPPORT), MainPair()
        # Contacts and their bodies. The clearance is introduced gradually on the way to the first equilibrium.
        self.kinds = [("pin", j, i, 0) for j in range(2) for i in range(PINS)]
        self.kinds += [("arm", j, k, r) for j in range(2) for k in range(n) for r in range(ARM[0])]
        self.kinds += [("support", e, k, r) for k in range(n) for e in range(2) for r in range(SUPPORT[0])]
        # Whether the tangential displacement of the flank is included.
        self.eased, self.along = 0.0, 1.0
        self.shaft = np.zeros((self.size, self.size))
        turn = np.eye(17)
        for pair in range(8):
            turn[2 * pair:2 * pair + 2, 2 * pair:2 * pair + 2] = rotation(crank)
        for at in self.at_crank:
            self.shaft[at:at + 17, at:at + 17] = turn @ compliances["crankshaft"] @ turn.T
        self.normals = np.zeros((len(self.kinds), 2))
        # Tangential displacement of the flank at every pin, in the disc's frame, and the forces that cause it.
        self.aside, self.slips = np.zeros((2, PINS, 2)), {}
        # Contact points of the pins in the nominal machine, and the present ones.
        self.nominal, self.taus = {}, {}
        self.look(np.zeros(self.size))
        self.compliances, self.rigid = compliances, rigid

    def disc_pose(self, z, j):
        x = z[self.at_disc[j]:self.at_disc[j] + 3]
        return A * unit(self.crank + math.pi * j) + x[:2], self.output + solids.mounting(j) + x[2]

    def look(self, z):
        """Approaches s, tilts t (per mm of height), their derivatives by the coordinates, and radii of curvature at the pins."""
        count = len(self.kinds)
        s, t, radius = np.zeros(count), np.zeros(count), np.zeros(count)
        ds, dt = np.zeros((count, self.size)), np.zeros((count, self.size))
        ring = 2 * math.pi * np.arange(PINS) / PINS
        pins = RP * np.stack([np.cos(ring), np.sin(ring)], -1)
        for j in range(2):
            centre, angle = self.disc_pose(z, j)
            back = rotation(-angle)
            local = (pins - centre) @ back.T - self.aside[j]
            tau = FLANK.foot(local, self.nominal.setdefault(j, FLANK.foot(local) if not z.any() else None))
            n = FLANK.normal(tau)
            gap = ((local - FLANK.trace(tau)) * n).sum(-1)
            trace = FLANK.curvature(tau)
            at = self.at_disc[j]
            rows = slice(j * PINS, (j + 1) * PINS)
            world = n @ rotation(angle).T
            s[rows] = -gap + self.eased
            ds[rows, at], ds[rows, at + 1] = world[:, 0], world[:, 1]
            ds[rows, at + 2] = n[:, 1] * local[:, 0] - n[:, 0] * local[:, 1]
            t[rows] = world @ z[at + 3:at + 5]
            dt[rows, at + 3:at + 5] = world
            radius[rows] = 1 / (1 / PIN - trace / (1 + PIN * trace))
            self.normals[rows] = world
            self.taus[j] = tau
        carrier = z[:6]
        for c, (kind, a, k, r) in enumerate(self.kinds[2 * PINS:], 2 * PINS):
            crank, gamma = self.at_crank[k], self.variant.crank_angles[k]
            turned = self.crank + z[crank + 16]
            if kind == "arm":
                law, at = self.arm, self.at_disc[a]
                pose, angle = self.disc_pose(z, a)
                seat = CRANK_AT * unit(angle - solids.mounting(a) + gamma)
                station = crank + 4 * (2 + a)
                nominal = CRANK_AT * unit(self.output + gamma) + A * unit(self.crank + math.pi * a)
                body_turn, lean = angle - solids.mounting(a), z[at + 3:at + 5]
                bore = pose + seat
            else:
                law, at = self.support, 0
                body_turn = self.output + carrier[2]
                seat = CRANK_AT * unit(body_turn + gamma)
                h = (a - 0.5) * SPAN
                station = crank + 4 * a
                nominal = CRANK_AT * unit(self.output + gamma)
                lean = np.array([carrier[4], -carrier[3]])
                bore = carrier[:2] + seat + h * lean
            u = nominal + z[station:station + 2] - bore
            psi = law.share * turned + (1 - law.share) * body_turn + 2 * math.pi * r / law.count
            e = unit(psi)
            along, aside = u @ e, u @ across(e)
            s[c] = law.cos * (along - law.half) + self.eased
            t[c] = law.cos * (z[station + 2:station + 4] - lean) @ e
            ds[c, station:station + 2] = law.cos * e
            ds[c, at:at + 2] = -law.cos * e
            ds[c, at + 2] = law.cos * (-e @ across(seat) + (1 - law.share) * aside)
            ds[c, crank + 16] = law.cos * law.share * aside
            dt[c, station + 2:station + 4] = law.cos * e
            if kind == "arm":
                dt[c, at + 3:at + 5] = -law.cos * e
            else:
                ds[c, 4], ds[c, 3] = -law.cos * h * e[0], law.cos * h * e[1]
                dt[c, 4], dt[c, 3] = -law.cos * e[0], law.cos * e[1]
            self.normals[c] = e
        return s, t, ds, dt, radius

    def whole_compliance(self):
        """Compliance between all contacts, along their normals, at their present positions."""
        compliances, rigid = self.compliances, self.rigid
        count, n = len(self.kinds), self.variant.cranks
        whole = np.zeros((count, count))
        waves = 1 + 2 * ORDERS
        for j in range(0 if "disc" in rigid else 2):
            count_of = compliances["disc", j].shape[1]
            c, own, slips = np.split(compliances["disc", j], [count_of, count_of + 1])
            loads, turn = len(c) - n * waves, 0.0
            if n == 2:
                # Both discs are the same part: rotated by 40/39 of half a turn, the first coincides with the second.
                turn = math.pi * PINS / LOBES * j
            rows = [i for i, (kind, a, _, _) in enumerate(self.kinds) if kind in ("pin", "arm") and a == j]
            select = np.zeros((len(rows), len(c)))
            select[:PINS, :loads] = SPLINE(solids.STATIONS * solids.along_lobes(self.taus[j] - turn))
            for row, i in enumerate(rows):
                kind, _, k, _ = self.kinds[i]
                if kind == "arm":
                    e = self.normals[i]
                    angle = math.atan2(e[1], e[0]) - self.output - solids.mounting(j) - turn
                    at = loads + ((k + j) % 2 if n == 2 else k) * waves
                    select[row, at:at + waves] = by_waves(angle, ROLLER_ORDERS, ORDERS) * self.arm.cos
            between = select @ c @ select.T
            pins = np.arange(PINS)
            between[pins, pins] = select[:PINS] @ own[0]
            self.slips[j] = rows, select[:PINS, :loads] @ slips @ select.T
            whole[np.ix_(rows, rows)] += between
        rows = [i for i, (kind, _, _, _) in enumerate(self.kinds) if kind == "support"]
        if "carrier" not in rigid:
            c = compliances["carrier"]
            select = np.zeros((len(rows), len(c)))
            for row, i in enumerate(rows):
                _, end, k, _ = self.kinds[i]
                e = self.normals[i]
                at = (2 * k + end) * waves
                select[row, at:at + waves] = by_waves(math.atan2(e[1], e[0]) - self.output, ROLLER_ORDERS, ORDERS) * self.support.cos
            whole[np.ix_(rows, rows)] += select @ c @ select.T
        if "housing" not in rigid:
            select = np.zeros((2 * PINS, 4 * PINS))
            for i in range(2 * PINS):
                t = 2 * math.pi * (i % PINS) / PINS
                select[i, 2 * i], select[i, 2 * i + 1] = self.normals[i] @ unit(t), self.normals[i] @ across(unit(t))
            whole[:2 * PINS, :2 * PINS] += select @ compliances["housing"] @ select.T
        return whole

    def touch(self, d, t, radius):
        """Force and couple of every contact, and their derivatives by approach and tilt."""
        found = np.zeros((len(d), 5))
        for i, (kind, _, _, _) in enumerate(self.kinds):
            law = {"arm": self.arm, "support": self.support}.get(kind)
            length = WIDTH if law is None else law.length
            if d[i] + 0.5 * length * abs(t[i]) <= 0:
                continue
            for weight, x in SLICES:
                z = 0.5 * length * x
                f, k = self.law.force(d[i] + z * t[i], radius[i]) if law is None else law.force(d[i] + z * t[i])
                found[i] += weight * np.array([f, z * f, k, z * k, z * z * k])
        return found.T

    def residual(self, x):
        z, d = x[:self.size], x[self.size:]
        s, t, ds, dt, radius = self.look(z)
        f, m, k, kt, ktt = self.touch(d, t, radius)
        closing = d - s + self.compliance @ f
        # Residual forces on the coordinates.
        push = np.zeros(self.size)
        push[2] = -TORQUE
        stiff = self.shaft.copy()
        push -= self.shaft @ z + ds.T @ f + dt.T @ m
        order = [0, 1, 5, 3, 4]
        main, tangent = self.pair.react(z[order])
        push[order] -= main
        stiff[np.ix_(order, order)] += tangent
        sun = slice(self.at_sun, self.at_sun + 2)
        push[sun] -= SUN_STIFFNESS * z[sun]
        stiff[sun, sun] += SUN_STIFFNESS * np.eye(2)
        r2 = 0.5 * MODULE * PLANET_TEETH * math.cos(PRESSURE)
        for k_, at in enumerate(self.at_crank):
            out = unit(self.output + self.variant.crank_angles[k_])
            for side in (1, -1):
                n = side * math.cos(PRESSURE) * across(out) + math.sin(PRESSURE) * out
                row = np.zeros(self.size)
                row[sun], row[at:at + 2], row[at + 16] = n, -n, side * r2
                overlap = row @ z + self.eased
                if overlap > 0:
                    push -= MESH_STIFFNESS * overlap * row
                    stiff += MESH_STIFFNESS * np.outer(row, row)
        count = len(d)
        jacobian = np.zeros((self.size + count,) * 2)
        jacobian[:self.size, :self.size] = stiff + dt.T @ (ktt[:, None] * dt)
        jacobian[:self.size, self.size:] = ds.T * k + dt.T * kt
        jacobian[self.size:, :self.size] = -ds + self.compliance @ (kt[:, None] * dt)
        jacobian[self.size:, self.size:] = np.eye(count) + self.compliance * k
        return np.concatenate([-push, closing]), jacobian, f

    def balance(self):
        """Continuation from rigid bodies with interference to the actual machine."""
        x = np.zeros(self.size + len(self.kinds))
        scale = np.concatenate([np.full(self.size, 1e-4 / 100.0), np.ones(len(self.kinds))])
        x[self.size:] = 0.03
        self.forces = np.zeros(len(self.kinds))
        way = [(eased, 0.0) for eased in (0.03, 0.01, 0.002, 0.0)]
        way += [(0.0, share) for share in (0.1, 0.3, 0.6, 1.0)]
        for self.eased, softness in way:
            for turn in range(300):
                # Contacts move along the flank, especially in the roots, whose radius differs by 2 % from that of the pins;
                # oscillation of the load between pins is damped by shorter steps.
                mix = 0.5 if turn < 40 else 0.1
                self.look(x[:self.size])
                self.compliance = softness * self.whole_compliance()
                for j, (rows, slips) in self.slips.items():
                    n = self.normals[j * PINS:(j + 1) * PINS] @ rotation(self.disc_pose(x, j)[1])
                    way = softness * self.along * slips @ self.forces[rows]
                    self.aside[j] = (1 - mix) * self.aside[j] + mix * way[:, None] * np.stack([-n[:, 1], n[:, 0]], -1)
                r, jacobian, f = self.residual(x)
                size = np.linalg.norm(r * scale)
                if size < (3e-7 if softness == 1.0 else 1e-4):
                    break
                self.forces = f
                step = np.linalg.solve(jacobian, -r)
                share = 1.0
                while share > 1e-2:
                    if np.linalg.norm(self.residual(x + share * step)[0] * scale) < (1 - 1e-3 * share) * size:
                        break
                    share *= 0.5
                x = x + share * step
            else:
                raise SystemExit(f"no balance at {self.eased}, {softness}: {size}")
        self.left, self.last = size, x
        return x[:self.size], f


def kept(name, make):
    path = os.path.join(CACHE, f"{name}.npy")
    if not os.path.exists(path):
        os.makedirs(CACHE, exist_ok=True)
        np.save(path, make())
    return np.load(path)


def compliances(variant):
    """Compliances of all bodies, computed if they are not stored."""
    found = {"crankshaft": kept("crankshaft", lambda: solids.crankshaft()[0])}
    found["disc", 0] = kept(f"disc0_{variant.name}", lambda: solids.disc(variant, 0))
    found["disc", 1] = found["disc", 0] if variant.cranks == 2 else kept(f"disc1_{variant.name}", lambda: solids.disc(variant, 1))
    found["carrier"] = kept(f"carrier_{variant.name}", lambda: solids.carrier(variant))
    found["housing"] = kept("housing", solids.housing)
    return found


def main():
    words = sys.argv[1:]
    asked = lambda value, all_of: not set(words) & set(all_of) or str(value) in words
    path = os.path.join(HERE, "machine.csv")
    rows = {}
    if os.path.exists(path):
        with open(path, newline="") as file:
            rows = {row[0]: row for row in list(csv.reader(file))[1:]}
    for cranks, rim in VARIANTS:
        if not (asked(cranks, ("2", "3")) and asked(rim, ("5.12", "12.7"))):
            continue
        variant = solids.Variant(cranks, rim)
        found = compliances(variant)
        for degrees in () if "compliances" in words else ANGLES:
            machine = Machine(variant, math.radians(degrees), found, PinLaw())
            z, f = machine.balance()
            name = f"{variant.name}_a{degrees:.0f}"
            new = [(f"{name}_output", f"{z[2] / ARCMIN:.6f}", "arcmin")]
            new += [(f"{name}_disc{j}_pin{i}", f"{f[j * PINS + i]:.3f}", "N") for j in range(2) for i in range(PINS)]
            rows.update((row[0], row) for row in new)
            print(*new[0], "largest force", f[:2 * PINS].max(), flush=True)
            with open(path, "w", newline="") as file:
                csv.writer(file).writerows([("quantity", "value", "unit")] + list(rows.values()))


if __name__ == "__main__":
    main()
