#!/usr/bin/env python3
"""More meetings by OpenCASCADE: every degree from 1 to 5, conics, elementary surfaces, tangencies: `python hits.py > hits.json`.

It takes the Python of scripts/oracles.sh. OpenCASCADE is given conics and elementary surfaces as such; in the file they are the rational splines that it
makes of them. Of a case there are `points`, what it found, without what is not on both shapes (`off` says how many were not); `touching`,
which are known since the case is made so that the two touch there; and `count`, how many there are in all, where that is known: of
planar curves by the crossings of many chords, of elementary surfaces and planes by the changes of side of many places of the curve. `lacks` counts the points that
OpenCASCADE did not find.

`planar`: Geom2dAPI_InterCurveCurve. `space`: GeomAPI_ExtremaCurveCurve, distances of nothing. `surfaces` and `planes`: GeomAPI_IntCS. `sections` of surfaces by planes:
BRepAlgoAPI_Section, with the length. Where the surface is straight in one direction, and so has edges, the length is an integral, and OpenCASCADE's stands in
`theirs`: it is up to 4e-5 off.
"""
import json
import math
import os
import sys

_out = os.dup(1)
os.dup2(2, 1)

import numpy  # noqa: E402
from scipy.interpolate import BSpline  # noqa: E402

from OCP.BRepAdaptor import BRepAdaptor_Curve  # noqa: E402
from OCP.BRepAlgoAPI import BRepAlgoAPI_Section  # noqa: E402
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace  # noqa: E402
from OCP.GCPnts import GCPnts_AbscissaPoint  # noqa: E402
from OCP.Geom import (Geom_BSplineCurve, Geom_BSplineSurface, Geom_Circle, Geom_ConicalSurface, Geom_CylindricalSurface, Geom_Ellipse, Geom_Line, Geom_Plane,  # noqa: E402
                      Geom_RectangularTrimmedSurface, Geom_SphericalSurface, Geom_ToroidalSurface, Geom_TrimmedCurve)
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Circle, Geom2d_Ellipse, Geom2d_Line, Geom2d_TrimmedCurve  # noqa: E402
from OCP.Geom2dAPI import Geom2dAPI_InterCurveCurve, Geom2dAPI_ProjectPointOnCurve  # noqa: E402
from OCP.Geom2dConvert import Geom2dConvert  # noqa: E402
from OCP.GeomAPI import GeomAPI_ExtremaCurveCurve, GeomAPI_IntCS, GeomAPI_ProjectPointOnCurve, GeomAPI_ProjectPointOnSurf  # noqa: E402
from OCP.GeomConvert import GeomConvert  # noqa: E402
from OCP.TopAbs import TopAbs_ShapeEnum as Kind  # noqa: E402
from OCP.TopExp import TopExp_Explorer  # noqa: E402
from OCP.TopoDS import TopoDS  # noqa: E402
from OCP.collections import (Array1_double, Array1_gp_Pnt, Array1_gp_Pnt2d, Array1_int, Array2_double, Array2_gp_Pnt)  # noqa: E402
from OCP.gp import gp_Ax2, gp_Ax22d, gp_Ax3, gp_Dir, gp_Dir2d, gp_Pln, gp_Pnt, gp_Pnt2d  # noqa: E402

# How far a point may be from both shapes; how near two are one.
ON, SAME = 1e-7, 1e-5
CHORDS = 4000


def told(x):
    return [told(y) for y in x] if hasattr(x, "__len__") else float(f"{x:.12g}")


def knots(degree, n):
    values = list(range(n - degree + 1))
    k, m = Array1_double(1, len(values)), Array1_int(1, len(values))
    for i, v in enumerate(values):
        k.SetValue(i + 1, float(v))
        m.SetValue(i + 1, degree + 1 if i in (0, len(values) - 1) else 1)
    return k, m


def spline(points, weights, degree):
    """In the plane where its points are."""
    n, flat = len(points), len(points[0]) == 2
    array, ws = (Array1_gp_Pnt2d if flat else Array1_gp_Pnt)(1, n), Array1_double(1, n)
    for i, p in enumerate(told(points)):
        array.SetValue(i + 1, (gp_Pnt2d if flat else gp_Pnt)(*p))
        ws.SetValue(i + 1, told(weights)[i])
    return (Geom2d_BSplineCurve if flat else Geom_BSplineCurve)(array, ws, *knots(degree, n), degree, False)


def net(points, weights, degrees):
    n, m = len(points), len(points[0])
    array, ws = Array2_gp_Pnt(1, n, 1, m), Array2_double(1, n, 1, m)
    for i in range(n):
        for j in range(m):
            array.SetValue(i + 1, j + 1, gp_Pnt(*told(points[i][j])))
            ws.SetValue(i + 1, j + 1, told(weights[i][j]))
    (ku, mu), (kv, mv) = knots(degrees[0], n), knots(degrees[1], m)
    return Geom_BSplineSurface(array, ws, ku, kv, mu, mv, *degrees, False, False)


def xyz(p):
    return numpy.array([p.X(), p.Y(), p.Z()] if hasattr(p, "Z") else [p.X(), p.Y()])


def row(count, knot, times):
    return [knot(k + 1) for k in range(count) for _ in range(times(k + 1))]


def written(shape):
    """A curve or surface as the rational spline that it is; planes as such."""
    if isinstance(shape, Geom_Plane):
        return {"point": exact(xyz(shape.Location())), "normal": exact(xyz(shape.Axis().Direction()))}
    if "Surface" in type(shape).__name__:
        if not isinstance(shape, Geom_BSplineSurface):
            shape = GeomConvert.SurfaceToBSplineSurface_s(shape)
            shape.SetUNotPeriodic()
            shape.SetVNotPeriodic()
        n, m = shape.NbUPoles(), shape.NbVPoles()
        return {"degrees": [shape.UDegree(), shape.VDegree()],
                "knots": [row(shape.NbUKnots(), shape.UKnot, shape.UMultiplicity), row(shape.NbVKnots(), shape.VKnot, shape.VMultiplicity)],
                "net": [[exact(xyz(shape.Pole(i + 1, j + 1))) for j in range(m)] for i in range(n)],
                "weights": [[shape.Weight(i + 1, j + 1) for j in range(m)] for i in range(n)]}
    if not isinstance(shape, (Geom_BSplineCurve, Geom2d_BSplineCurve)):
        convert = Geom2dConvert if "2d" in type(shape).__name__ else GeomConvert
        shape = convert.CurveToBSplineCurve_s(shape)
        shape.SetNotPeriodic()
    n = shape.NbPoles()
    return {"degree": shape.Degree(), "knots": row(shape.NbKnots(), shape.Knot, shape.Multiplicity),
            "points": [exact(xyz(shape.Pole(k + 1))) for k in range(n)], "weights": [shape.Weight(k + 1) for k in range(n)]}


def exact(p):
    """Of splines these are round; of conics all digits are needed for them to be round."""
    return [float(f"{x:.16g}") for x in p]


def distance(shape, p):
    flat = len(p) == 2
    if isinstance(shape, Geom_Plane):
        return shape.Pln().Distance(gp_Pnt(*p))
    if "Surface" in type(shape).__name__:
        found = GeomAPI_ProjectPointOnSurf(gp_Pnt(*p), shape)
        return found.LowerDistance() if found.NbPoints() else math.inf
    found = (Geom2dAPI_ProjectPointOnCurve if flat else GeomAPI_ProjectPointOnCurve)((gp_Pnt2d if flat else gp_Pnt)(*p), shape)
    ends = min(numpy.linalg.norm(xyz(shape.Value(t)) - p) for t in (shape.FirstParameter(), shape.LastParameter()))
    return min(ends, found.LowerDistance()) if found.NbPoints() else ends


def once(points):
    known = []
    for p in points:
        if all(numpy.linalg.norm(p - q) > SAME for q in known):
            known.append(p)
    return sorted(map(list, known))


def places(curve, count=CHORDS):
    a, b = curve.FirstParameter(), curve.LastParameter()
    return numpy.array([xyz(curve.Value(a + (b - a) * k / count)) for k in range(count + 1)])


def crossings(a, b):
    """Of chords: how many. Those that touch are not among them."""
    p, q = places(a), places(b)
    x, y = p[:-1], numpy.diff(p, axis=0)
    count = 0
    for start, along in zip(q[:-1], numpy.diff(q, axis=0)):
        det = y[:, 0] * -along[1] + y[:, 1] * along[0]
        rhs = start - x
        with numpy.errstate(all="ignore"):
            s = (rhs[:, 0] * -along[1] + rhs[:, 1] * along[0]) / det
            t = (y[:, 0] * rhs[:, 1] - y[:, 1] * rhs[:, 0]) / det
        count += int(((s >= 0) & (s < 1) & (t >= 0) & (t < 1)).sum())
    return count


def case(name, a, b, found, touching=(), count=None):
    kept = once(p for p in found if max(distance(a, p), distance(b, p)) <= ON)
    off = len(once(found)) - len(kept)
    crossing = [p for p in kept if all(numpy.linalg.norm(numpy.subtract(p, q)) > 1e-3 for q in touching)]
    made = {"name": name, "a": written(a), "b": written(b), "points": told(crossing), "touching": told(list(map(list, touching)))}
    if off:
        made["off"] = off
    if count is not None:
        count = int(count)
        made["count"] = count + len(touching)
        made["lacks"] = count - len(crossing)
    print(name, len(kept), "off", off, "touching", len(touching), "count", count, "" if count in (None, len(crossing)) else "DIFFERS", file=sys.stderr)
    return made


def wave(n, seed, flat=True, size=1.0):
    rows = [[i + 0.4 * math.sin(3 * i + seed), 3 * math.sin(2.1 * i + seed), math.cos(1.3 * i + seed)] for i in range(n)]
    return [[size * x for x in p[:2 if flat else 3]] for p in rows]


def weights(n, seed):
    return [1 + 0.5 * math.sin(seed + 1.7 * i) for i in range(n)]


def across(points):
    return [[0.9 * y + 5.5, 1.1 * x - 6.0] for x, y in points]


def planar():
    cases = []
    meet = lambda a, b: [xyz(f.Point(k + 1)) for f in [Geom2dAPI_InterCurveCurve(a, b, 1e-9)] for k in range(f.NbPoints())]  # noqa: E731
    add = lambda name, a, b, touching=(), count=None: cases.append(  # noqa: E731
        case(name, a, b, meet(a, b) + meet(b, a), touching, crossings(a, b) if count is None else count))
    ring = lambda x, y, r: Geom2d_Circle(gp_Ax22d(gp_Pnt2d(x, y), gp_Dir2d(0.6, 0.8), gp_Dir2d(-0.8, 0.6)), r)  # noqa: E731
    oval = lambda x, y, r, s: Geom2d_Ellipse(gp_Ax22d(gp_Pnt2d(x, y), gp_Dir2d(0.8, 0.6), gp_Dir2d(-0.6, 0.8)), r, s)  # noqa: E731
    for p in range(1, 6):
        a = spline(wave(12, p), weights(12, p) if p > 1 else [1.0] * 12, p)
        for q in range(p, 6):
            add(f"degrees {p} and {q}", a, spline(across(wave(11, p + 0.3 * q)), weights(11, q) if q > 1 else [1.0] * 11, q))
        add(f"circle and degree {p}", ring(5, 0.3, 2.2), a)
        add(f"ellipse and degree {p}", oval(5.5, 0.1, 5.0, 1.1), a)
        add(f"arc and degree {p}", Geom2d_TrimmedCurve(ring(6, -4, 4.6), 0.1, 2.5), a)
    add("circles", ring(0, 0, 2), ring(1, 2, 1.5), count=2)
    add("circles apart", ring(0, 0, 2), ring(0.2, 0.1, 1), count=0)
    add("ellipses", oval(0, 0, 3, 1), oval(0.1, 0.2, 1.2, 1.1))
    add("circle and ellipse", oval(0.1, 0.05, 3, 1), ring(0, 0, 1.7), count=4)
    # Circles whose centres are 3-4-5 apart.
    add("circles touching", ring(0, 0, 2), ring(3, 4, 3), touching=[numpy.array([1.2, 1.6])], count=0)
    add("one circle in another", ring(0, 0, 7), ring(3, 4, 2), touching=[numpy.array([4.2, 5.6])], count=0)
    for p in range(2, 6):
        a = spline(wave(12, p), weights(12, p), p)
        t = 0.37 * a.LastParameter()
        point, along, bend = xyz(a.Value(t)), xyz(a.DN(t, 1)), xyz(a.DN(t, 2))
        speed = numpy.linalg.norm(along)
        normal = numpy.array([-along[1], along[0]]) / speed
        curvature = (along[0] * bend[1] - along[1] * bend[0]) / speed**3
        tangent = Geom2d_TrimmedCurve(Geom2d_Line(gp_Pnt2d(*point), gp_Dir2d(*along)), -1.0, 1.3)
        others = crossings(a, Geom2d_TrimmedCurve(Geom2d_Line(gp_Pnt2d(*(point + 1e-6 * normal * (-1 if curvature > 0 else 1))), gp_Dir2d(*along)), -1.0, 1.3))
        add(f"tangent of degree {p}", a, tangent, touching=[point], count=others)
        # On the other side of its tangent.
        center = point - normal * math.copysign(0.4, curvature)
        others = crossings(a, Geom2d_Circle(gp_Ax22d(gp_Pnt2d(*center), gp_Dir2d(1, 0), gp_Dir2d(0, 1)), 0.4 - 1e-6))
        add(f"circle touching degree {p}", a, ring(*center, 0.4), touching=[point], count=others)
    return cases


def space():
    cases = []
    for p in range(1, 6):
        for q in range(1, 6, 2):
            a, b = wave(9, p, False), [[y, x, 0.5 * z - 0.3 * x] for x, y, z in wave(8, q + 0.4, False)]
            wa, wb = ([1.0] * len(c) if d == 1 else weights(len(c), d) for c, d in ((a, p), (b, q)))
            s, t = 0.43, 0.61
            first, second = spline(a, wa, p), spline(b, wb, q)
            move = xyz(first.Value(s * first.LastParameter())) - xyz(second.Value(t * second.LastParameter()))
            second = spline([list(numpy.array(x) + move) for x in b], wb, q)
            meets = xyz(first.Value(s * first.LastParameter()))
            found = GeomAPI_ExtremaCurveCurve(first, second)
            points = []
            for k in range(found.NbExtrema()):
                x, y = gp_Pnt(), gp_Pnt()
                if found.Distance(k + 1) <= ON:
                    found.Points(k + 1, x, y)
                    points.append(xyz(x))
            made = case(f"degrees {p} and {q} in space", first, second, points)
            made["known"] = told(meets)
            cases.append(made)
    return cases


def surfaces():
    cases = []
    origin, z, x = numpy.array([0.3, -0.2, 0.5]), gp_Dir(0.2, -0.4, 1.0), gp_Dir(1.0, 0.5, 0.0)
    axes = gp_Ax3(gp_Pnt(*origin), z, x)
    z, x = xyz(axes.Direction()), xyz(axes.XDirection())
    frame = numpy.array([x, numpy.cross(z, x), z])
    at = lambda *p: origin + numpy.array(p) @ frame  # noqa: E731
    cut = lambda s, a, b: Geom_RectangularTrimmedSurface(s, a, b, False)  # noqa: E731
    round_ones = {
        "sphere": (Geom_SphericalSurface(axes, 2.0), lambda p: p[2] ** 2 + p[0] ** 2 + p[1] ** 2 - 4, None),
        "cylinder": (cut(Geom_CylindricalSurface(axes, 1.5), -4.0, 4.0), lambda p: math.hypot(p[0], p[1]) - 1.5, 4.0),
        "cone": (cut(Geom_ConicalSurface(axes, 0.4, 2.0), -3.5 / math.cos(0.4), 3.5 / math.cos(0.4)), lambda p: math.hypot(p[0], p[1]) - 2.0 - math.tan(0.4) * p[2], 3.5),
        "torus": (Geom_ToroidalSurface(axes, 3.0, 1.0), lambda p: math.hypot(math.hypot(p[0], p[1]) - 3, p[2]) - 1, None),
    }

    def segment(p, q):
        way = q - p
        return Geom_TrimmedCurve(Geom_Line(gp_Pnt(*p), gp_Dir(*way)), 0.0, float(numpy.linalg.norm(way)))

    def add(name, curve, surface, implicit=None, height=None, touching=()):
        found = GeomAPI_IntCS(curve, surface)
        points = [xyz(found.Point(k + 1)) for k in range(found.NbPoints())]
        count = None
        if implicit and not touching:
            local = (places(curve, 4 * CHORDS) - origin) @ frame.T
            sides = numpy.array([implicit(p) for p in local]) > 0
            changes = [k for k in range(len(sides) - 1) if sides[k] != sides[k + 1]]
            count = sum(height is None or abs(local[k][2]) < height for k in changes)
        elif touching:
            count = 0
        cases.append(case(name, curve, surface, points, touching, count))

    for kind, (surface, implicit, height) in round_ones.items():
        add(f"{kind} and a line", segment(at(-5, 0.3, -0.2), at(5, 0.5, 0.4)), surface, implicit, height)
        add(f"{kind} and a line askew", segment(at(-4, -3.0, -3.0), at(4.2, 3.1, 2.8)), surface, implicit, height)
        add(f"{kind} and a line beside it", segment(at(-5, 4.9, 0.2), at(5, 4.5, 0.4)), surface, implicit, height)
        axis = gp_Ax2(gp_Pnt(*at(0.7, 0.4, 0.1)), gp_Dir(*(at(0.4, 1.0, 0.3) - origin)))
        add(f"{kind} and a circle", Geom_Circle(axis, 2.9), surface, implicit, height)
        for degree in range(1, 6):
            points = [list(at(0.8 * a - 3.2, 0.8 * b, 1.2 * c)) for a, b, c in wave(9, degree, False)]
            add(f"{kind} and degree {degree}", spline(points, [1.0] * 9 if degree == 1 else weights(9, degree), degree), surface, implicit, height)
    # Tangents, square to the radius at a place.
    place = numpy.array([0.48, 0.6, 0.64])
    way = numpy.cross(place, [0.3, -1.0, 0.2])
    add("sphere and a tangent", segment(at(*(2 * place - way)), at(*(2 * place + 1.5 * way))), round_ones["sphere"][0], touching=[at(*(2 * place))])
    add("cylinder and a tangent", segment(at(0.9 - 0.8, 1.2 + 0.6, 0.1), at(0.9 + 1.6, 1.2 - 1.2, 1.6)), round_ones["cylinder"][0], touching=[at(0.9, 1.2, 0.6)])
    add("torus and a tangent outside", segment(at(2.4, 3.2, -1.0), at(2.4, 3.2, 1.4)), round_ones["torus"][0], touching=[at(2.4, 3.2, 0.0)])
    wa = lambda n, m, d, seed: [[1.0 if d == 1 else 1 + 0.3 * math.sin(seed + 1.7 * i + 0.9 * j) for j in range(m)] for i in range(n)]  # noqa: E731
    for p in range(1, 6):
        for q in (1, 3, 5):
            s = [[[float(i), float(j), 1.5 * math.sin(1.9 * i + p) * math.cos(1.3 * j - q)] for j in range(7)] for i in range(8)]
            c = [[0.7 * a + 0.5, 0.8 * b + 3.0, 0.8 * z] for a, b, z in wave(9, p + 0.2 * q, False)]
            add(f"surface of degrees {p}, {6 - p} and degree {q}", spline(c, [1.0] * 9 if q == 1 else weights(9, q), q), net(s, wa(8, 7, p, q), (p, 6 - p)))
    return cases


def planes():
    cases = []

    def add(name, curve, point, normal, touching=(), beside=0.0):
        """Where it touches, changes of side are counted `beside` it, where these two are not."""
        plane = Geom_Plane(gp_Pnt(*map(float, point)), gp_Dir(*map(float, normal)))
        found = GeomAPI_IntCS(curve, plane)
        sides = (places(curve) - point) @ xyz(plane.Axis().Direction()) > beside
        points = [xyz(found.Point(k + 1)) for k in range(found.NbPoints())]
        cases.append(case(name, curve, plane, points, touching, (sides[1:] != sides[:-1]).sum()))

    for p in range(1, 6):
        for seed in range(2):
            curve = spline(wave(11, p + 0.37 * seed, False), weights(11, seed) if p > 1 else [1.0] * 11, p)
            for normal, point in (([1.0, 0.3, -0.2], [4.1, 0.0, 0.0]), ([0.1, 1.0, 0.3], [0.0, 0.2, 0.0]), ([0.2, 0.1, 1.0], [3.0, 0.0, 0.1])):
                add(f"degree {p}, {seed} and a plane {normal}", curve, point, normal)
        if p > 1:
            # A plane along a tangent, from which the curve bends away: its normal is not the one of the curve.
            t = 0.37 * curve.LastParameter()
            point, along, bend = xyz(curve.Value(t)), xyz(curve.DN(t, 1)), xyz(curve.DN(t, 2))
            along /= numpy.linalg.norm(along)
            bend -= bend @ along * along
            normal = bend + 0.5 * numpy.cross(along, bend)
            add(f"degree {p} and a plane that touches", curve, point, normal, [point], -1e-6)
    axis = gp_Ax2(gp_Pnt(0.7, 0.4, 0.1), gp_Dir(0.4, 1.0, 0.3))
    for name, curve in (("circle", Geom_Circle(axis, 2.9)), ("ellipse", Geom_Ellipse(axis, 3.1, 1.2))):
        add(f"{name} and a plane", curve, [0.5, 0.3, 0.2], [0.3, -0.2, 1.0])
        add(f"{name} and a plane beside it", curve, [0.5, 0.3, 4.2], [0.1, -0.2, 1.0])
        arc = Geom_TrimmedCurve(curve, 0.3, 2.9)
        add(f"arc of {'a' if name == 'circle' else 'an'} {name} and a plane", arc, [0.5, 0.3, 0.2], [1.0, -0.2, 0.3])
        point, bend = xyz(curve.Value(0.8)), xyz(curve.DN(0.8, 2))
        along = xyz(curve.DN(0.8, 1))
        along /= numpy.linalg.norm(along)
        bend -= bend @ along * along
        add(f"{name} and a plane that touches", curve, point, bend + 0.5 * numpy.cross(along, bend), [point], -1e-6)
    return cases


def ruled(shape, point, normal):
    """The length of a section where the surface is straight in one direction: where the plane is between two rows of vertices follows from how far these are
    from it, along the other direction by chords."""
    s = written(shape)
    points, w, (p, q), (ku, kv) = numpy.array(s["net"]), numpy.array(s["weights"]), s["degrees"], s["knots"]
    if q != 1:
        points, w, p, ku = points.transpose(1, 0, 2), w.T, q, kv
    rows = BSpline(numpy.array(ku), numpy.concatenate([points * w[..., None], w[..., None]], -1), p)
    normal = numpy.array(normal) / numpy.linalg.norm(normal)
    plane, total = numpy.append(normal, -normal @ numpy.array(point)), 0.0
    for a, b in zip(sorted(set(ku)), sorted(set(ku))[1:]):
        u = numpy.linspace(a, b, 40001)
        u[-1] = b - 1e-13
        net = rows(u)
        for low, high in zip(net.transpose(1, 0, 2), net.transpose(1, 0, 2)[1:]):
            with numpy.errstate(all="ignore"):
                v = (low @ plane) / (low @ plane - high @ plane)
                x = low + (high - low) * v[:, None]
                long = numpy.linalg.norm(numpy.diff(x[:, :3] / x[:, 3:], axis=0), axis=1)
                first, last = numpy.minimum(v[1:], v[:-1]), numpy.maximum(v[1:], v[:-1])
                # Of those that leave the strip, what is in it.
                part = numpy.where(last > first, (numpy.minimum(last, 1) - numpy.maximum(first, 0)) / (last - first), (first >= 0) & (first <= 1))
            total += numpy.nansum(numpy.where((last - first < 0.5) & (part > 0), long * part, 0.0))
    return total


def sections():
    cases = []
    for p in range(1, 6):
        for q in (1, 3, 5):
            s = [[[float(i), float(j), 1.5 * math.sin(1.9 * i + p) * math.cos(1.3 * j - q)] for j in range(7)] for i in range(8)]
            w = [[1 + 0.3 * math.sin(p + 1.7 * i + 0.9 * j) for j in range(7)] for i in range(8)]
            surface = net(s, w, (p, q))
            point, normal = [3.7, 3.1, 0.1], [0.3, -0.2 + 0.1 * p, 1.0]
            cut = BRepAlgoAPI_Section(BRepBuilderAPI_MakeFace(surface, 1e-9).Face(), gp_Pln(gp_Pnt(*point), gp_Dir(*normal)), False)
            cut.Approximation(True)
            cut.Build()
            explorer, edges = TopExp_Explorer(cut.Shape(), Kind.TopAbs_EDGE), []
            while explorer.More():
                edges.append(BRepAdaptor_Curve(TopoDS.Edge(explorer.Current())))
                explorer.Next()
            length = sum(GCPnts_AbscissaPoint.Length_s(edge, 1e-12) for edge in edges)
            points = [xyz(edge.Value(edge.FirstParameter() + (edge.LastParameter() - edge.FirstParameter()) * k / 5)) for edge in edges[:4] for k in (1, 3)]
            print("section", p, q, length, len(edges), file=sys.stderr)
            made = {"theirs": told(length)} if 1 in (p, q) else {}
            length = ruled(surface, point, normal) if made else length
            points = [p for p in points if distance(surface, p) <= ON]
            cases.append({"name": f"section of degrees {p}, {q}", "b": written(surface), "point": point, "normal": told(normal), "length": told(length), "points": told(points), **made})
    return cases


golden = {name: made() for name, made in (("planar", planar), ("space", space), ("surfaces", surfaces), ("planes", planes), ("sections", sections))}
rows = [f" {json.dumps(name)}: [\n" + ",\n".join("  " + json.dumps(case, separators=(",", ":")) for case in cases) + "\n ]" for name, cases in golden.items()]
os.write(_out, ("{\n" + ",\n".join(rows) + "\n}\n").encode())
os._exit(0)
