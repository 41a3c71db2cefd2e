"""Solids of the whole machine as elastic bodies: meshed by gmsh, their stiffness matrices assembled by CalculiX.

CalculiX writes the matrix of a body without solving it (*FREQUENCY, SOLVER=MATRIXSTORAGE); MKL's Pardiso (Python package
pypardiso) factorises it once for some hundred unit loads. The result is a compliance between loads, C = L' K^-1 L.
mm, N, MPa.
"""
import math
import os
import subprocess
import tempfile

import gmsh
import numpy as np
import pypardiso
import scipy.sparse as sparse

import make_bodies_reference as bodies

# Three Gauss points on an edge with three nodes.
EDGE = [(0.5 - 0.5 * math.sqrt(0.6), 5 / 18), (0.5, 8 / 18), (0.5 + 0.5 * math.sqrt(0.6), 5 / 18)]


class Body:
    """Nodes, and the factorised stiffness matrix assembled by CalculiX."""

    def __init__(self, nodes, elements, kind, held, material, width=None):
        """`held`: {node: directions}. Plane stress is computed as plane strain of a material with the same in-plane compliance."""
        self.tags = sorted(nodes)
        self.index = {t: i for i, t in enumerate(self.tags)}
        self.places = np.array([nodes[t] for t in self.tags])
        _, e, nu, rho = material
        if width is not None:
            e, nu = e * (1 + 2 * nu) / (1 + nu) ** 2, nu / (1 + nu)
        lines = ["*NODE, NSET=ALL"] + [f"{t},{x:.12g},{y:.12g},{z:.12g}" for t, (x, y, z) in nodes.items()]
        lines.append(f"*ELEMENT, TYPE={kind}, ELSET=BODY")
        lines += [f"{i}," + ",".join(map(str, e)) for i, e in enumerate(elements, 1)]
        lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{e:.12g},{nu:.12g}", "*DENSITY", f"{rho}", "*SOLID SECTION, ELSET=BODY, MATERIAL=M"]
        lines += [] if width is None else [f"{width}"]
        lines += ["*BOUNDARY"] + [f"{t},{k},{k}" for t, ks in held.items() for k in ks]
        lines += ["*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "1", "*END STEP"]
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "job.inp"), "w") as file:
                file.write("\n".join(lines) + "\n")
            done = subprocess.run(["ccx", "-i", "job"], cwd=folder, capture_output=True, text=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
            path = os.path.join(folder, "job.sti")
            if not os.path.exists(path):
                raise SystemExit(done.stdout[-3000:])
            entries = np.fromfile(path, sep=" ").reshape(-1, 3)
            numbers = np.array([[int(part) for part in line.split(".")] for line in open(os.path.join(folder, "job.dof"))])
        i, j = (entries[:, k].astype(np.int64) - 1 for k in (0, 1))
        count = len(numbers)
        upper = sparse.csr_matrix((entries[:, 2], (np.minimum(i, j), np.maximum(i, j))), shape=(count, count))
        place = np.array([self.index[t] for t in numbers[:, 0]])
        self.unknowns = 3 * place + numbers[:, 1] - 1
        self.matrix = upper
        self.solver = pypardiso.PyPardisoSolver(mtype=2)
        self.solver.factorize(upper)

    def solve(self, loads):
        """Displacements of all nodes, column by column."""
        whole = np.zeros_like(loads)
        whole[self.unknowns] = self.solver.solve(self.matrix, np.asfortranarray(loads[self.unknowns]))
        return whole

    def done(self):
        self.solver.free_memory(everything=True)

    def column(self):
        return np.zeros(3 * len(self.tags))


def on_cylinder(body, faces, centre, radius, low, high, tractions, within=None):
    """Consistent loads of tractions, each a function of angle and height on a cylinder: radial and tangential part.

    Returns the loads as columns and the area of the faces.
    """
    faces = np.array([[body.index[t] for t in f] for f in faces])
    p = body.places[faces]
    corners = p[:, :3]
    off = np.abs(np.hypot(corners[:, :, 0] - centre[0], corners[:, :, 1] - centre[1]) - radius).max(axis=1)
    middle = corners.mean(axis=1)
    chosen = (off < 1e-4) & (middle[:, 2] > low) & (middle[:, 2] < high)
    if within is not None:
        chosen &= within(middle)
    faces, p = faces[chosen], p[chosen]
    loads = np.zeros((3 * len(body.tags), len(tractions)))
    area = 0.0
    for u, v, w in bodies.TRIANGLE:
        l = (1 - u - v, u, v)
        shape = np.array([l[i] * (2 * l[i] - 1) for i in range(3)] + [4 * l[0] * l[1], 4 * l[1] * l[2], 4 * l[2] * l[0]])
        du = np.array([-(4 * l[0] - 1), 4 * u - 1, 0, 4 * (l[0] - u), 4 * v, -4 * v])
        dv = np.array([-(4 * l[0] - 1), 0, 4 * v - 1, -4 * u, 4 * u, 4 * (l[0] - v)])
        at = np.einsum("n,fnc->fc", shape, p)
        da = 0.5 * w * np.linalg.norm(np.cross(np.einsum("n,fnc->fc", du, p), np.einsum("n,fnc->fc", dv, p)), axis=1)
        area += da.sum()
        angle = np.arctan2(at[:, 1] - centre[1], at[:, 0] - centre[0])
        for k, traction in enumerate(tractions):
            radial, tangential = traction(angle, at[:, 2])
            x = (radial * np.cos(angle) - tangential * np.sin(angle)) * da
            y = (radial * np.sin(angle) + tangential * np.cos(angle)) * da
            for n in range(6):
                np.add.at(loads[:, k], 3 * faces[:, n], shape[n] * x)
                np.add.at(loads[:, k], 3 * faces[:, n] + 1, shape[n] * y)
    return loads, area


def waves(orders, scale):
    """Radial tractions 1/2, cos n a, sin n a for n from 1 to `orders`, times scale/pi."""
    def of(n, sine):
        return lambda a, z: (scale / math.pi * (0.5 * np.ones_like(a) if n == 0 else np.sin(n * a) if sine else np.cos(n * a)), 0.0 * a)
    return [of(0, False)] + [of(n, sine) for n in range(1, orders + 1) for sine in (False, True)]


def by_waves(angle, orders, all_orders):
    """A roller's force at an angle in terms of `waves`, up to an order."""
    row = np.zeros(1 + 2 * all_orders)
    row[0] = 1.0
    for n in range(1, orders + 1):
        row[2 * n - 1:2 * n + 1] = math.cos(n * angle), math.sin(n * angle)
    return row


def tetrahedra(make, size, sizes_at=None, per_circle=12):
    """As `bodies.mesh`, with a number of elements on a circle."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    make()
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", per_circle)
    if sizes_at:
        gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z, lc: min(lc, sizes_at(x, y, z)))
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    nodes = {int(t): tuple(xyz[3 * i:3 * i + 3]) for i, t in enumerate(tags)}
    numbers, flat = gmsh.model.mesh.getElementsByType(11)
    # Elements inverted by a curved edge get straight edges.
    for i in np.flatnonzero(gmsh.model.mesh.getElementQualities(numbers, "minSJ") < 0.1):
        e = [int(t) for t in flat[10 * i:10 * i + 10]]
        for middle, (a, b) in zip(e[4:], ((0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1))):
            nodes[middle] = tuple(0.5 * (p + q) for p, q in zip(nodes[e[a]], nodes[e[b]]))
    elements = [[int(t) for t in flat[i:i + 10]] for i in range(0, len(flat), 10)]
    for e in elements:
        # The last two mid-side nodes of a tetrahedron have the opposite order in gmsh.
        e[8], e[9] = e[9], e[8]
    _, flat = gmsh.model.mesh.getElementsByType(9)
    faces = [[int(t) for t in flat[i:i + 6]] for i in range(0, len(flat), 6)]
    gmsh.finalize()
    used = {t for e in elements for t in e}
    return {t: nodes[t] for t in used}, elements, [f for f in faces if all(t in used for t in f)]


class Outline:
    """The flank generated by the pins, in the disc's frame, with a root at tau = 0."""

    def __init__(self, z, radius, eccentricity, pin):
        self.z, self.radius, self.eccentricity, self.pin = z, radius, eccentricity, pin

    def trace(self, tau):
        r, a, z = self.radius, self.eccentricity, self.z
        return np.stack([r * np.cos(tau) - a * np.cos(z * tau), r * np.sin(tau) - a * np.sin(z * tau)], -1)

    def slope(self, tau):
        r, a, z = self.radius, self.eccentricity, self.z
        return np.stack([-r * np.sin(tau) + a * z * np.sin(z * tau), r * np.cos(tau) - a * z * np.cos(z * tau)], -1)

    def bend(self, tau):
        r, a, z = self.radius, self.eccentricity, self.z
        return np.stack([-r * np.cos(tau) + a * z * z * np.cos(z * tau), -r * np.sin(tau) + a * z * z * np.sin(z * tau)], -1)

    def normal(self, tau):
        """Outward."""
        d = self.slope(tau)
        return np.stack([d[..., 1], -d[..., 0]], -1) / np.linalg.norm(d, axis=-1)[..., None]

    def point(self, tau):
        return self.trace(tau) - self.pin * self.normal(tau)

    def foot(self, place, start=None):
        """Trace parameter of the foot of a point near the trace; short steps from a start remain on its branch."""
        tau = np.arctan2(place[..., 1], place[..., 0]) if start is None else start
        reach = 1.0 if start is None else 1e-3
        for _ in range(80):
            d, t, b = self.trace(tau) - place, self.slope(tau), self.bend(tau)
            value, rate = (d * t).sum(-1), (t * t).sum(-1) + (d * b).sum(-1)
            step = np.clip(value / np.where(rate > 0.05 * (t * t).sum(-1), rate, (t * t).sum(-1)), -reach, reach)
            tau = tau - step
            if np.abs(step).max() < 1e-13:
                break
        return tau

    def curvature(self, tau):
        """Curvature of the trace, 1/mm, positive where the flank is concave."""
        d, b = self.slope(tau), self.bend(tau)
        return -(d[..., 0] * b[..., 1] - d[..., 1] * b[..., 0]) / np.linalg.norm(d, axis=-1) ** 3


def sheet(outline, bores, hole, windows, sizes, inner_places):
    """Triangles of six nodes of a disc. `bores`: (x, y, radius); `windows`: (middle, dimensions of a sector).

    Returns nodes, elements, and edges of three nodes on the flank and on each bore. There are nodes at `inner_places`.
    """
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    occ = gmsh.model.occ
    flank_size, bore_size, size = sizes
    # Equidistant points along the flank with straight edges; the nodes between them are moved onto the flank afterwards.
    dense = np.linspace(0, 2 * math.pi, 40 * 39 * 40 + 1)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(outline.point(dense), axis=0), axis=1))])
    count = round(way[-1] / flank_size)
    tau = np.interp(np.arange(count) * way[-1] / count, way, dense)
    points = [occ.addPoint(x, y, 0) for x, y in outline.point(tau)]
    lines = [occ.addLine(points[i], points[(i + 1) % count]) for i in range(count)]
    loops = [occ.addCurveLoop(lines)]
    rims = []
    for x, y, r in bores + [(0.0, 0.0, hole)]:
        rims.append(occ.addCircle(x, y, 0, r))
        loops.append(occ.addCurveLoop([rims[-1]]))
    face = (2, occ.addPlaneSurface(loops))
    occ.synchronize()
    tools = []
    for middle, dimensions in windows:
        for solid in bodies.sector(middle, -1.0, 2.0, dimensions):
            tools.append(solid)
    occ.synchronize()
    cut = [entity for entity in occ.cut([face], tools)[0] if entity[0] == 2]
    occ.synchronize()
    assert len(cut) == 1
    inner = [occ.addPoint(x, y, 0) for x, y in inner_places]
    if inner:
        cut = [e for e in occ.fragment(cut, [(0, p) for p in inner])[0] if e[0] == 2]
    occ.synchronize()

    def sizes_at(dim, tag, x, y, z, lc):
        r = math.hypot(x, y)
        near = min(abs(math.hypot(x - bx, y - by) - br) for bx, by, br in bores)
        flank = max(0.0, outline.radius - outline.pin - outline.eccentricity - r)
        return min(size, flank_size + 0.25 * flank, bore_size + 0.25 * near)
    gmsh.model.mesh.setSizeCallback(sizes_at)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 20)
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    nodes = {int(t): (xyz[3 * i], xyz[3 * i + 1], 0.0) for i, t in enumerate(tags)}
    _, flat = gmsh.model.mesh.getElementsByType(9)
    elements = [[int(t) for t in flat[i:i + 6]] for i in range(0, len(flat), 6)]
    _, flat = gmsh.model.mesh.getElementsByType(8)
    edges = [[int(t) for t in flat[i:i + 3]] for i in range(0, len(flat), 3)]
    gmsh.finalize()
    used = {t for e in elements for t in e}
    nodes = {t: nodes[t] for t in used}
    for e in elements:
        (ax, ay, _), (bx, by, _), (cx, cy, _) = (nodes[t] for t in e[:3])
        if (bx - ax) * (cy - ay) < (by - ay) * (cx - ax):
            e[1], e[2], e[3], e[5] = e[2], e[1], e[5], e[3]
    edges = [e for e in edges if all(t in used for t in e)]
    on_flank, on_bores = [], [[] for _ in bores]
    places = np.array([nodes[e[2]][:2] for e in edges])
    far = np.hypot(places[:, 0], places[:, 1]) > outline.radius - outline.pin - outline.eccentricity - 0.2
    for edge, place, outside in zip(edges, places, far):
        if outside:
            on_flank.append(edge)
            continue
        for k, (x, y, r) in enumerate(bores):
            if abs(math.hypot(place[0] - x, place[1] - y) - r) < 1e-3:
                on_bores[k].append(edge)
    # Mid-side nodes of the flank are moved onto it, at the mean of the parameters of the ends.
    ends = {t for e in on_flank for t in e[:2]}
    ends = sorted(ends)
    foot = dict(zip(ends, foot_of_flank(outline, np.array([nodes[t][:2] for t in ends]))))
    assert len(on_flank) == count, (len(on_flank), count)
    for a, b, middle in on_flank:
        apart = (foot[b] - foot[a] + math.pi) % (2 * math.pi) - math.pi
        x, y = outline.point(np.array(foot[a] + 0.5 * apart))
        nodes[middle] = (float(x), float(y), 0.0)
    return nodes, elements, on_flank, on_bores


def foot_of_flank(outline, places):
    """Parameters of points on the flank, by a table and Newton's method."""
    dense = np.linspace(0, 2 * math.pi, 40 * 39 * 10, endpoint=False)
    from scipy.spatial import cKDTree
    tau = dense[cKDTree(outline.point(dense)).query(places)[1]]
    for _ in range(30):
        h = 1e-6
        d, t = outline.point(tau) - places, (outline.point(tau + h) - outline.point(tau - h)) / (2 * h)
        tau = tau - (d * t).sum(-1) / (t * t).sum(-1)
    assert np.linalg.norm(outline.point(tau) - places, axis=1).max() < 1e-6
    return tau


def edge_load(body, edges, traction):
    """Consistent load of a force per length of the edge, a function of position."""
    index = np.array([[body.index[t] for t in e] for e in edges])
    p = body.places[index][:, :, :2]
    load = body.column()
    for u, w in EDGE:
        shape = np.array([(1 - u) * (1 - 2 * u), u * (2 * u - 1), 4 * u * (1 - u)])
        rate = np.array([4 * u - 3, 4 * u - 1, 4 - 8 * u])
        at, along = np.einsum("n,enc->ec", shape, p), np.einsum("n,enc->ec", rate, p)
        force = traction(at) * (np.linalg.norm(along, axis=1) * w)[:, None]
        for n in range(3):
            for c in range(2):
                np.add.at(load, 3 * index[:, n] + c, shape[n] * force[:, c])
    return load
