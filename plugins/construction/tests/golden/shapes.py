"""Golden shapes by OpenCASCADE: `python shapes.py > shapes.json` (cadquery-ocp, of scripts/oracles.sh)."""

import json
import math
import sys

from OCP.BRepAdaptor import BRepAdaptor_CompCurve
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakePolygon, BRepBuilderAPI_MakeWire
from OCP.BRepGProp import BRepGProp
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakeOffset, BRepOffsetAPI_MakePipe
from OCP.GCPnts import GCPnts_AbscissaPoint, GCPnts_UniformAbscissa
from OCP.Geom import (Geom_BSplineCurve, Geom_BSplineSurface, Geom_Circle, Geom_Ellipse, Geom_OffsetCurve,
                      Geom_SurfaceOfRevolution)
from OCP.GeomAbs import GeomAbs_Arc, GeomAbs_Intersection
from OCP.GeomAdaptor import GeomAdaptor_Curve
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_EDGE, TopAbs_WIRE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS
from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int, Array2_double, Array2_gp_Pnt
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt


def knots(degree, n):
    values = list(range(n - degree + 1))
    k, m = Array1_double(1, len(values)), Array1_int(1, len(values))
    for i, v in enumerate(values):
        k.SetValue(i + 1, float(v))
        m.SetValue(i + 1, degree + 1 if i in (0, len(values) - 1) else 1)
    return k, m


def weights(n, seed):
    return [1 + 0.4 * math.sin(seed + 1.7 * i) for i in range(n)]


def curve(points, w, degree):
    n = len(points)
    array, ws = Array1_gp_Pnt(1, n), Array1_double(1, n)
    for i, p in enumerate(points):
        array.SetValue(i + 1, gp_Pnt(*p))
        ws.SetValue(i + 1, w[i])
    return Geom_BSplineCurve(array, ws, *knots(degree, n), degree, False)


def wave(n, seed, flat):
    """Gentle waves: no random numbers."""
    return [[i + 0.3 * math.sin(3 * i + seed), 1.2 * math.sin(0.9 * i + seed), 0.0 if flat else math.cos(0.7 * i + seed)]
            for i in range(n)]


def xyz(p):
    return [p.X(), p.Y(), p.Z()]


def samples(shape, count):
    low, high = shape.FirstParameter(), shape.LastParameter()
    return [xyz(shape.Value(low + (high - low) * i / (count - 1))) for i in range(count)]


def length(shape):
    return GCPnts_AbscissaPoint.Length_s(GeomAdaptor_Curve(shape), 1e-12)


def wires(shape):
    explorer, found = TopExp_Explorer(shape, TopAbs_WIRE), 0
    while explorer.More():
        found += 1
        explorer.Next()
    return found


def total(shape):
    properties = GProp_GProps()
    BRepGProp.LinearProperties_s(shape, properties)
    return properties.Mass()


def edge_wire(shape):
    return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(shape).Edge()).Wire()


golden = {"offsets": [], "outlines": [], "even": [], "revolved": [], "conics": [], "isocurves": [], "pipes": []}
for degree in (2, 3, 4, 5):
    for seed in range(3):
        p, w = wave(9, seed, True), weights(9, seed)
        c = curve(p, w, degree)
        # Right of its way, as ours: OpenCASCADE moves along T × Z. No more than the least radius of curvature: no loops.
        for away in (0.05, -0.05):
            moved = Geom_OffsetCurve(c, away, gp_Dir(0, 0, 1))
            golden["offsets"].append(dict(degree=degree, p=p, w=w, away=away, points=samples(moved, 40)))
        q = wave(9, seed + 0.5, False)
        c = curve(q, w, degree)
        even = GCPnts_UniformAbscissa(GeomAdaptor_Curve(c), 8, 1e-12)
        golden["even"].append(dict(degree=degree, p=q, w=w, length=length(c),
                                   points=[xyz(c.Value(even.Parameter(i + 1))) for i in range(8)]))
        turned = Geom_SurfaceOfRevolution(c, gp_Ax1(gp_Pnt(1, -4, 2), gp_Dir(1, 2, 0.5)))
        low, high = c.FirstParameter(), c.LastParameter()
        places = [(0.9 * i, low + (high - low) * (i % 4) / 3) for i in range(7)]
        golden["revolved"].append(dict(degree=degree, p=q, w=w, places=places, points=[xyz(turned.Value(*x)) for x in places]))
        n, m = 6, 7
        net = [[[float(i), float(j), math.sin(1.9 * i + seed) * math.cos(1.3 * j)] for j in range(m)] for i in range(n)]
        ws = [weights(m, seed + i) for i in range(n)]
        array, wa = Array2_gp_Pnt(1, n, 1, m), Array2_double(1, n, 1, m)
        for i in range(n):
            for j in range(m):
                array.SetValue(i + 1, j + 1, gp_Pnt(*net[i][j]))
                wa.SetValue(i + 1, j + 1, ws[i][j])
        (ku, mu), (kv, mv) = knots(degree, n), knots(degree, m)
        surface = Geom_BSplineSurface(array, wa, ku, kv, mu, mv, degree, degree, False, False)
        at = 0.37
        golden["isocurves"].append(dict(degree=degree, net=net, w=ws, at=at, u=samples(surface.UIso(at), 9), v=samples(surface.VIso(at), 9)))
axes = gp_Ax2(gp_Pnt(1, 2, 3), gp_Dir(0.2, -0.4, 1), gp_Dir(1, 0.5, 0))
for x, y in ((2.0, 2.0), (3.0, 1.0), (5.0, 0.2)):
    c = Geom_Circle(axes, x) if x == y else Geom_Ellipse(axes, x, y)
    golden["conics"].append(dict(center=[1, 2, 3], x=[x * t for t in xyz(axes.XDirection())], y=[y * t for t in xyz(axes.YDirection())],
                                 length=length(c), points=samples(c, 25)))
outlines = {
    "house": [[0, 0], [4, 0], [4, 3], [2, 5], [0, 3]],
    "cross": [[1, 0], [2, 0], [2, 1], [3, 1], [3, 2], [2, 2], [2, 3], [1, 3], [1, 2], [0, 2], [0, 1], [1, 1]],
    "rooms": [[0, 0], [3, 0], [3, 1.2], [4, 1.2], [4, 0], [7, 0], [7, 3], [4, 3], [4, 1.8], [3, 1.8], [3, 3], [0, 3]],
}
for name, points in outlines.items():
    polygon = BRepBuilderAPI_MakePolygon()
    for x, y in points:
        polygon.Add(gp_Pnt(x, y, 0))
    polygon.Close()
    for away in (0.3, -0.1, -0.2, -0.4):
        for kind, join in (("round", GeomAbs_Arc), ("sharp", GeomAbs_Intersection)):
            moved = BRepOffsetAPI_MakeOffset(polygon.Wire(), join)
            moved.Perform(away)
            golden["outlines"].append(dict(name=name, points=points, away=away, corners=kind, wires=wires(moved.Shape()),
                                           length=total(moved.Shape())))
paths = {"arc": ([[3, 0, 0], [3, 3, 0], [0, 3, 0]], [1, math.sqrt(0.5), 1], 2)}
for seed in range(3):
    paths[f"flat {seed}"] = (wave(7, seed, True), weights(7, seed), 4)
    paths[f"spiral {seed}"] = (wave(7, seed, False), weights(7, seed), 5)
for name, (p, w, degree) in paths.items():
    c = curve(p, w, degree)
    point, along = c.Value(0.0), c.DN(0.0, 1)
    radius = 0.1
    ring = Geom_Circle(gp_Ax2(point, gp_Dir(along.X(), along.Y(), along.Z())), radius)
    pipe = BRepOffsetAPI_MakePipe(edge_wire(c), edge_wire(ring)).Shape()
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(pipe, properties, 1e-9)
    golden["pipes"].append(dict(name=name, degree=degree, p=p, w=w, radius=radius, length=length(c), area=properties.Mass()))
json.dump(golden, sys.stdout)
