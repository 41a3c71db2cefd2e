"""Reference values for the elastic carrier and housing: solids meshed by gmsh (OpenCASCADE), solved by CalculiX.

Both programs are independent of arcmin. The dimensions are those that arcmin assumes for the RV-40E-81 of designs/tao2024.toml.
Usage: python make_bodies_reference.py [carrier|housing] [statics|modes] (needs the Python package gmsh and the program ccx; writes bodies.csv here)
"""
import csv
import math
import os
import subprocess
import sys
import tempfile

import gmsh

# mm, t, s, N, MPa. R_p = 64, r_p = 3, a = 1.3; two discs 8.75 wide; crankshafts on the y axis at 40.5; supports 40 apart.
RP, PIN, A, WIDTH, CRANK_AT, SPAN = 64.0, 3.0, 1.3, 8.75, 40.5, 40.0
SEAT_R = 0.5 * (26 + 4.5) + 0.04 * RP
BORE_R = min(20.0, CRANK_AT - SEAT_R - 0.04 * RP)
GAP = (1.1 + 1.2) * WIDTH
PLATE = SPAN - GAP
CARRIER = ("carrier", 212000.0, 0.289, 7.86e-9)
HOUSING = ("housing", 169000.0, 0.257, 7.06e-9)
WEB, BORE, HOLE = 0.08 * RP, 13.5, 20.0
HERE = os.path.dirname(os.path.abspath(__file__))
# Six points, degree 4 on a triangle (Strang and Fix).
P, Q, WP, WQ = 0.445948490915965, 0.091576213509771, 0.223381589678011, 0.109951743655322
TRIANGLE = [(P, P, WP), (1 - 2 * P, P, WP), (P, 1 - 2 * P, WP), (Q, Q, WQ), (1 - 2 * Q, Q, WQ), (Q, 1 - 2 * Q, WQ)]


def window():
    """(inner radius, outer radius, half angle, corner radius) of the assumed window of a disc."""
    return HOLE + WEB, RP - PIN - A - WEB, math.pi / 2 - math.asin((BORE + WEB) / CRANK_AT), WEB


def pillar():
    """The same for the assumed pillar."""
    draw = A + 0.02 * RP
    inner, outer, half, _ = window()
    inner, outer = inner + draw, outer - draw
    half = min(half - math.asin(draw / inner), math.pi / 2 - math.asin((SEAT_R + 0.04 * RP) / CRANK_AT))
    return inner, outer, half, max(WEB - draw, 0.02 * RP)


def sector(middle, z, height, dimensions):
    """A rounded annular sector as a solid."""
    occ = gmsh.model.occ
    a, b, h, c = dimensions
    at = lambda r, angle: (r * math.cos(middle + angle), r * math.sin(middle + angle), z)
    point = lambda p: occ.addPoint(*p)
    far, near = math.sqrt((b - c) ** 2 - c * c), math.sqrt((a + c) ** 2 - c * c)
    outer, inner = math.asin(c / (b - c)), math.asin(c / (a + c))
    names = {}
    for s in (-1, 1):
        names[s] = [point(at(b, s * (h - outer))), point(at(far, s * h)), point(at(near, s * h)), point(at(a, s * (h - inner)))]
        names[s] += [point(at(b - c, s * (h - outer))), point(at(a + c, s * (h - inner)))]
    axis = point((0, 0, z))
    arc = occ.addCircleArc
    lines = [arc(names[-1][0], axis, names[1][0]), arc(names[1][0], names[1][4], names[1][1]), occ.addLine(names[1][1], names[1][2]),
             arc(names[1][2], names[1][5], names[1][3]), arc(names[1][3], axis, names[-1][3]), arc(names[-1][3], names[-1][5], names[-1][2]),
             occ.addLine(names[-1][2], names[-1][1]), arc(names[-1][1], names[-1][4], names[-1][0])]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    return [entity for entity in occ.extrude([(2, face)], 0, 0, height) if entity[0] == 3]


def carrier_solid():
    occ = gmsh.model.occ
    parts = []
    for z in (0, PLATE + GAP):
        plate = [(3, occ.addCylinder(0, 0, z, 0, 0, PLATE, RP))]
        bores = [(3, occ.addCylinder(0, 0, z, 0, 0, PLATE, BORE_R))]
        bores += [(3, occ.addCylinder(0, s * CRANK_AT, z, 0, 0, PLATE, SEAT_R)) for s in (1, -1)]
        parts += occ.cut(plate, bores)[0]
    pillars = sector(math.pi, PLATE, GAP, pillar()) + sector(0.0, PLATE, GAP, pillar())
    occ.fuse(parts[:1], parts[1:] + pillars)


def housing_solid():
    occ = gmsh.model.occ
    seat, body, flange = 1.12 * RP, 1.25 * RP, 1.48 * RP
    cylinder = lambda z, h, r: [(3, occ.addCylinder(0, 0, z, 0, 0, h, r))]
    whole = occ.fuse(cylinder(0, 2 * PLATE + GAP, body), cylinder(PLATE, GAP, flange))[0]
    tools = cylinder(0, PLATE, seat) + cylinder(PLATE + GAP, PLATE, seat) + cylinder(PLATE, GAP, RP)
    for i in range(40):
        t = 2 * math.pi * i / 40
        tools.append((3, occ.addCylinder(RP * math.cos(t), RP * math.sin(t), PLATE, 0, 0, GAP, PIN)))
    solid = occ.cut(whole, tools)[0]
    # Faces of the bolts, imprinted on the flange.
    marks = []
    for k in range(16):
        t = 2 * math.pi * k / 16
        marks.append((2, occ.addDisk(1.365 * RP * math.cos(t), 1.365 * RP * math.sin(t), PLATE, 0.09 * RP, 0.09 * RP)))
    occ.fragment(solid, marks)


def mesh(make, size, sizes_at):
    """Nodes {tag: (x, y, z)}, Tet10 elements, six-node triangles of the surface."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    make()
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
    if sizes_at:
        gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z, lc: min(lc, sizes_at(x, y, z)))
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    nodes = {int(t): tuple(xyz[3 * i:3 * i + 3]) for i, t in enumerate(tags)}
    _, flat = gmsh.model.mesh.getElementsByType(11)
    elements = [[int(t) for t in flat[i:i + 10]] for i in range(0, len(flat), 10)]
    for e in elements:
        # The last two mid-side nodes of a tetrahedron have the opposite order in gmsh.
        e[8], e[9] = e[9], e[8]
    _, flat = gmsh.model.mesh.getElementsByType(9)
    faces = [[int(t) for t in flat[i:i + 6]] for i in range(0, len(flat), 6)]
    gmsh.finalize()
    used = {t for e in elements for t in e}
    return {t: nodes[t] for t in used}, elements, [f for f in faces if all(t in used for t in f)]


def seat_load(nodes, faces, centre, radius, low, high, width, traction, within=None, turn=0.0):
    """Consistent nodal forces of traction(angle) = radial traction times r w, on the cylinder about a centre between two heights.

    With a turn of pi/2 the traction is tangential.
    """
    load = {}
    area = 0.0
    for f in faces:
        corners = [nodes[t] for t in f[:3]]
        if any(abs(math.hypot(x - centre[0], y - centre[1]) - radius) > 1e-4 for x, y, _ in corners):
            continue
        middle = [sum(c[i] for c in corners) / 3 for i in range(3)]
        if not low < middle[2] < high or (within and not within(middle)):
            continue
        for u, v, w in TRIANGLE:
            l = (1 - u - v, u, v)
            shape = [l[i] * (2 * l[i] - 1) for i in range(3)] + [4 * l[0] * l[1], 4 * l[1] * l[2], 4 * l[2] * l[0]]
            du = [-(4 * l[0] - 1), 4 * u - 1, 0, 4 * (l[0] - u), 4 * v, -4 * v]
            dv = [-(4 * l[0] - 1), 0, 4 * v - 1, -4 * u, 4 * u, 4 * (l[0] - v)]
            p = [sum(s * nodes[t][i] for s, t in zip(shape, f)) for i in range(3)]
            a = [sum(s * nodes[t][i] for s, t in zip(du, f)) for i in range(3)]
            b = [sum(s * nodes[t][i] for s, t in zip(dv, f)) for i in range(3)]
            n = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
            da = 0.5 * w * math.hypot(*n)
            area += da
            angle = math.atan2(p[1] - centre[1], p[0] - centre[0])
            t = traction(angle) / (radius * width)
            for s, tag in zip(shape, f):
                x, y = load.get(tag, (0.0, 0.0))
                load[tag] = (x + da * s * t * math.cos(angle + turn), y + da * s * t * math.sin(angle + turn))
    return load, area


def deck(nodes, elements, held, material):
    """`held`: nodes; or components by node."""
    name, e, nu, rho = material
    lines = ["*NODE, NSET=ALL"] + [f"{t},{x:.12g},{y:.12g},{z:.12g}" for t, (x, y, z) in nodes.items()]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=BODY")
    lines += [f"{i}," + ",".join(map(str, e)) for i, e in enumerate(elements, 1)]
    lines += ["*NSET, NSET=HELD"] + [f"{t}," for t in held]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{e},{nu}", "*DENSITY", f"{rho}", "*SOLID SECTION, ELSET=BODY, MATERIAL=M"]
    if isinstance(held, dict):
        return lines + ["*BOUNDARY"] + [f"{t},{k},{k}" for t, components in held.items() for k in components]
    return lines + ["*BOUNDARY", "HELD,1,3"]


def run(lines):
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "job.inp"), "w") as file:
            file.write("\n".join(lines) + "\n")
        done = subprocess.run(["ccx", "-i", "job"], cwd=folder, capture_output=True, text=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
        path = os.path.join(folder, "job.dat")
        if not os.path.exists(path):
            raise SystemExit(done.stdout[-3000:])
        return open(path).read()


def frequencies(dat):
    rows, on = [], False
    for line in dat.splitlines():
        if "E I G E N V A L U E" in line:
            on = True
        elif "P A R T I C I P A T I O N" in line:
            on = False
        parts = line.split()
        if on and len(parts) >= 4 and parts[0].isdigit():
            rows.append(float(parts[3]))
    return rows


def solve(name, nodes, elements, held, material, loads, under):
    """Rows (name of the quantity, value, unit): displacements of all loads' coordinates under some of them, and frequencies."""
    rows = []
    read = sorted({t for load in loads.values() for t in load})
    for case in under:
        lines = deck(nodes, elements, held, material) + ["*NSET, NSET=READ"] + [f"{t}," for t in read]
        lines += ["*STEP", "*STATIC", "*CLOAD"]
        for t, (x, y) in loads[case].items():
            lines += [f"{t},1,{1000 * x:.12g}", f"{t},2,{1000 * y:.12g}"]
        table = {}
        for line in run(lines + ["*NODE PRINT, NSET=READ", "U", "*END STEP"]).splitlines():
            parts = line.split()
            if len(parts) == 4 and parts[0].isdigit():
                table[int(parts[0])] = (float(parts[1]), float(parts[2]))
        for other, load in loads.items():
            value = sum(x * table[t][0] + y * table[t][1] for t, (x, y) in load.items())
            rows.append((f"{name}_{case}_{other}", f"{value * 1e-6:.8e}", "m/N"))
            print(*rows[-1], flush=True)
    return rows


def quarter(make):
    """The part of a solid with x > 0 and y > 0."""
    def cut():
        make()
        box = [(3, gmsh.model.occ.addBox(0, 0, -1, 200, 200, 200))]
        gmsh.model.occ.intersect([solid for solid in gmsh.model.occ.getEntities(3) if solid != box[0]], box)
    return cut


def modes(name, make, size, sizes_at, edges, held_at, material, classes):
    """Rows of the ten lowest frequencies, each extrapolated from two meshes.

    Both solids are symmetric about x = 0 and y = 0: a quarter with the boundary conditions of each class of symmetry (S: no
    displacement normal to the plane, A: normal displacement only; y = 0 first) has all modes. At the edge of a clamp and at
    reentrant edges displacements are proportional to about the square root of the distance, so that the error of frequencies is
    of first order in the element size there; the difference between the two meshes is therefore applied once more.
    """
    found = {}
    for edge in edges:
        nodes, elements, _ = mesh(quarter(make), size, sizes_at(edge))
        held = {t for t, p in nodes.items() if held_at(p)}
        planes = [[t for t, p in nodes.items() if abs(p[axis]) < 1e-6 and t not in held] for axis in (1, 0)]
        print(name, "edges", edge, "elements", len(elements), flush=True)
        for kind in classes:
            lines = deck(nodes, elements, held, material)
            for name_of_plane, axis, plane, sign in zip(("Y0", "X0"), (2, 1), planes, kind):
                lines += [f"*NSET, NSET={name_of_plane}"] + [f"{t}," for t in plane] + ["*BOUNDARY"]
                lines += [f"{name_of_plane},{k},{k}" for k in (1, 2, 3) if (k == axis) == (sign == "S")]
            lines += ["*STEP", "*FREQUENCY", "7", "*NODE PRINT, NSET=HELD, TOTALS=ONLY", "RF", "*END STEP"]
            found[kind, edge] = frequencies(run(lines))[:7]
            print(kind, *found[kind, edge], flush=True)
    # If x and y are equivalent (housing), the classes SA and AS have the same frequencies.
    both = [(kind, fine, coarse) for kind in classes for coarse, fine in zip(found[kind, edges[0]], found[kind, edges[1]])
            for _ in range(2 if kind == "SA" and "AS" not in classes else 1)]
    rows = []
    for k, (kind, fine, coarse) in enumerate(sorted(both, key=lambda mode: 2 * mode[1] - mode[2])[:10]):
        rows.append((f"{name}_frequency_{k + 1}", f"{2 * fine - coarse:.2f}", "Hz"))
        rows.append((f"{name}_frequency_{k + 1}_on_the_finer_mesh", f"{fine:.2f}", "Hz"))
        print(*rows[-2], kind, flush=True)
    return rows


def cosine(order, start):
    return lambda angle: math.cos(order * (angle - start)) / math.pi


def carrier_sizes(edge):
    """Elements of twice a given edge length at the junctions of pillars and plates."""
    inner, outer, half, _ = pillar()

    def at(x, y, z):
        r, angle = math.hypot(x, y), abs(math.atan2(y, abs(x)))
        radial, across = max(inner - r, r - outer), (angle - half) * r
        inside = max(radial, across)
        away = -inside if inside < 0 else math.hypot(max(radial, 0), max(across, 0))
        return min(4.0, *(2 * edge + 0.4 * math.hypot(away, z - face) for face in (PLATE, PLATE + GAP)))
    return at


def carrier_under_loads(edge):
    nodes, elements, faces = mesh(carrier_solid, 4.0, carrier_sizes(edge))
    print("carrier, edges", edge, "elements", len(elements), flush=True)
    end = 2 * PLATE + GAP
    held = [t for t, p in nodes.items() if abs(p[2] - end) < 1e-6]
    loads = {}
    for k, s in enumerate((1, -1)):
        for e, low in enumerate((0.0, PLATE + GAP)):
            for name, order, start in [("x", 1, 0.0), ("y", 1, math.pi / 2), ("cos2", 2, 0.0), ("sin2", 2, math.pi / 4)]:
                if order > 1 and (k, e) != (0, 0):
                    continue
                load, area = seat_load(nodes, faces, (0.0, s * CRANK_AT), SEAT_R, low, low + PLATE, PLATE, cosine(order, start))
                assert abs(area / (2 * math.pi * SEAT_R * PLATE) - 1) < 1e-2, area
                loads[f"seat{k}{e}{name}"] = load
    rows = [("carrier_elements", len(elements), "")]
    return rows + solve("carrier", nodes, elements, held, CARRIER, loads, ["seat00x", "seat00y", "seat01x", "seat00cos2"])


def carrier_modes():
    at_end = lambda p: abs(p[2] - 2 * PLATE - GAP) < 1e-6
    return modes("carrier", carrier_solid, 4.0, carrier_sizes, (1.6, 0.8), at_end, CARRIER, ("SS", "SA", "AS", "AA"))


def bolts():
    return [(1.365 * RP * math.cos(2 * math.pi * k / 16), 1.365 * RP * math.sin(2 * math.pi * k / 16)) for k in range(16)]


def on_bolt(p):
    return abs(p[2] - PLATE) < 1e-6 and any(math.dist(p[:2], b) < 0.09 * RP + 1e-4 for b in bolts())


def housing_sizes(edge, size):
    """Elements of a given edge length at the edges of the bolts' faces, four times as large at the reentrant edges of the ring."""
    def at(x, y, z):
        r, step = math.hypot(x, y), 2 * math.pi / 16
        bolt = step * round(math.atan2(y, x) / step)
        rim = math.hypot(x - 1.365 * RP * math.cos(bolt), y - 1.365 * RP * math.sin(bolt)) - 0.09 * RP
        grooves = 2.5 if PLATE - 0.5 < z < PLATE + GAP + 0.5 and r < RP + PIN + 0.5 else size
        sharp = min(math.hypot(r - edge_at, z - face) for edge_at in (1.12 * RP, 1.25 * RP) for face in (PLATE, PLATE + GAP))
        return min(grooves, edge + 0.8 * math.hypot(rim, z - PLATE), 4 * edge + 0.8 * sharp)
    return at


def statics(under_loads):
    """Displacements on two meshes, extrapolated in the same way as frequencies."""
    coarse, fine = (under_loads(edge) for edge in (0.8, 0.4))
    rows = [fine[0]]
    for (name, value, unit), (_, finer, _) in zip(coarse[1:], fine[1:]):
        rows.append((name, f"{2 * float(finer) - float(value):.8e}", unit))
        rows.append((f"{name}_on_the_finer_mesh", finer, unit))
    return rows


def housing_under_loads(edge):
    """Grooves and seats of the whole housing from a quarter, as the sum over the classes of symmetry.

    The part of a load L in a class is L_c, the mean of its four images with the signs of the class. On the quarter it is half
    of L if L is symmetric to one of the two planes (pins 0 and 20 lie on y = 0), a quarter of it if all images are different
    (pin 3), and L if it is symmetric to both (the seats). L(u) is four times the displacement of L_c on the quarter, summed
    over classes.
    """
    nodes, elements, faces = mesh(quarter(housing_solid), 5.0, housing_sizes(edge, 5.0))
    print("housing, edges", edge, "elements", len(elements), flush=True)
    clamped = {t for t, p in nodes.items() if on_bolt(p)}
    reach = math.pi / 2 + math.asin(0.5 * PIN / RP)
    grooves = {}
    for pin, share_in_quarter in ((0, 0.5), (3, 1.0)):
        t = 2 * math.pi * pin / 40
        centre = (RP * math.cos(t), RP * math.sin(t))
        for name, start, share in [("r", t, reach + 0.5 * math.sin(2 * reach)), ("t", t + math.pi / 2, reach - 0.5 * math.sin(2 * reach))]:
            load, area = seat_load(nodes, faces, centre, PIN, PLATE, PLATE + GAP, GAP, lambda a, s=start, n=share: math.cos(a - s) / n)
            assert abs(area / (2 * reach * PIN * GAP) / share_in_quarter - 1) < 1e-2, area
            grooves[f"pin{pin}{name}"] = load
    seats = [seat_load(nodes, faces, (0.0, 0.0), 1.12 * RP, low, low + PLATE, PLATE, cosine(1, 0.0))[0] for low in (0.0, PLATE + GAP)]
    times = lambda share, load: {t: (share * x, share * y) for t, (x, y) in load.items()}
    # Radial loads on pins on the plane y = 0 have no part in classes that are odd with respect to it.
    sums = {f"housing_pin0r_{odd}": 0.0 for odd in ("pin0t", "pin20t")}
    for kind in ("SS", "SA", "AS", "AA"):
        mirrored = 1 if kind[1] == "S" else -1
        loads = {name: times(0.25, grooves[name]) for name in ("pin3r", "pin3t")}
        if kind[0] == "S":
            loads |= {"pin0r": times(0.5, grooves["pin0r"]), "pin20r": times(0.5 * mirrored, grooves["pin0r"])}
        else:
            loads |= {"pin0t": times(0.5, grooves["pin0t"]), "pin20t": times(-0.5 * mirrored, grooves["pin0t"])}
        if kind == "SA":
            loads |= {f"seat{e}x": seat for e, seat in enumerate(seats)}
        held = {t: {1, 2, 3} for t in clamped}
        for axis, sign in ((1, kind[0]), (0, kind[1])):
            fixed = {axis + 1} if sign == "S" else {1, 2, 3} - {axis + 1}
            for t, p in nodes.items():
                if abs(p[axis]) < 1e-6:
                    held[t] = held.get(t, set()) | fixed
        for name, value, _ in solve("housing", nodes, elements, held, HOUSING, loads, [under for under in ("pin0r", "pin3t") if under in loads]):
            sums[name] = sums.get(name, 0.0) + 4 * float(value)
    return [("housing_elements", len(elements), "")] + [(name, f"{value:.8e}", "m/N") for name, value in sums.items()]


def housing_modes():
    return modes("housing", housing_solid, 5.0, lambda edge: housing_sizes(edge, 5.0), (0.8, 0.4), on_bolt, HOUSING, ("SS", "SA", "AA"))


def main():
    path = os.path.join(HERE, "bodies.csv")
    rows = []
    if os.path.exists(path):
        with open(path, newline="") as file:
            rows = list(csv.reader(file))[1:]
    parts = [("carrier", "statics", lambda: carrier_under_loads(1.6)), ("carrier", "modes", carrier_modes),
             ("housing", "statics", lambda: statics(housing_under_loads)), ("housing", "modes", housing_modes)]
    for name, what, make in parts:
        if not {name, what} >= set(sys.argv[1:]):
            continue
        of_part = lambda row: row[0].startswith(name) and ("_frequency_" in row[0]) == (what == "modes")
        rows = [row for row in rows if not of_part(row)] + make()
        with open(path, "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["quantity", "value", "unit"])
            writer.writerows(rows)


if __name__ == "__main__":
    main()
