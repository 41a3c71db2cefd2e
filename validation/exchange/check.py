"""Reads the exports with ezdxf and OpenCascade and compares them with the exact flank and closed forms.

Usage: check.py DIR drawings|solids|meshes, where DIR was written by the example `exchange_files`: drawings and tables
with ezdxf, solids with OpenCascade, or STL and 3MF with trimesh. Every check prints its value and limit; the exit status
is 1 if a limit is exceeded.
"""

import json
import math
import sys
import zipfile
from pathlib import Path

import numpy as np

DRAWINGS, SOLIDS, MESHES = (sys.argv[2] == what for what in ("drawings", "solids", "meshes"))
if DRAWINGS:
    import ezdxf
elif MESHES:
    import trimesh
elif not SOLIDS:
    raise SystemExit("usage: check.py DIR drawings|solids|meshes")
else:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer

failures = 0


def check(what, value, limit):
    global failures
    kept = value <= limit
    failures += not kept
    print(f"{'ok  ' if kept else 'FAIL'} {what}: {value:.3g} (limit {limit:.3g})")


class Edge:
    """The exact edge, implemented independently from its definition: epitrochoid less pin, relief and offset."""

    def __init__(self, figures):
        self.radius = figures["pin_circle_radius_mm"]
        self.eccentricity = figures["eccentricity_mm"]
        self.pins = figures["pin_count"]
        self.pin_radius = figures["pin_radius_mm"]
        self.wear = figures["wear_mm"]
        self.offset = figures["offset_mm"]

    def bare(self, tau):
        """The edge without offset, as complex numbers: the trace less pin radius and depth along its normal."""
        z = self.pins
        trace = self.radius * np.exp(1j * tau) - self.eccentricity * np.exp(1j * z * tau)
        along = 1j * (self.radius * np.exp(1j * tau) - z * self.eccentricity * np.exp(1j * z * tau))
        # Depth 0.01 mm (1.2 + sin phi) times the switch, at the meshing angle phi = -(z - 1) tau.
        depth = self.wear * (1.2 + np.sin(-(z - 1) * tau))
        return trace - (self.pin_radius + depth) * (-1j * along / np.abs(along))

    def at(self, tau):
        """Edge and unit tangent; the tangent by differences of sixth order."""
        step = 2e-5
        weights = {-3: -1 / 60, -2: 3 / 20, -1: -3 / 4, 1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
        slope = sum(w * self.bare(tau + k * step) for k, w in weights.items()) / step
        tangent = slope / np.abs(slope)
        return self.bare(tau) - 1j * self.offset * tangent, tangent, np.abs(slope)

    def distance(self, points):
        """Distance of each point from the edge, by steps along the tangent from the nearest of many samples."""
        grid = np.linspace(0, 2 * math.pi, 2000 * (self.pins - 1), endpoint=False)
        samples, _, _ = self.at(grid)
        place = points[:, 0] + 1j * points[:, 1]
        centre = np.searchsorted(np.unwrap(np.angle(samples)), np.angle(place) % (2 * math.pi))
        shifts = np.arange(-400, 401, 20)
        index = (centre[:, None] + shifts) % len(grid)
        tau = grid[index[np.arange(len(place)), np.abs(samples[index] - place[:, None]).argmin(1)]]
        for _ in range(100):
            edge, tangent, speed = self.at(tau)
            tau = tau + np.clip(((place - edge) * np.conj(tangent)).real / speed, -1e-3, 1e-3)
        edge, _, _ = self.at(tau)
        return np.abs(place - edge)


def check_dxf(place, edge, figures):
    document = ezdxf.readfile(place / "profile.dxf")
    auditor = document.audit()
    check("ezdxf audit: errors", len(auditor.errors), 0)
    check("ezdxf audit: repairs", len(auditor.fixes), 0)
    model = document.modelspace()
    (polyline,) = model.query('LWPOLYLINE[layer=="FLANK_POLYLINE"]')
    check("open polylines", int(not polyline.closed), 0)
    corners = np.array([(x, y) for x, y, *_ in polyline.get_points()])
    tolerance = figures["polyline_deviation_mm"]
    check("corners off the exact flank, mm", edge.distance(corners).max(), 2e-9)
    middles = 0.5 * (corners + np.roll(corners, -1, axis=0))
    check("chords off the exact flank, mm", edge.distance(middles).max(), tolerance + 1e-8)
    check("stated deviation, mm", tolerance, 1.0e-3)
    check_spline(model, edge, figures)
    # One disc for cutting: one contour, the openings of this disc, nothing else.
    for kind, entity in (("polyline", "LWPOLYLINE"), ("spline", "SPLINE")):
        cutter = ezdxf.readfile(place / f"cutter-{kind}.dxf")
        check(f"{kind} for a cutter, ezdxf audit: findings", len(cutter.audit().errors) + len(cutter.audit().fixes), 0)
        model = cutter.modelspace()
        flanks = [e.dxftype() for e in model if e.dxf.layer.startswith("FLANK")]
        check(f"{kind} for a cutter: flanks that are not its own", int(flanks != [entity]), 0)
        others = {e.dxf.layer for e in model} - {"FLANK_POLYLINE", "FLANK_SPLINE"}
        wrong = [layer for layer in others if not layer.startswith("DISC_2_") or layer.endswith("MARK")]
        check(f"{kind} for a cutter: layers that are no contours", len(wrong), 0)
        opened = [e for e in model if e.dxftype() == "LWPOLYLINE" and not e.closed]
        check(f"{kind} for a cutter: open polylines", len(opened), 0)
        if kind == "spline":
            check_spline(model, edge, figures)


def check_spline(model, edge, figures):
    (spline,) = model.query('SPLINE[layer=="FLANK_SPLINE"]')
    # Closed by coinciding ends: some readers take a spline flagged as closed as periodic, and some do not display it.
    check("splines that are flagged as closed", int(spline.closed), 0)
    check("degree of the spline off three", abs(spline.dxf.degree - 3), 0)
    curve = spline.construction_tool()
    points = np.array([(p.x, p.y) for p in curve.approximate(len(spline.control_points) * 4)])
    off = edge.distance(points).max()
    check("spline off the exact flank, mm", off, figures["spline_deviation_mm"] + 1e-8)
    check("gap of the spline, mm", float(np.hypot(*(points[0] - points[-1]))), 1e-8)


def read(path):
    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        raise SystemExit(f"{path}: not read")
    reader.TransferRoots()
    return reader.OneShape()


def pieces(shape, kind):
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def default_volume(shape):
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return properties.Mass()


def volume(shape):
    # With a given precision OpenCascade integrates adaptively, without one by a rule of limited order for each face.
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, 1e-9)
    return properties.Mass()


def surface(shape):
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, properties, 1e-9)
    return properties.Mass()


def check_solids(path, expected):
    text = path.read_text()
    check(f"{path.name}: missing products", max(0, len(expected) - text.count("=PRODUCT(")), 0)
    for part in expected:
        check(f"{path.name}: product '{part['name']}' missing", int(f"=PRODUCT('{part['name']}'" not in text), 0)
    check(f"{path.name}: not AP214", int("AUTOMOTIVE_DESIGN" not in text), 0)
    shape = read(path)
    solids = [solid for solid in pieces(shape, TopAbs_SOLID)]
    check(f"{path.name}: missing solids", abs(len(solids) - len(expected)), 0)
    for solid, part in zip(solids, expected):
        name = f"{path.name}: {part['name']}"
        check(f"{name}: invalid", int(not BRepCheck_Analyzer(solid).IsValid()), 0)
        check(f"{name}: volume", abs(volume(solid) / part["volume_mm3"] - 1), 1e-6)
        check(f"{name}: volume by default", abs(default_volume(solid) / part["volume_mm3"] - 1), 1e-5)
        check(f"{name}: surface", abs(surface(solid) / part["surface_mm2"] - 1), 1e-6)
        faces = sum(1 for _ in pieces(solid, TopAbs_FACE))
        print(f"     {name}: {faces} faces")


def check_assembly(path, figures, touching):
    """All parts are valid and in their positions; overlaps are limited to the deviation's depth at the contacts."""
    solids = [solid for solid in pieces(read(path), TopAbs_SOLID)]
    by_volume = {part["name"]: part["volume_mm3"] for part in figures["parts"]}
    discs = [s for s in solids if abs(volume(s) / by_volume["cycloid disc 1"] - 1) < 1e-5]
    pins = [s for s in solids if abs(volume(s) / by_volume["pin"] - 1) < 1e-5]
    cranks = [s for s in solids if abs(volume(s) / by_volume["crankshaft"] - 1) < 1e-5]
    print(f"     {path.name}: {len(discs)} discs, {len(pins)} pins, {len(cranks)} crankshafts")
    check(f"{path.name}: solids of another kind", len(solids) - len(discs) - len(pins) - len(cranks), 0)
    check(f"{path.name}: invalid solids", sum(not BRepCheck_Analyzer(s).IsValid() for s in solids), 0)
    worst = 0.0
    for disc in discs:
        for other in pins + cranks:
            common = BRepAlgoAPI_Common(disc, other)
            worst = max(worst, volume(common.Shape()) if common.IsDone() else math.inf)
    # A pin in contact overlaps by the spline's deviation over the width of a contact of that depth.
    check(f"{path.name}: largest overlap, mm3", worst, touching)


def check_drawings(place, figures):
    edge = Edge(figures)
    check_dxf(place, edge, figures)
    rows = [row for row in (place / "profile.csv").read_text().splitlines() if not row.startswith("#")]
    table = np.genfromtxt(rows, delimiter=",", names=True)
    corners = np.column_stack([table["x_mm"], table["y_mm"]])
    check("corners of the table off the exact flank, mm", edge.distance(corners).max(), 2e-9)


def check_parts(place, figures):
    parts = figures["parts"]
    discs = [part for part in parts if part["name"].startswith("cycloid")]
    check_solids(place / "discs.step", discs)
    check_solids(place / "pin.step", [part for part in parts if part["name"] == "pin"])
    check_solids(place / "crankshaft.step", [part for part in parts if part["name"] == "crankshaft"])
    if not place.name.endswith("wire"):
        # A lens of depth d between radii of 1.6 and 3 mm is 2 sqrt(2 R d) wide: under 0.1 mm for 1 µm.
        width = discs[0]["volume_mm3"] ** (1 / 3)
        check_assembly(place / "assembly.step", figures, 0.2 * figures["spline_deviation_mm"] * width)


def check_mesh(name, mesh, count, part, tolerance):
    """One part, or a number of copies of it: closed, oriented, and with a volume that is smaller by no more than by the chords."""
    check(f"{name}: open edges", int(not mesh.is_watertight), 0)
    check(f"{name}: triangles turned round", int(not mesh.is_winding_consistent), 0)
    check(f"{name}: bodies", abs(len(mesh.split(only_watertight=True)) - count), 0)
    # The volume error of chords is at most the tolerance times the surface; STL rounds to 24 bits.
    bound = (tolerance + 1e-5) * part["surface_mm2"] / part["volume_mm3"]
    check(f"{name}: volume", abs(mesh.volume / count / part["volume_mm3"] - 1), bound)


def packed(place, stem):
    """The example writes the files of a 3MF into a folder; they are packed here in the same way as by the command."""
    folder, target = place / f"{stem}.3mf.d", place / f"{stem}.3mf"
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(f for f in folder.rglob("*") if f.is_file()):
            archive.write(file, file.relative_to(folder).as_posix())
    return target


def check_meshes(place, figures):
    edge, tolerance = Edge(figures), figures["tolerance_mm"]
    by_name = {part["name"]: part for part in figures["parts"]}
    discs = sum(name.startswith("cycloid") for name in by_name)
    for stem, first, count in (
        ("discs", "cycloid disc 1", discs),
        ("disc-2", "cycloid disc 2", 1),
        ("pin", "pin", 1),
        ("crankshaft", "crankshaft", 1),
    ):
        stl = trimesh.load_mesh(place / f"{stem}.stl")
        check_mesh(f"{stem}.stl", stl, count, by_name[first], tolerance)
        scene = trimesh.load_scene(packed(place, stem))
        check(f"{stem}.3mf: unit is not mm", int(str(scene.units) not in ("millimeter", "mm")), 0)
        whole = scene.to_mesh()
        check_mesh(f"{stem}.3mf", whole, count, by_name[first], tolerance)
        check(f"{stem}.3mf: off the STL, mm", float(np.abs(whole.bounds - stl.bounds).max()), 1e-5)
        if stem == "disc-2":
            rim = np.hypot(*whole.vertices[:, :2].T) > edge.radius - edge.pin_radius - 3 * edge.eccentricity
            check(f"{stem}.3mf: corners off the exact flank, mm", edge.distance(whole.vertices[rim][:, :2]).max(), 2e-9)
    scene = trimesh.load_scene(packed(place, "assembly"))
    count = discs + figures["pin_count"] + figures["crankshaft_count"]
    stl = trimesh.load_mesh(place / "assembly.stl")
    parts = [mesh.copy() for mesh in scene.dump()]
    check("assembly.3mf: items", abs(len(parts) - count), 0)
    check("assembly.3mf: items that are not closed", sum(not part.is_watertight for part in parts), 0)
    volume = sum(part.volume for part in parts)
    check("assembly: STL against 3MF, volume", abs(stl.volume / volume - 1), 1e-6)


def main():
    for place in sorted(Path(sys.argv[1]).iterdir()):
        print(place.name)
        figures = json.loads((place / "figures.json").read_text())
        if DRAWINGS:
            check_drawings(place, figures)
        elif MESHES:
            check_meshes(place, figures)
        else:
            check_parts(place, figures)
    print("all kept" if failures == 0 else f"{failures} not kept")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
