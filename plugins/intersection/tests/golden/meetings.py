"""Golden meetings by OpenCASCADE: `python meetings.py > meetings.json` (cadquery-ocp, of scripts/oracles.sh). Times on stderr."""

import json
import math
import sys
import time

from OCP.GCPnts import GCPnts_AbscissaPoint
from OCP.Geom import Geom_BSplineCurve, Geom_BSplineSurface, Geom_Plane
from OCP.Geom2d import Geom2d_BSplineCurve
from OCP.Geom2dAPI import Geom2dAPI_InterCurveCurve
from OCP.GeomAdaptor import GeomAdaptor_Curve
from OCP.GeomAPI import GeomAPI_IntCS, GeomAPI_IntSS
from OCP.gp import gp_Dir, gp_Pnt, gp_Pnt2d
from OCP.collections import (Array1_double as TColStd_Array1OfReal, Array1_gp_Pnt as TColgp_Array1OfPnt,
                             Array1_gp_Pnt2d as TColgp_Array1OfPnt2d, Array1_int as TColStd_Array1OfInteger,
                             Array2_double as TColStd_Array2OfReal, Array2_gp_Pnt as TColgp_Array2OfPnt)

TOLERANCE = 1e-9


def knots(degree, n):
    values = list(range(n - degree + 1))
    k, m = TColStd_Array1OfReal(1, len(values)), TColStd_Array1OfInteger(1, len(values))
    for i, v in enumerate(values):
        k.SetValue(i + 1, float(v))
        m.SetValue(i + 1, degree + 1 if i in (0, len(values) - 1) else 1)
    return k, m


def weights(n, seed):
    return [1 + 0.5 * math.sin(seed + 1.7 * i) for i in range(n)]


def wave(n, seed, flat):
    """Uneven zigzags: no random numbers."""
    return [[i + 0.4 * math.sin(3 * i + seed), 3 * math.sin(2.1 * i + seed), 0.0 if flat else math.cos(1.3 * i + seed)]
            for i in range(n)]


def net(n, m, seed):
    return [[[float(i), float(j), 1.5 * math.sin(1.9 * i + seed) * math.cos(1.3 * j - seed)] for j in range(m)] for i in range(n)]


def curve(points, w, degree, flat):
    n = len(points)
    array = (TColgp_Array1OfPnt2d if flat else TColgp_Array1OfPnt)(1, n)
    ws = TColStd_Array1OfReal(1, n)
    for i, p in enumerate(points):
        array.SetValue(i + 1, gp_Pnt2d(p[0], p[1]) if flat else gp_Pnt(*p))
        ws.SetValue(i + 1, w[i])
    return (Geom2d_BSplineCurve if flat else Geom_BSplineCurve)(array, ws, *knots(degree, n), degree, False)


def surface(points, w, degree):
    n, m = len(points), len(points[0])
    array, ws = TColgp_Array2OfPnt(1, n, 1, m), TColStd_Array2OfReal(1, n, 1, m)
    for i in range(n):
        for j in range(m):
            array.SetValue(i + 1, j + 1, gp_Pnt(*points[i][j]))
            ws.SetValue(i + 1, j + 1, w[i][j])
    (ku, mu), (kv, mv) = knots(degree, n), knots(degree, m)
    return Geom_BSplineSurface(array, ws, ku, kv, mu, mv, degree, degree, False, False)


def timed(name, work):
    start = time.perf_counter()
    result = work()
    print(f"{name}: {1e3 * (time.perf_counter() - start):.3f} ms", file=sys.stderr)
    return result


golden = {"curves": [], "curve_surface": [], "sections": [], "itself": []}
for degree in (2, 3, 4, 5):
    for seed in range(5):
        p, q = wave(12, seed, True), [[0.9 * y + 5.5, 1.1 * x - 6.0, 0.0] for x, y, _ in wave(11, seed + 0.5, True)]
        wp, wq = weights(12, seed), weights(11, seed + 2)
        a, b = curve(p, wp, degree, True), curve(q, wq, degree, True)
        found = timed(f"curves {degree}", lambda: Geom2dAPI_InterCurveCurve(a, b, TOLERANCE))
        points = sorted([found.Point(k + 1).X(), found.Point(k + 1).Y(), 0.0] for k in range(found.NbPoints()))
        golden["curves"].append(dict(degree=degree, a=p, wa=wp, b=q, wb=wq, points=points))
for degree in (2, 3, 4):
    for seed in range(4):
        p, s = wave(8, seed, False), net(8, 7, seed)
        p = [[0.8 * x + 0.4, y + 3.0, z] for x, y, z in p]
        wp, ws = weights(8, seed), [weights(7, seed + i) for i in range(8)]
        c, f = curve(p, wp, degree, False), surface(s, ws, degree)
        found = timed(f"curve surface {degree}", lambda: GeomAPI_IntCS(c, f))
        points = sorted([found.Point(k + 1).X(), found.Point(k + 1).Y(), found.Point(k + 1).Z()] for k in range(found.NbPoints()))
        golden["curve_surface"].append(dict(degree=degree, a=p, wa=wp, b=s, wb=ws, points=points))
        normal = [0.3, -0.2 + 0.1 * seed, 1.0]
        plane = Geom_Plane(gp_Pnt(4.0, 3.0, 0.1), gp_Dir(*normal))
        cut = timed(f"section {degree}", lambda: GeomAPI_IntSS(f, plane, 1e-7))
        length, samples = 0.0, []
        for k in range(cut.NbLines()):
            line = cut.Line(k + 1)
            length += GCPnts_AbscissaPoint.Length_s(GeomAdaptor_Curve(line))
            low, high = line.FirstParameter(), line.LastParameter()
            for i in range(6):
                x = line.Value(low + (high - low) * i / 5)
                samples.append([x.X(), x.Y(), x.Z()])
        golden["sections"].append(dict(degree=degree, b=s, wb=ws, point=[4.0, 3.0, 0.1], normal=normal, length=length,
                                       lines=cut.NbLines(), samples=samples))
for degree in (2, 3, 4, 5):
    for seed in range(5):
        # A way that winds across itself.
        p = [[3 * math.sin(2.3 * i + seed) + 0.3 * i, 2.5 * math.cos(1.7 * i - seed), 0.0] for i in range(12)]
        w = weights(12, seed)
        c = curve(p, w, degree, True)
        found = timed(f"itself {degree}", lambda: Geom2dAPI_InterCurveCurve(c, TOLERANCE))
        points = sorted([found.Point(k + 1).X(), found.Point(k + 1).Y(), 0.0] for k in range(found.NbPoints()))
        golden["itself"].append(dict(degree=degree, a=p, wa=w, points=points))
json.dump(golden, sys.stdout)
