"""OpenCASCADE's triangulation of five surfaces: triangles, worst sampled deviation, time, and the surfaces' areas.

    $LOFTSMAN_ORACLES/python/bin/python tests/golden/tessellation.py D150WithGuides_wing.igs > tests/golden/tessellation.json

The IGES file is that of DLR-SC/tigl (tests/TestData/export, Apache-2.0); the largest of its surfaces is taken. The
tolerance is a thousandth of the diagonal of a sampled box. Deviations are those of each triangle's centroid and edge
midpoints from the surface, by Gauss-Newton steps from the mean of the corners' parameters.
"""
import json, math, os, sys, time
import numpy as np
import OCP.collections as oc
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepGProp import BRepGProp
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepTools import BRepTools
from OCP.Geom import Geom_BSplineSurface
from OCP.GProp import GProp_GProps
from OCP.gp import gp_Pnt, gp_Vec
from OCP.IGESControl import IGESControl_Reader
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS

# OpenCASCADE's readers talk on the standard output: that goes to the error stream, and what we say out.
OUT = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

H = math.sqrt(0.5)
FULL = [(1, 0, 1), (1, 1, H), (0, 1, 1), (-1, 1, H), (-1, 0, 1), (-1, -1, H), (0, -1, 1), (1, -1, H), (1, 0, 1)]
HALF = [(0, -1, 1), (1, -1, H), (1, 0, 1), (1, 1, H), (0, 1, 1)]


def arcs(quarters):
    return [0.0] * 3 + [float(k) for k in range(1, quarters) for _ in range(2)] + [float(quarters)] * 3


def revolved(profile, knots, degree):
    """A profile of (radius, height, weight) revolved about z."""
    net = [(x * r, y * r, z, w * v) for x, y, w in FULL for r, z, v in profile]
    return {"degrees": [2, degree], "knots": [arcs(4), knots],
            "points": [p[:3] for p in net], "weights": [p[3] for p in net]}


def sequence(seed, count):
    x, out = seed, []
    for _ in range(count):
        x = (1664525 * x + 1013904223) & 0xFFFFFFFF
        out.append(x / 4294967296.0)
    return out


def uneven(n, p, seed):
    s = np.concatenate([[0.0], np.cumsum(0.5 + np.array(sequence(seed, n - p)))])
    return [0.0] * p + list(s / s[-1]) + [1.0] * p


def wave():
    """The wavy rational bicubic of the benches, 50 x 50."""
    points, weights = [], []
    for i in range(50):
        for j in range(50):
            points.append((i / 49.0, j / 49.0, 0.1 * math.sin(0.7 * i) * math.cos(0.5 * j)))
            weights.append(1 + 0.5 * math.sin(0.9 * i + 1.3 * j))
    return {"degrees": [3, 3], "knots": [uneven(50, 3, 2), uneven(50, 3, 3)], "points": points, "weights": weights}


def largest(path):
    """The B-spline surface of an IGES file with the most control points."""
    reader = IGESControl_Reader()
    reader.ReadFile(path)
    reader.TransferRoots()
    best, explorer = None, TopExp_Explorer(reader.OneShape(), TopAbs_FACE)
    while explorer.More():
        s = BRep_Tool.Surface_s(TopoDS.Face(explorer.Current()))
        if isinstance(s, Geom_BSplineSurface):
            if best is None or s.NbUPoles() * s.NbVPoles() > best.NbUPoles() * best.NbVPoles():
                best = s
        explorer.Next()
    n, m = best.NbUPoles(), best.NbVPoles()
    flat = lambda count, knot, times: [knot(k) for k in range(1, count + 1) for _ in range(times(k))]
    out = {"degrees": [best.UDegree(), best.VDegree()],
           "knots": [flat(best.NbUKnots(), best.UKnot, best.UMultiplicity),
                     flat(best.NbVKnots(), best.VKnot, best.VMultiplicity)]}
    poles = [best.Pole(i, j) for i in range(1, n + 1) for j in range(1, m + 1)]
    out["points"] = [(p.X(), p.Y(), p.Z()) for p in poles]
    if best.IsURational() or best.IsVRational():
        out["weights"] = [best.Weight(i, j) for i in range(1, n + 1) for j in range(1, m + 1)]
    return out


def runs(knots):
    values, times = [], []
    for k in knots:
        if values and values[-1] == k:
            times[-1] += 1
        else:
            values.append(k)
            times.append(1)
    reals, counts = oc.Array1_double(1, len(values)), oc.Array1_int(1, len(values))
    for i, (v, t) in enumerate(zip(values, times)):
        reals.SetValue(i + 1, float(v))
        counts.SetValue(i + 1, t)
    return reals, counts


def build(s):
    (p, q), (u, v) = s["degrees"], s["knots"]
    n, m = len(u) - p - 1, len(v) - q - 1
    poles, weights = oc.Array2_gp_Pnt(1, n, 1, m), oc.Array2_double(1, n, 1, m)
    for k, x in enumerate(s["points"]):
        poles.SetValue(k // m + 1, k % m + 1, gp_Pnt(*map(float, x)))
        weights.SetValue(k // m + 1, k % m + 1, float(s["weights"][k]) if "weights" in s else 1.0)
    (ku, mu), (kv, mv) = runs(u), runs(v)
    return Geom_BSplineSurface(poles, weights, ku, kv, mu, mv, p, q)


def measure(s):
    surface = build(s)
    u0, u1, v0, v1 = s["knots"][0][0], s["knots"][0][-1], s["knots"][1][0], s["knots"][1][-1]
    grid = np.array([[(p.X(), p.Y(), p.Z()) for p in (surface.Value(u, v) for v in np.linspace(v0, v1, 101))]
                     for u in np.linspace(u0, u1, 101)]).reshape(-1, 3)
    tolerance = 1e-3 * float(np.linalg.norm(grid.max(0) - grid.min(0)))
    best, face = math.inf, BRepBuilderAPI_MakeFace(surface, 1e-6).Face()
    for _ in range(2):
        BRepTools.Clean_s(face)
        start = time.process_time()
        BRepMesh_IncrementalMesh(face, tolerance, False, 3.0, False)
        best = min(best, time.process_time() - start)
    t = BRep_Tool.Triangulation_s(face, TopLoc_Location())
    uv = np.array([(x.X(), x.Y()) for x in (t.UVNode(i) for i in range(1, t.NbNodes() + 1))])
    at = np.array([(x.X(), x.Y(), x.Z()) for x in (t.Node(i) for i in range(1, t.NbNodes() + 1))])
    triangles = np.array([t.Triangle(i).Get() for i in range(1, t.NbTriangles() + 1)])[:, -3:] - 1
    worst, point, du, dv = 0.0, gp_Pnt(), gp_Vec(), gp_Vec()
    for mix in ((1 / 3, 1 / 3, 1 / 3), (0.5, 0.5, 0), (0, 0.5, 0.5), (0.5, 0, 0.5)):
        targets = np.einsum("k,tkc->tc", mix, at[triangles])
        places = np.einsum("k,tkc->tc", mix, uv[triangles])
        for x, (u, v) in zip(targets, places):
            near = math.inf
            for _ in range(4):
                surface.D1(float(u), float(v), point, du, dv)
                r = x - (point.X(), point.Y(), point.Z())
                near = min(near, float(r @ r))
                a, b = np.array((du.X(), du.Y(), du.Z())), np.array((dv.X(), dv.Y(), dv.Z()))
                aa, ab, bb, e, f = a @ a, a @ b, b @ b, a @ r, b @ r
                det = aa * bb - ab * ab
                if not det > 1e-14 * aa * bb:
                    break
                u = min(max(u + (bb * e - ab * f) / det, u0), u1)
                v = min(max(v + (aa * f - ab * e) / det, v0), v1)
            worst = max(worst, near)
    area = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, area, 1e-8)
    return {"tolerance": tolerance, "area": area.Mass(),
            "occt": {"triangles": int(t.NbTriangles()), "deviation": math.sqrt(worst), "seconds": round(best, 4)}}


surfaces = {
    "wave": wave(),
    "sphere": revolved([(r, z, w) for r, z, w in HALF], arcs(2), 2),
    "torus": revolved([(3 + x, z, w) for x, z, w in FULL], arcs(4), 2),
    "needle": revolved([(0.0, 20.0, 1), (0.5, 0.0, 1)], [0.0, 0.0, 1.0, 1.0], 1),
    "wing": largest(sys.argv[1]),
}
out = []
for name, s in surfaces.items():
    entry = {"name": name, **measure(s)}
    print(name, entry, file=sys.stderr, flush=True)
    # The wave is defined by its formula, in the benches too.
    out.append(entry if name == "wave" else {**entry, **s})
OUT.write('{"made_by": "OpenCASCADE through OCP, angle 3 rad, one thread", "surfaces": [\n')
OUT.write(",\n".join(json.dumps(entry) for entry in out) + "\n]}\n")
OUT.close()
