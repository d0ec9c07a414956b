"""W3 with trims in OpenCASCADE: the solids of benches/solids.rs by BRepMesh_IncrementalMesh, processor time of one thread, median; and reading of
files that hold the first of them many times.

BRepMesh takes its deflection for a goal, not for a bound: its deviation is sampled where each triangle's edges have their middles and it
its own, between the surface there and the plane of the triangle, and the deflection is halved until the tolerance is met (not timed).

benches/run.sh solids runs it just before ours, with the folder of criterion's results as argument. By hand, with numpy and cadquery-ocp:

    python3 benches/peers/solids.py
"""
import json
import pathlib
import re
import statistics
import sys
import tempfile
import time

try:
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepTools import BRepTools
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS
except ImportError:
    print("SKIPPED: no OpenCASCADE (cadquery-ocp) in this Python", file=sys.stderr)
    sys.exit()

import numpy as np

FILES = ["NIST_MBE_PMI_1", "NIST_MBE_PMI_3", "NIST_MBE_PMI_11"]
DATA = pathlib.Path(__file__).parents[2] / "tests" / "data" / "step"
ANGLE = np.pi
TIMES = [1, 12, 100]
PLACES = [(1 / 3, 1 / 3, 1 / 3), (0.5, 0.5, 0), (0, 0.5, 0.5), (0.5, 0, 0.5)]
as_face = getattr(TopoDS, "Face_s", None) or TopoDS.Face
as_vertex = getattr(TopoDS, "Vertex_s", None) or TopoDS.Vertex


def parts(shape, kind):
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def tolerance(shape):
    points = (BRep_Tool.Pnt_s(as_vertex(v)) for v in parts(shape, TopAbs_ShapeEnum.TopAbs_VERTEX))
    points = np.array([[p.X(), p.Y(), p.Z()] for p in points])
    return 1e-3 * np.linalg.norm(points.max(0) - points.min(0))


def repeated(name, times):
    """The text of a file with all that it holds so many times, entities numbered on, as benches/src/shapes.rs makes it."""
    text = (DATA / f"{name}.stp").read_text(encoding="latin-1")
    head, rest = text.split("DATA;", 1)
    body, tail = rest.split("ENDSEC;", 1)
    most = max(int(n) for n in re.findall(r"#(\d+)", body))
    copies = (re.sub(r"#(\d+)", lambda m: f"#{int(m[1]) + k * most}", body) for k in range(times))
    return head + "DATA;" + "".join(copies) + "ENDSEC;" + tail


def keep(group, case, median):
    """Where criterion's summary looks for it."""
    if len(sys.argv) > 1:
        folder = pathlib.Path(sys.argv[1], group, "OpenCASCADE", case, "new")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "estimates.json").write_text(json.dumps({"median": {"point_estimate": median}}))


def mesh(shape, deflection):
    BRepTools.Clean_s(shape, True)
    start = time.process_time()
    BRepMesh_IncrementalMesh(shape, deflection, False, ANGLE, False)
    return time.process_time() - start


def deviation(shape):
    """The largest distance of the surface from the planes of triangles at the sampled places, and how many triangles there are."""
    worst, count = 0.0, 0
    for face in parts(shape, TopAbs_ShapeEnum.TopAbs_FACE):
        face = as_face(face)
        cut = BRep_Tool.Triangulation_s(face, TopLoc_Location())
        surface = BRepAdaptor_Surface(face)
        nodes = [cut.Node(k) for k in range(1, cut.NbNodes() + 1)]
        points = np.array([[p.X(), p.Y(), p.Z()] for p in nodes])
        places = [cut.UVNode(k) for k in range(1, cut.NbNodes() + 1)]
        places = np.array([[p.X(), p.Y()] for p in places])
        corners = np.array([cut.Triangle(k).Get() for k in range(1, cut.NbTriangles() + 1)]) - 1
        count += len(corners)
        a, b, c = (points[corners[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        size = np.linalg.norm(normal, axis=1)
        known = size > 0
        normal[known] /= size[known, None]
        for share in PLACES:
            at = sum(w * places[corners[:, k]] for k, w in enumerate(share))
            on = [surface.Value(u, v) for u, v in at]
            on = np.array([[p.X(), p.Y(), p.Z()] for p in on])
            off = np.abs(np.einsum("ij,ij->i", on - a, normal))[known]
            worst = max(worst, off.max(initial=0.0))
    return worst, count


for name in FILES:
    reader = STEPControl_Reader()
    reader.ReadFile(str(DATA / f"{name}.stp"))
    reader.TransferRoots()
    shape = reader.OneShape()
    wanted = deflection = tolerance(shape)
    mesh(shape, deflection)
    worst, triangles = deviation(shape)
    while worst > wanted and deflection > 1e-3 * wanted:
        deflection /= 2
        mesh(shape, deflection)
        worst, triangles = deviation(shape)
    median = 1e9 * statistics.median(mesh(shape, deflection) for _ in range(9))
    keep("W3 solids", name, median)
    share = deflection / wanted
    print(f"| OpenCASCADE | {name} | {triangles} triangles | sampled {worst / wanted:.3f} tolerances at {share:g} | {1e-6 * median:.1f} ms |", flush=True)

with tempfile.TemporaryDirectory() as folder:
    for times in TIMES:
        file = pathlib.Path(folder, "repeated.stp")
        file.write_text(repeated(FILES[0], times), encoding="latin-1")
        taken = []
        for _ in range(3 if times < 100 else 1):
            start = time.process_time()
            reader = STEPControl_Reader()
            reader.ReadFile(str(file))
            reader.TransferRoots()
            taken.append(time.process_time() - start)
            assert reader.NbShapes() == times
        median = 1e9 * statistics.median(taken)
        keep("STEP read", str(times), median)
        print(f"| OpenCASCADE | {file.stat().st_size / 1e6:.1f} MB of STEP | read and transferred | {1e-6 * median:.0f} ms |", flush=True)
