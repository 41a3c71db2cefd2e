"""Reference values for the finite element disc: geometry meshed by gmsh, solved by CalculiX.

Both programs are independent of arcmin: gmsh has its own quadratic mesh of the analytic flank, CalculiX its own elements and eigensolver.
Usage: python make_reference.py [windowed]   (needs the Python package gmsh and the program ccx; writes reference.csv and windowed.csv here)
"""
import csv
import math
import os
import subprocess
import sys
import tempfile

import gmsh

# RV-40E-81 of Tao2024, bores and centre hole assumed as in designs/tao2024.toml. mm, t, s, N, MPa.
ZP, RP, A, R_PIN, WIDTH = 40, 64.0, 1.3, 3.0, 8.75
# CalculiX expands its plane stress elements to solid wedges of the given width. The change of thickness under a load, which varies freely in plane stress,
# then causes shear in the wedge and stiffens it (tooth load, 8.75 mm: 0.9 %; free frequencies 0.7 %). With a hundredth of the width this effect vanishes.
SHEET = 0.01 * WIDTH
BORE_R, BORE_AT, HOLE_R = 13.5, 40.5, 20.0
E, NU, RHO = 219000.0, 0.3, 7.83e-9
# Loaded flank positions: (name, meshing angle in degrees, lobe). τ = (2π lobe − φ)/z_c.
LOADS = [("lobe0", -60.0, 0), ("over_bore", -60.0, 10), ("other_flank", 100.0, 20)]
DEPTH = 1.0
# A tooth load has the density cos²(π s / 2 PATCH) over |s| < PATCH of arc length, in the direction of the normal in the middle. The displacement under a
# point load would depend on the mesh.
PATCH = 0.5


def flank(tau):
    x = RP * math.cos(tau) - A * math.cos(ZP * tau)
    y = RP * math.sin(tau) - A * math.sin(ZP * tau)
    dx = -RP * math.sin(tau) + A * ZP * math.sin(ZP * tau)
    dy = RP * math.cos(tau) - A * ZP * math.cos(ZP * tau)
    n = math.hypot(dx, dy)
    inward = (-dy / n, dx / n)
    return (x + R_PIN * inward[0], y + R_PIN * inward[1]), inward


def tau_of(phi_deg, lobe):
    return (2 * math.pi * lobe - math.radians(phi_deg)) / (ZP - 1)


def arc(tau, start):
    """Arc length of the flank from start to tau, by Gauss's rule on the analytic curve."""
    total, pieces = 0.0, 16
    for i in range(pieces):
        for x, w in ((-0.7745966692414834, 5 / 9), (0.0, 8 / 9), (0.7745966692414834, 5 / 9)):
            t = start + (tau - start) * (i + 0.5 + 0.5 * x) / pieces
            h = 1e-6
            (x1, y1), _ = flank(t - h)
            (x2, y2), _ = flank(t + h)
            total += 0.5 * w * math.hypot(x2 - x1, y2 - y1) / (2 * h) * (tau - start) / pieces
    return total


def nearest(point, guess):
    """Parameter of the flank point nearest to a point of the mesh."""
    low, high = guess - 0.02, guess + 0.02
    distance = lambda t: math.dist(flank(t)[0], point)
    for _ in range(80):
        c, d = high - 0.6180339887 * (high - low), low + 0.6180339887 * (high - low)
        if distance(c) < distance(d):
            high = d
        else:
            low = c
    return 0.5 * (low + high)


def distance_from_flank(point):
    """Distance of a point near the flank; its parameter is within 0.06 of its polar angle."""
    angle = math.atan2(point[1], point[0])
    return min(math.dist(flank(nearest(point, angle + 0.015 * k))[0], point) for k in range(-3, 4))


def patch(edges, nodes, tau):
    """Consistent nodal weights of the load around tau; edges as (first, last, middle) node."""
    shares = {}
    for a, b, m in edges:
        if math.dist(nodes[m][:2], flank(tau)[0]) > 3 * PATCH:
            continue
        places = [arc(nearest(nodes[n][:2], tau), tau) for n in (a, b, m)]
        for x, w in GAUSS_8:
            x = 0.5 * (x + 1)
            shape = ((1 - x) * (1 - 2 * x), x * (2 * x - 1), 4 * x * (1 - x))
            rate = (4 * x - 3, 4 * x - 1, 4 - 8 * x)
            s = sum(n * p for n, p in zip(shape, places)) / PATCH
            if abs(s) >= 1:
                continue
            length = math.hypot(*(sum(r * nodes[n][i] for r, n in zip(rate, (a, b, m))) for i in (0, 1)))
            for n, value in zip((a, b, m), shape):
                shares[n] = shares.get(n, 0.0) + 0.5 * w * length * value * math.cos(0.5 * math.pi * s) ** 2
    total = sum(shares.values())
    return {n: value / total for n, value in shares.items()}


GAUSS_8 = [(s * x, w) for x, w in ((0.1834346424956498, 0.3626837833783620), (0.5255324099163290, 0.3137066458778873),
                                   (0.7966664774136267, 0.2223810344533745), (0.9602898564975363, 0.1012285362903763)) for s in (-1, 1)]


def window(g, middle, size):
    """A rounded annular sector as a curve loop: 0.08 R_p of metal to the centre hole, the bores and the root circle, corners of the same radius."""
    c = 0.08 * RP
    a, b, h = HOLE_R + c, RP - R_PIN - A - c, math.pi / 2 - math.asin((BORE_R + c) / BORE_AT)
    point = lambda r, angle: g.addPoint(r * math.cos(middle + angle), r * math.sin(middle + angle), 0, size)
    far, near = math.sqrt((b - c) ** 2 - c * c), math.sqrt((a + c) ** 2 - c * c)
    outer, inner = math.asin(c / (b - c)), math.asin(c / (a + c))
    axis = g.addPoint(0, 0, 0)
    # On either side: end of the outer arc, ends of the straight side, end of the inner arc, middles of the corners.
    low, high = ([point(b, s * (h - outer)), point(far, s * h), point(near, s * h), point(a, s * (h - inner)),
                  point(b - c, s * (h - outer)), point(a + c, s * (h - inner))] for s in (-1, 1))
    arc_between = g.addCircleArc
    return g.addCurveLoop([
        arc_between(low[0], axis, high[0]), arc_between(high[0], high[4], high[1]), g.addLine(high[1], high[2]), arc_between(high[2], high[5], high[3]),
        arc_between(high[3], axis, low[3]), arc_between(low[3], low[5], low[2]), g.addLine(low[2], low[1]), arc_between(low[1], low[4], low[0])])


def mesh(size_flank, size_inner, layers, size_load, windows=()):
    """Quadratic mesh; returns nodes {tag: (x, y, z)}, elements [tags], tags of bore nodes, load patches and reading nodes."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    g = gmsh.model.geo
    # The flank as interpolating splines through the analytic curve, 320 points per lobe, divided at every load point and at roots. The splines of gmsh's
    # own kernel deviate from the curve between their points by 0.1 mm with 40 points per lobe, by 4 µm with 320.
    cuts = sorted({2 * math.pi * k / (ZP - 1) for k in range(ZP - 1)} | {tau_of(p, l) % (2 * math.pi) for _, p, l in LOADS})
    points = {}
    corner = []
    for t in cuts:
        (x, y), _ = flank(t)
        loaded = any(abs(t - tau_of(p, l) % (2 * math.pi)) < 1e-12 for _, p, l in LOADS)
        corner.append(g.addPoint(x, y, 0, size_load if loaded else size_flank))
        points[round(t, 12)] = corner[-1]
    curves = []
    for i, t in enumerate(cuts):
        end = cuts[i + 1] if i + 1 < len(cuts) else cuts[0] + 2 * math.pi
        inner = []
        count = max(8, int(320 * (end - t) / (2 * math.pi / (ZP - 1))))
        for k in range(1, count):
            (x, y), _ = flank(t + (end - t) * k / count)
            inner.append(g.addPoint(x, y, 0, size_flank))
        curves.append(g.addSpline([corner[i], *inner, corner[(i + 1) % len(cuts)]]))
    loops = [g.addCurveLoop(curves)]
    bore_curves = []
    for cx, cy, r, bore in [(0, BORE_AT, BORE_R, True), (0, -BORE_AT, BORE_R, True), (0, 0, HOLE_R, False)]:
        centre = g.addPoint(cx, cy, 0)
        rim = [g.addPoint(cx + r * math.cos(a), cy + r * math.sin(a), 0, size_inner) for a in (0, math.pi / 2, math.pi, 3 * math.pi / 2)]
        arcs = [g.addCircleArc(rim[k], centre, rim[(k + 1) % 4]) for k in range(4)]
        loops.append(g.addCurveLoop(arcs))
        if bore:
            bore_curves += arcs
    surface = g.addPlaneSurface(loops + [window(g, middle, size_inner) for middle in windows])
    reading = []
    for _, p, l in LOADS:
        (x, y), n = flank(tau_of(p, l))
        reading.append(g.addPoint(x + DEPTH * n[0], y + DEPTH * n[1], 0, size_load))
    g.synchronize()
    if layers == 0:
        gmsh.model.mesh.embed(0, reading, 2, surface)
        dim, faces = 2, bore_curves
    else:
        out = g.extrude([(2, surface)], 0, 0, 0.5 * WIDTH, [layers])
        g.synchronize()
        dim = 3
        # Side faces of the extrusion in the order of the loops' curves.
        sides = [tag for d, tag in out if d == 2][1:]
        faces = sides[len(curves):len(curves) + 8]
    gmsh.model.mesh.generate(dim)
    gmsh.model.mesh.setOrder(2)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    nodes = {int(t): tuple(xyz[3 * i:3 * i + 3]) for i, t in enumerate(tags)}
    kind, per = (9, 6) if dim == 2 else (11, 10)
    _, flat = gmsh.model.mesh.getElementsByType(kind)
    elements = [[int(t) for t in flat[i:i + per]] for i in range(0, len(flat), per)]
    if dim == 3:
        # The last two mid-side nodes of a tetrahedron have the opposite order in gmsh.
        for e in elements:
            e[8], e[9] = e[9], e[8]
    edges = []
    for curve in curves if dim == 2 else []:
        _, flat = gmsh.model.mesh.getElementsByType(8, curve)
        edges += [tuple(int(t) for t in flat[i:i + 3]) for i in range(0, len(flat), 3)]
    off = max((distance_from_flank(nodes[n][:2]) for e in edges for n in e), default=0.0)
    if off > 0.005:
        raise SystemExit(f"the mesh leaves the analytic flank by {off:.4f} mm")
    bore = set()
    for f in faces:
        got, _, _ = gmsh.model.mesh.getNodes(dim - 1, f, includeBoundary=True)
        bore.update(int(t) for t in got)
    near = lambda p: min(nodes, key=lambda t: math.dist(nodes[t], (*p, 0.0)))
    load_nodes = [(near(flank(tau_of(p, l))[0]), patch(edges, nodes, tau_of(p, l))) for _, p, l in LOADS] if dim == 2 else []
    read_nodes = [near(tuple(gmsh.model.getValue(0, q, []))[:2]) for q in reading] if dim == 2 else []
    gmsh.finalize()
    used = {t for e in elements for t in e}
    return {t: nodes[t] for t in used}, elements, sorted(bore & used), load_nodes, read_nodes


def deck(nodes, elements, bore, kind):
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{t},{x:.12g},{y:.12g},{z:.12g}" for t, (x, y, z) in nodes.items()]
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=DISC")
    for i, e in enumerate(elements, 1):
        lines.append(f"{i}," + ",".join(map(str, e)))
    lines.append("*NSET, NSET=BORE")
    lines += [f"{t}," for t in bore]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{E},{NU}", "*DENSITY", f"{RHO}"]
    lines.append("*SOLID SECTION, ELSET=DISC, MATERIAL=STEEL")
    if kind == "CPS6":
        lines.append(f"{SHEET}")
    return lines


def run(lines):
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "job.inp"), "w") as file:
            file.write("\n".join(lines) + "\n")
        done = subprocess.run(["ccx", "-i", "job"], cwd=folder, capture_output=True, text=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
        path = os.path.join(folder, "job.dat")
        if not os.path.exists(path):
            raise SystemExit(done.stdout[-3000:])
        return open(path).read(), done.stdout


def frequencies(dat):
    rows = []
    on = False
    for line in dat.splitlines():
        if "E I G E N V A L U E" in line:
            on = True
        elif "P A R T I C I P A T I O N" in line:
            on = False
        parts = line.split()
        if on and len(parts) >= 4 and parts[0].isdigit():
            rows.append(float(parts[3]))
    return rows


def modal(nodes, elements, bore, kind, held, count):
    lines = deck(nodes, elements, bore, kind)
    if held:
        lines += ["*BOUNDARY", "BORE,1,2"]
    if kind == "C3D10":
        # Half the width; in-plane motions are symmetric about the middle plane.
        lines += ["*NSET, NSET=MIDDLE"] + [f"{t}," for t, p in nodes.items() if abs(p[2]) < 1e-6] + ["*BOUNDARY", "MIDDLE,3,3"]
    lines += ["*STEP", "*FREQUENCY", f"{count}", "*NODE PRINT, NSET=BORE, TOTALS=ONLY", "RF", "*END STEP"]
    return frequencies(run(lines)[0])


def static(nodes, elements, bore, load_nodes, read_nodes, case):
    _, phi, lobe = LOADS[case]
    _, inward = flank(tau_of(phi, lobe))
    lines = deck(nodes, elements, bore, "CPS6")
    lines += ["*NSET, NSET=READ"] + [f"{t}," for t in read_nodes + [node for node, _ in load_nodes]]
    lines += ["*BOUNDARY", "BORE,1,2", "*STEP", "*STATIC", "*CLOAD"]
    for node, share in load_nodes[case][1].items():
        lines += [f"{node},1,{1000 * share * inward[0]:.12g}", f"{node},2,{1000 * share * inward[1]:.12g}"]
    lines += ["*NODE PRINT, NSET=READ", "U", "*END STEP"]
    table = {}
    for line in run(lines)[0].splitlines():
        parts = line.split()
        if len(parts) == 4 and parts[0].isdigit():
            table[int(parts[0])] = (float(parts[1]), float(parts[2]))
    normal = lambda node, other: sum(a * b for a, b in zip(table[node], flank(tau_of(*LOADS[other][1:]))[1]))
    own = normal(read_nodes[case], case)
    cross = [(LOADS[o][0], normal(load_nodes[o][0], o)) for o in range(len(LOADS)) if o != case]
    return own, cross


def write(rows, name="reference.csv"):
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), name), "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["quantity", "value", "unit"])
        writer.writerows(rows)


def windowed():
    """The disc with windows for the pillars of the carrier, in plane stress."""
    plane = mesh(0.5, 1.6, 0, 0.1, (0.0, math.pi))
    rows = [("plane_elements", len(plane[1]), "")]
    for k, f in enumerate(modal(*plane[:3], "CPS6", False, 13)[3:13]):
        rows.append((f"plane_free_{k + 1}", f"{f:.4f}", "Hz"))
    for k, f in enumerate(modal(*plane[:3], "CPS6", True, 10)):
        rows.append((f"plane_clamped_{k + 1}", f"{f:.4f}", "Hz"))
    for case, (name, _, _) in enumerate(LOADS):
        own, cross = static(*plane, case)
        rows.append((f"plane_own_{name}", f"{own * 1e-6 * SHEET / WIDTH:.8e}", "m/N"))
        rows += [(f"plane_cross_{name}_{other}", f"{value * 1e-6 * SHEET / WIDTH:.8e}", "m/N") for other, value in cross]
    write(rows, "windowed.csv")


def main():
    if sys.argv[1:] == ["windowed"]:
        return windowed()
    rows = []
    version = subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout.strip().split()[-1]
    rows.append(("ccx_version", version, ""))
    plane = mesh(0.5, 1.6, 0, 0.1)
    rows.append(("plane_elements", len(plane[1]), ""))
    for k, f in enumerate(modal(*plane[:3], "CPS6", False, 11)[3:11]):
        rows.append((f"plane_free_{k + 1}", f"{f:.4f}", "Hz"))
    for k, f in enumerate(modal(*plane[:3], "CPS6", True, 8)):
        rows.append((f"plane_clamped_{k + 1}", f"{f:.4f}", "Hz"))
    for case, (name, _, _) in enumerate(LOADS):
        own, cross = static(*plane, case)
        rows.append((f"plane_own_{name}", f"{own * 1e-6 * SHEET / WIDTH:.8e}", "m/N"))
        for other, value in cross:
            rows.append((f"plane_cross_{name}_{other}", f"{value * 1e-6 * SHEET / WIDTH:.8e}", "m/N"))
    write(rows)
    solid = mesh(1.2, 3.0, 1, 1.2)
    rows.append(("solid_elements", len(solid[1]), ""))
    for k, f in enumerate(modal(*solid[:3], "C3D10", False, 11)[3:11]):
        rows.append((f"solid_free_{k + 1}", f"{f:.4f}", "Hz"))
    for k, f in enumerate(modal(*solid[:3], "C3D10", True, 8)):
        rows.append((f"solid_clamped_{k + 1}", f"{f:.4f}", "Hz"))
    write(rows)
    for row in rows:
        print(*row)
    windowed()


if __name__ == "__main__":
    main()
