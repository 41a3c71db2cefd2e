"""Compliances of disc, carrier, housing and crankshaft of a machine, computed with `machine_solids`."""
import math

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.sparse import csc_matrix, lil_matrix

import make_bodies_reference as bodies
from machine_solids import Body, Outline, edge_load, on_cylinder, sheet, tetrahedra, waves

RP, PIN, A, WIDTH, CRANK_AT, SPAN = bodies.RP, bodies.PIN, bodies.A, bodies.WIDTH, bodies.CRANK_AT, bodies.SPAN
GAP, PLATE, WEB, BORE, HOLE, SEAT_R = bodies.GAP, bodies.PLATE, bodies.WEB, bodies.BORE, bodies.HOLE, bodies.SEAT_R
PINS, LOBES = 40, 39
STEEL = ("steel", 219000.0, 0.3, 7.83e-9)
SHAFT_R, ARM_LENGTH, SUPPORT_LENGTH = 9.0, 8.0, 9.0
# Harmonics of a rim in the compliance; the number used for a roller is chosen where the machine is assembled.
ORDERS = 8
# Number of unit loads on a lobe.
STATIONS = 24
FLANK = Outline(PINS, RP, A, PIN)


class Variant:
    """Number of crankshafts, and distance (mm) between windows and root circle."""

    def __init__(self, cranks, rim):
        self.cranks, self.rim = cranks, rim
        self.name = f"c{cranks}_r{rim:.1f}"
        self.crank_angles = [math.pi / 2 + 2 * math.pi * k / cranks for k in range(cranks)]
        pitch = math.pi / cranks
        half = pitch - math.asin((BORE + WEB) / CRANK_AT)
        self.window = (HOLE + WEB, RP - PIN - A - rim, half, WEB)
        draw = A + 0.02 * RP
        inner, outer = self.window[0] + draw, self.window[1] - draw
        side = min(half - math.asin(draw / inner), pitch - math.asin((SEAT_R + 0.04 * RP) / CRANK_AT))
        self.pillar = (inner, outer, side, max(WEB - draw, 0.02 * RP))
        self.middles = [angle + pitch for angle in self.crank_angles]


def mounting(disc):
    return -math.pi * disc / LOBES


def stations():
    """Flank parameters at equal distances, STATIONS on every lobe, the first at a root."""
    dense = np.linspace(0, 2 * math.pi / LOBES, 20001)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(FLANK.point(dense), axis=0), axis=1))])
    lobe = np.interp(np.arange(STATIONS) * way[-1] / STATIONS, way, dense)
    return np.concatenate([lobe + 2 * math.pi * k / LOBES for k in range(LOBES)]), (dense, way / way[-1])


def spline():
    """Weights of all stations as a function of the position in units of stations: periodic cubic spline along the flank."""
    unit = np.eye(STATIONS * LOBES)
    return CubicSpline(np.arange(len(unit) + 1), np.vstack([unit, unit[:1]]), bc_type="periodic")


def along_lobes(taus):
    """Positions on the flank in units of lobes, by arc length."""
    dense, way = stations()[1]
    lobe, rest = np.divmod(np.asarray(taus) % (2 * math.pi), 2 * math.pi / LOBES)
    return lobe + np.interp(rest, dense, way)


def disc(variant, number, sizes=(0.3, 0.7, 2.5), depth=1.0):
    """Compliance between the loads of a disc: unit forces inwards at all stations, then the harmonics of every bore's rim; then
    a row with the displacement of every station under its own force, evaluated at a depth; then the tangential displacements
    of all stations (90 degrees from the outward normal).

    Loads are distributed over half a millimetre to either side, as cos^2.
    """
    turn = -mounting(number)
    bores = [(CRANK_AT * math.cos(a + turn), CRANK_AT * math.sin(a + turn), BORE) for a in variant.crank_angles]
    windows = [(a + turn, variant.window) for a in variant.middles]
    taus = stations()[0]
    inside = FLANK.point(taus) - depth * FLANK.normal(taus)
    nodes, elements, flank, rims = sheet(FLANK, bores, HOLE, windows, sizes, inside)
    body = Body(nodes, elements, "CPE6", three_points(nodes), STEEL, WIDTH)
    print("disc", variant.name, number, "elements", len(elements), flush=True)
    loads = lil_matrix((3 * len(body.tags), len(taus) + len(bores) * (1 + 2 * ORDERS)))
    aside = lil_matrix((3 * len(body.tags), len(taus)))
    middle = body.places[[body.index[e[2]] for e in flank], :2]
    for k, tau in enumerate(taus):
        at, normal = FLANK.point(tau), FLANK.normal(tau)

        edges = [flank[i] for i in np.flatnonzero(np.linalg.norm(middle - at, axis=1) < 1.5)]
        for into, way in ((loads, -normal), (aside, np.array([-normal[1], normal[0]]))):
            def spread(places, at=at, way=way):
                x = np.linalg.norm(places - at, axis=-1)
                return way * np.where(x < 0.5, np.cos(math.pi * np.minimum(x, 0.5)) ** 2, 0.0)[:, None]
            load = edge_load(body, edges, spread)
            touched = np.flatnonzero(load)
            into[touched, k] = load[touched] / np.hypot(load[0::3].sum(), load[1::3].sum())
    at = len(taus)
    for (x, y, r), rim in zip(bores, rims):
        for wave in waves(ORDERS, 1 / r):
            def pressure(places, x=x, y=y, wave=wave):
                angle = np.arctan2(places[:, 1] - y, places[:, 0] - x)
                return wave(angle, 0.0)[0][:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)
            load = edge_load(body, rim, pressure)
            touched = np.flatnonzero(load)
            loads[touched, at] = load[touched]
            at += 1
    places = {tuple(np.round(p[:2], 6)): i for i, p in enumerate(body.places)}
    nodes = [places[tuple(np.round(place, 6))] for place in inside]
    rows, along, columns, slips, own = csc_matrix(loads), csc_matrix(aside), [], [], []
    for first in range(0, rows.shape[1], 150):
        ways = body.solve(rows[:, first:first + 150].toarray())
        columns.append(rows.T @ ways)
        slips.append(along.T @ ways)
        own += [-FLANK.normal(taus[k]) @ ways[3 * nodes[k]:3 * nodes[k] + 2, k - first] for k in range(first, min(first + 150, len(taus)))]
    compliance = np.hstack(columns)
    body.done()
    return np.vstack([0.5 * (compliance + compliance.T), np.pad(own, (0, len(compliance) - len(own))), np.hstack(slips)])


def three_points(nodes):
    """Constraints of the rigid motions in the plane only, at the centre hole, far from the stations."""
    near = lambda x, y: min(nodes, key=lambda t: math.dist(nodes[t], (x, y, 0.0)))
    return {near(HOLE, 0.0): (2,), near(-HOLE, 0.0): (2,), near(0.0, HOLE): (1,)}


def carrier(variant, edge=3.2):
    """Compliance between the harmonics of all crank seats relative to the output face; for every crankshaft input end first."""
    def make():
        occ = bodies.gmsh.model.occ
        parts = []
        for z in (0, PLATE + GAP):
            plate = [(3, occ.addCylinder(0, 0, z, 0, 0, PLATE, RP))]
            bores = [(3, occ.addCylinder(0, 0, z, 0, 0, PLATE, bodies.BORE_R))]
            bores += [(3, occ.addCylinder(CRANK_AT * math.cos(a), CRANK_AT * math.sin(a), z, 0, 0, PLATE, SEAT_R)) for a in variant.crank_angles]
            parts += occ.cut(plate, bores)[0]
        pillars = [solid for middle in variant.middles for solid in bodies.sector(middle, PLATE, GAP, variant.pillar)]
        occ.fuse(parts[:1], parts[1:] + pillars)

    def sizes_at(x, y, z):
        inner, outer, half, _ = variant.pillar
        r, angle = math.hypot(x, y), math.atan2(y, x)
        away = min(abs((angle - m + math.pi) % (2 * math.pi) - math.pi) for m in variant.middles)
        radial, across = max(inner - r, r - outer), (away - half) * r
        inside = max(radial, across)
        off = -inside if inside < 0 else math.hypot(max(radial, 0), max(across, 0))
        return min(6.0, *(2 * edge + 0.5 * math.hypot(off, z - face) for face in (PLATE, PLATE + GAP)))
    nodes, elements, faces = tetrahedra(make, 6.0, sizes_at)
    print("carrier", variant.name, "elements", len(elements), flush=True)
    end = 2 * PLATE + GAP
    held = {t: (1, 2, 3) for t, p in nodes.items() if abs(p[2] - end) < 1e-6}
    body = Body(nodes, elements, "C3D10", held, bodies.CARRIER)
    loads = []
    for a in variant.crank_angles:
        for low in (0.0, PLATE + GAP):
            centre = (CRANK_AT * math.cos(a), CRANK_AT * math.sin(a))
            found, area = on_cylinder(body, faces, centre, SEAT_R, low, low + PLATE, waves(ORDERS, 1 / (SEAT_R * PLATE)))
            assert abs(area / (2 * math.pi * SEAT_R * PLATE) - 1) < 1e-2, area
            loads.append(found)
    loads = np.concatenate(loads, axis=1)
    compliance = loads.T @ body.solve(loads)
    body.done()
    return compliance


def housing(edge=1.6, size=6.0):
    """Compliance between grooves: disc by disc, pin by pin, radial (outwards) and tangential.

    From a quarter model as the sum over the classes of symmetry: the part of a load L in a class is L_c = (1/4) sum over the
    four reflections of their sign times the reflected L, and C = 4 sum L_c' K_c^-1 L_c with the quarter's K_c.
    """
    nodes, elements, faces = tetrahedra(bodies.quarter(bodies.housing_solid), size, bodies.housing_sizes(edge, size))
    print("housing elements", len(elements), flush=True)
    clamped = {t for t, p in nodes.items() if bodies.on_bolt(p)}
    reach = math.pi / 2 + math.asin(0.5 * PIN / RP)
    shares = reach + 0.5 * math.sin(2 * reach), reach - 0.5 * math.sin(2 * reach)
    own, total = None, 0.0
    for kind in ("SS", "SA", "AS", "AA"):
        held = {t: {1, 2, 3} for t in clamped}
        for axis, sign in ((1, kind[0]), (0, kind[1])):
            fixed = {axis + 1} if sign == "S" else {1, 2, 3} - {axis + 1}
            for t, p in nodes.items():
                if abs(p[axis]) < 1e-6:
                    held[t] = held.get(t, set()) | fixed
        body = Body(nodes, elements, "C3D10", held, bodies.HOUSING)
        if own is None:
            own = {}
            for number in range(2):
                low = PLATE + number * GAP / 2
                for pin in range(PINS // 4 + 1):
                    t = 2 * math.pi * pin / PINS
                    centre, on_plane = (RP * math.cos(t), RP * math.sin(t)), pin in (0, PINS // 4)
                    within = lambda z: (z > low) & (z < low + GAP / 2)
                    tractions = [lambda a, z, s=s, n=n: (within(z) / n * np.cos(a - s), 0.0 * a) for s, n in zip((t, t + math.pi / 2), shares)]
                    found, _ = on_cylinder(body, faces, centre, PIN, PLATE, PLATE + GAP, tractions)
                    for across in range(2):
                        # A unit force, half of it if the model contains half a groove.
                        f, to = found[:, across].reshape(-1, 3), t + across * math.pi / 2
                        found[:, across] *= (0.5 if on_plane else 1.0) / (f[:, 0] * math.cos(to) + f[:, 1] * math.sin(to)).sum()
                        own[number, pin, across] = found[:, across]
            columns = {key: i for i, key in enumerate(own)}
            basis = np.array(list(own.values())).T
        ways = body.solve(basis)
        quarter = basis.T @ ways
        body.done()
        # Reflections: none, y -> -y, x -> -x, both; signs of the class.
        sign = {"S": 1.0, "A": -1.0}
        about_y, about_x = sign[kind[0]], sign[kind[1]]
        images = [(lambda i: i, 1.0, 1.0), (lambda i: -i, about_y, -1.0), (lambda i: PINS // 2 - i, about_x, -1.0),
                  (lambda i: PINS // 2 + i, about_y * about_x, 1.0)]
        part = np.zeros((2 * PINS * 2, len(columns)))
        for number in range(2):
            for pin in range(PINS):
                for across in range(2):
                    for image, character, turned in images:
                        key = (number, image(pin) % PINS, across)
                        if key in columns:
                            part[2 * (number * PINS + pin) + across, columns[key]] += 0.25 * character * (turned if across else 1.0)
        total = total + 4 * part @ quarter @ part.T
    return total


def crankshaft(size=2.5):
    """Stiffness of the crankshaft, with the eccentric of the first disc at angle 0: x, y and both slopes at its supports and at
    its discs, then the rotation at the first support. Rigid motions have no energy.
    """
    places = [0.0, SPAN] + [0.5 * SPAN + s * 0.55 * WIDTH for s in (-1, 1)]

    def make():
        occ = bodies.gmsh.model.occ
        parts = [(3, occ.addCylinder(0, 0, -0.5 * SUPPORT_LENGTH, 0, 0, SPAN + SUPPORT_LENGTH, SHAFT_R))]
        for number, z in enumerate(places[2:]):
            parts.append((3, occ.addCylinder(A * math.cos(math.pi * number), 0, z - WIDTH / 2, 0, 0, WIDTH, SHAFT_R)))
        # The diameter of the shaft equals that of its eccentrics, which replace it at their positions.
        blocks = [(3, occ.addCylinder(0, 0, z - WIDTH / 2, 0, 0, WIDTH, 2 * SHAFT_R)) for z in places[2:]]
        shaft = occ.cut(parts[:1], blocks)[0]
        occ.fuse(shaft[:1], shaft[1:] + parts[1:])
    nodes, elements, faces = tetrahedra(make, size, None, 24)
    print("crankshaft elements", len(elements), flush=True)
    near = lambda x, y, z: min(nodes, key=lambda t: math.dist(nodes[t], (x, y, z)))
    end = SPAN + 0.5 * SUPPORT_LENGTH
    held = {near(SHAFT_R, 0.0, end): (1, 2, 3), near(-SHAFT_R, 0.0, end): (2, 3), near(0.0, SHAFT_R, end): (3,)}
    body = Body(nodes, elements, "C3D10", held, STEEL)
    loads = []
    for station, z0 in enumerate(places):
        length = SUPPORT_LENGTH if station < 2 else ARM_LENGTH
        centre = (0.0, 0.0) if station < 2 else (A * math.cos(math.pi * (station - 2)), 0.0)
        inside = lambda z, z0=z0, length=length: np.abs(z - z0) < 0.5 * length
        scale = 1 / (math.pi * SHAFT_R)
        tractions = []
        for start in (0.0, math.pi / 2):
            tractions.append(lambda a, z, s=start: (scale * np.cos(a - s) * inside(z), 0.0 * a))
        for start in (0.0, math.pi / 2):
            tractions.append(lambda a, z, s=start: (scale * np.cos(a - s) * (z - z0) * inside(z), 0.0 * a))
        if station == 0:
            tractions.append(lambda a, z: (0.0 * a, inside(z) / SHAFT_R))
        low, high = (z0 - 0.5 * SUPPORT_LENGTH, z0 + 0.5 * SUPPORT_LENGTH) if station < 2 else (z0 - 0.5 * WIDTH, z0 + 0.5 * WIDTH)
        found, _ = on_cylinder(body, faces, centre, SHAFT_R, low, high, tractions)
        # Unit forces without moments and unit couples without forces, to the last digit: otherwise rigid motions would have
        # energy, as with springs to the ground.
        height = body.places[:, 2] - z0

        def resultants(loads):
            x, y = loads[0::3], loads[1::3]
            return np.stack([x.sum(0), y.sum(0), height @ x, height @ y])
        found[:, :4] = found[:, :4] @ np.linalg.inv(resultants(found[:, :4]))
        if station == 0:
            turn = found[:, 4:] - found[:, :4] @ resultants(found[:, 4:])
            f = turn[:, 0].reshape(-1, 3)
            turn = turn / (body.places[:, 0] * f[:, 1] - body.places[:, 1] * f[:, 0]).sum()
        loads.append(found[:, :4])
    loads = np.concatenate(loads + [turn], axis=1)
    compliance = loads.T @ body.solve(loads)
    x, y, z = body.places.T
    rigid = np.zeros((3 * len(x), 5))
    rigid[0::3, 0], rigid[1::3, 1], rigid[0::3, 2], rigid[1::3, 3] = 1, 1, z, z
    rigid[2::3, 2], rigid[2::3, 3] = -x, -y
    rigid[0::3, 4], rigid[1::3, 4] = -y, x
    body.done()
    moved = loads.T @ rigid
    free = np.linalg.svd(moved.T)[2][5:].T
    return free @ np.linalg.inv(free.T @ compliance @ free) @ free.T, moved
