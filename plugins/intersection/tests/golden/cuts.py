#!/usr/bin/env python3
"""Sections of solids by planes, by OpenCASCADE (the `cadquery-ocp` wheel of scripts/oracles.sh) and in closed form.

    $LOFTSMAN_ORACLES/python/bin/python plugins/intersection/tests/golden/cuts.py > plugins/intersection/tests/golden/cuts.json

`files` has the solids of tests/data/step, each as in its own coordinates (where an assembly places it is left out), in millimetres; `round` has
solids of revolution: a profile (radius, height) turned about an axis, with lids where it ends off that.

OpenCASCADE is asked twice: `BRepAlgoAPI_Section` makes edges, joined to wires and these to faces (one that is inside another is a hole); `BRepAlgoAPI_Common` of the solid and a large
planar face makes faces. What the two disagree on by more than AGREE is not told, and `left_out` says what either said. So is a number of loops: of
wires in the first, of the faces' boundaries in the second. Areas of both ways come from one integral over a face, which a third way judges: Green's
integral over the first way's edges, by Gauss's rule on PARTS of each, what is open between them closed by chords. An area that differs from it by more
than JUDGE is left out as well; the first `left_out` of the file counts what was. `unsure` is by how much lengths and areas of all ways differ. `points`
lie on its edges, which are known `within`. The box (`low`, `high`) is that of all edges, its sides found to rounding. `off` is by how much the edges
of the solid are off the surfaces of their faces, at most, where the plane passes them: so far a corner of the section is in doubt.

Of round solids length and area are integrals over the angle that the plane has on the parallel of each place of the profile, by Gauss's rule between
the places where that begins and ends, doubled until nothing changes; OpenCASCADE's own stand beside them in `theirs`.
"""
import collections
import functools
import json
import math
import os
import pathlib
import sys

_out = os.dup(1)
os.dup2(2, 1)

import numpy  # noqa: E402
from scipy.optimize import brentq, minimize_scalar  # noqa: E402

from OCP.BRep import BRep_Tool  # noqa: E402
from OCP.BRepAdaptor import BRepAdaptor_Curve  # noqa: E402
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Section  # noqa: E402
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace  # noqa: E402
from OCP.BRepGProp import BRepGProp  # noqa: E402
from OCP.BRepPrimAPI import (BRepPrimAPI_MakeCone, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakeSphere,  # noqa: E402
                             BRepPrimAPI_MakeTorus)
from OCP.GCPnts import GCPnts_AbscissaPoint  # noqa: E402
from OCP.GProp import GProp_GProps  # noqa: E402
from OCP.STEPControl import STEPControl_Reader  # noqa: E402
from OCP.ShapeAnalysis import ShapeAnalysis_FreeBounds, ShapeAnalysis_Surface  # noqa: E402
from OCP.TopAbs import TopAbs_ShapeEnum as Kind  # noqa: E402
from OCP.TopExp import TopExp_Explorer  # noqa: E402
from OCP.TopLoc import TopLoc_Location  # noqa: E402
from OCP.TopoDS import TopoDS  # noqa: E402
from OCP.collections import HSequence_TopoDS_Shape  # noqa: E402
from OCP.gp import gp_Ax2, gp_Dir, gp_Pln, gp_Pnt, gp_Vec  # noqa: E402

# Relative; by more than that its two ways are about different things.
AGREE = 3e-7
# By that an area may differ from Green's integral, and of each edge so many parts are integrated.
JUDGE, PARTS = 1e-6, 200
# No vertex is nearer to a plane than this part of the solid's size.
BESIDE = 1e-4
# Points told of a cut.
POINTS = 12
# The same shape as another file has, and one whose fillets take long to cut: cut by the first planes only.
FEWER = {"base_interface_AP203.STEP": 0, "NIST_MBE_PMI_11.stp": 3}
PLANES = [((1, 0, 0), 0.37), ((0, 1, 0), 0.53), ((0, 0, 1), 0.61), ((1, 2, -1.5), 0.44), ((-2, 0.7, 1), 0.57)]

gauss = functools.cache(numpy.polynomial.legendre.leggauss)


def parts(shape, kind):
    explorer, found = TopExp_Explorer(shape, kind), []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def xyz(p):
    return numpy.array([p.X(), p.Y(), p.Z()])


def mass(properties, shape):
    found = GProp_GProps()
    properties(shape, found, 1e-13)
    return found.Mass()


def length(edges):
    return sum(GCPnts_AbscissaPoint.Length_s(BRepAdaptor_Curve(edge), 1e-12) for edge in edges)


def along(edge, count):
    curve = BRepAdaptor_Curve(edge)
    low, high = curve.FirstParameter(), curve.LastParameter()
    return [xyz(curve.Value(low + (high - low) * k / (count - 1))) for k in range(count)]


def polygon(wire, across):
    """Its edges one behind the other, in the two coordinates that the plane's normal does not point along."""
    runs = [along(TopoDS.Edge(edge), 33) for edge in parts(wire, Kind.TopAbs_EDGE)]
    points = runs.pop(0)
    while runs:
        ends = [(min(numpy.linalg.norm(points[-1] - run[0]), numpy.linalg.norm(points[-1] - run[-1])), k) for k, run in enumerate(runs)]
        run = runs.pop(min(ends)[1])
        points += run if numpy.linalg.norm(points[-1] - run[0]) <= numpy.linalg.norm(points[-1] - run[-1]) else run[::-1]
    return [p[across] for p in points]


def green(wire, origin, normal):
    """The area inside it."""
    runs, (nodes, weights) = [], gauss(4)
    for edge in parts(wire, Kind.TopAbs_EDGE):
        curve = BRepAdaptor_Curve(TopoDS.Edge(edge))
        low, high = curve.FirstParameter(), curve.LastParameter()
        p, d, half = gp_Pnt(), gp_Vec(), 0.5 * (high - low) / PARTS
        places = low + half * (2 * numpy.arange(PARTS)[:, None] + 1 + nodes).ravel()
        values = numpy.empty((len(places), 2, 3))
        for k, t in enumerate(places):
            curve.D1(float(t), p, d)
            values[k] = xyz(p) - origin, xyz(d)
        sum_ = 0.5 * half * numpy.tile(weights, PARTS) @ (numpy.cross(values[:, 0], values[:, 1]) @ normal)
        runs.append((xyz(curve.Value(low)) - origin, xyz(curve.Value(high)) - origin, sum_))
    first, last, total = runs.pop(0)
    chord = lambda p, q: 0.5 * numpy.cross(p, q) @ normal  # noqa: E731
    while runs:
        k = min(range(len(runs)), key=lambda k: min(numpy.linalg.norm(last - end) for end in runs[k][:2]))
        start, end, sum_ = runs.pop(k)
        if numpy.linalg.norm(last - start) > numpy.linalg.norm(last - end):
            start, end, sum_ = end, start, -sum_
        total, last = total + chord(last, start) + sum_, end
    return abs(total + chord(last, first))


def off_faces(solid, point, normal):
    """How far edges are off their faces where the plane passes them, at most."""
    worst = 0.0
    for face in parts(solid, Kind.TopAbs_FACE):
        surface = ShapeAnalysis_Surface(BRep_Tool.Surface_s(TopoDS.Face(face)))
        for edge in parts(face, Kind.TopAbs_EDGE):
            if BRep_Tool.Degenerated_s(TopoDS.Edge(edge)):
                continue
            curve = BRepAdaptor_Curve(TopoDS.Edge(edge))
            low, high = curve.FirstParameter(), curve.LastParameter()
            height = lambda t: float(normal @ (xyz(curve.Value(t)) - point))  # noqa: E731
            places = [low + (high - low) * k / 64 for k in range(65)]
            heights = [height(t) for t in places]
            for k in range(64):
                if heights[k] * heights[k + 1] < 0:
                    p = curve.Value(brentq(height, places[k], places[k + 1], xtol=1e-14))
                    surface.ValueOfUV(p, 1e-9)
                    worst = max(worst, surface.Gap())
    return worst


def has(polygon, p):
    inside, q = False, polygon[-1]
    for r in polygon:
        if (q[1] > p[1]) != (r[1] > p[1]) and p[0] < q[0] + (r[0] - q[0]) * (p[1] - q[1]) / (r[1] - q[1]):
            inside = not inside
        q = r
    return inside


def by_wires(solid, plane):
    """Length, area, that by Green's integral, loops and edges of the section."""
    section = BRepAlgoAPI_Section(solid, plane, False)
    section.Approximation(True)  # chords otherwise, where no conic is it
    section.Build()
    edges, row = [TopoDS.Edge(edge) for edge in parts(section.Shape(), Kind.TopAbs_EDGE)], HSequence_TopoDS_Shape()
    for edge in edges:
        row.Append(edge)
    within = max((BRep_Tool.Tolerance_s(edge) for edge in edges), default=0.0)
    found = ShapeAnalysis_FreeBounds.ConnectEdgesToWires_s(row, 2 * within, False)
    wires = [TopoDS.Wire(found.Value(k + 1)) for k in range(found.Length())]
    normal = xyz(plane.Axis().Direction())
    across = [(numpy.argmax(abs(normal)) + k) % 3 for k in (1, 2)]
    polygons = [polygon(wire, across) for wire in wires]
    area, by_green = 0.0, 0.0
    for k, wire in enumerate(wires):
        depth = sum(has(other, polygons[k][0]) for j, other in enumerate(polygons) if j != k)
        face = BRepBuilderAPI_MakeFace(plane, wire, True)
        area += (-1) ** depth * abs(mass(BRepGProp.SurfaceProperties_s, face.Face())) if face.IsDone() else math.nan
        by_green += (-1) ** depth * green(wire, xyz(plane.Location()), normal)
    return length(edges), area, by_green, len(wires), edges, within


def by_faces(solid, plane, size):
    """Length, area and loops of what is common with a face."""
    face = BRepBuilderAPI_MakeFace(plane, -3 * size, 3 * size, -3 * size, 3 * size).Face()
    common = BRepAlgoAPI_Common(solid, face).Shape()
    faces = parts(common, Kind.TopAbs_FACE)
    wires = [wire for face in faces for wire in parts(face, Kind.TopAbs_WIRE)]
    edges = [TopoDS.Edge(edge) for wire in wires for edge in parts(wire, Kind.TopAbs_EDGE)]
    return length(edges), sum(mass(BRepGProp.SurfaceProperties_s, face) for face in faces), len(wires)


def box(edges):
    low, high = numpy.full(3, math.inf), numpy.full(3, -math.inf)
    for edge in edges:
        curve = BRepAdaptor_Curve(edge)
        a, b = curve.FirstParameter(), curve.LastParameter()
        places = [a + (b - a) * k / 64 for k in range(65)]
        values = numpy.array([xyz(curve.Value(t)) for t in places])
        for axis in range(3):
            for sign in (1, -1):
                row = sign * values[:, axis]
                k = int(numpy.argmin(row))
                f = lambda t: sign * xyz(curve.Value(t))[axis]  # noqa: E731
                around = (places[max(k - 1, 0)], places[min(k + 1, 64)])
                best = min(row[k], minimize_scalar(f, bounds=around, method="bounded", options={"xatol": 1e-10 * (b - a)}).fun)
                if sign > 0:
                    low[axis] = min(low[axis], best)
                else:
                    high[axis] = max(high[axis], -best)
    return low, high


def told(x):
    return [told(y) for y in x] if hasattr(x, "__len__") else float(f"{x:.12g}")


def cut(solid, point, normal, size):
    plane = gp_Pln(gp_Pnt(*point), gp_Dir(*normal))
    l, a, g, loops, edges, within = by_wires(solid, plane)
    m, b, boundaries = by_faces(solid, plane, size)
    case = {"point": told(point), "normal": list(normal)}
    left_out = {}

    def agreed(name, x, y, same):
        if same:
            case[name] = told(x) if isinstance(x, float) else x
        else:
            left_out[name] = f"{x:.9g} by wires, {y:.9g} by faces"

    agreed("loops", loops, boundaries, loops == boundaries)
    agreed("length", l, m, abs(l - m) <= AGREE * m)
    agreed("area", a, b, abs(a - b) <= AGREE * b)
    if "area" in case and max(abs(a - g), abs(b - g)) > JUDGE * g:
        del case["area"]
        left_out["area"] = f"{a:.9g} by integrals over faces, {g:.9g} by Green's integral over the edges"
    differ = lambda *values: float(f"{max(values) - min(values):.2g}")  # noqa: E731
    case["unsure"] = [differ(l, m) if "length" in case else None, differ(a, b, g) if "area" in case else None]
    n = numpy.array(normal, float)
    case["off"] = float(f"{off_faces(solid, numpy.array(point), n / numpy.linalg.norm(n)):.2g}")
    case["within"] = float(f"{within:.3g}")
    low, high = box(edges)
    case["low"], case["high"] = told(low), told(high)
    # Spread over the edges, not at their ends.
    places = [(k, edges[k]) for k in range(len(edges))][::max(1, len(edges) // POINTS)][:POINTS]
    each = max(1, POINTS // max(1, len(places)))
    case["points"] = [told(p) for k, edge in places for p in along(edge, 2 * each + 1)[1::2]]
    if left_out:
        case["left_out"] = left_out
    return case


def beside(points, point, normal, size):
    """Moves a plane until no vertex is near."""
    normal = numpy.array(normal, float)
    normal /= numpy.linalg.norm(normal)
    step = 0
    while any(abs(normal @ (q - point)) <= BESIDE * size for q in points):
        step += 1
        point = point + 0.0037 * size * normal
    return point


def solids_of(path):
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    known = []
    for solid in parts(reader.OneShape(), Kind.TopAbs_SOLID):
        own = solid.Located(TopLoc_Location())
        if not any(own.IsPartner(other) for other in known):
            known.append(own)
    return known


def of_file(path):
    solids = []
    for solid in solids_of(path) if FEWER.get(path.name) != 0 else []:
        edges = [TopoDS.Edge(edge) for edge in parts(solid, Kind.TopAbs_EDGE)]
        low, high = box([edge for edge in edges if not BRep_Tool.Degenerated_s(edge)])
        size = float(numpy.linalg.norm(high - low))
        vertices = [xyz(BRep_Tool.Pnt_s(TopoDS.Vertex(vertex))) for vertex in parts(solid, Kind.TopAbs_VERTEX)]
        cuts = []
        for normal, share in PLANES[:FEWER.get(path.name)]:
            point = beside(vertices, low + share * (high - low), normal, size)
            cuts.append(cut(solid, point, normal, size))
            print(path.name, len(solids), normal, {k: cuts[-1].get(k) for k in ("loops", "length", "area", "unsure", "within", "off", "left_out")}, file=sys.stderr)
        volume = mass(BRepGProp.VolumeProperties_s, solid)
        solids.append({"volume": told(volume), "low": told(low), "high": told(high), "cuts": cuts})
    return solids


def profiles(kind, sizes):
    """Radius and height of a profile, each with its derivative, over an interval; whether it ends in lids."""
    if kind == "torus":
        major, minor = sizes
        return (lambda t: (major + minor * numpy.cos(t), minor * numpy.sin(t), -minor * numpy.sin(t), minor * numpy.cos(t))), 0.0, 2 * math.pi
    if kind == "sphere":
        return (lambda t: (sizes[0] * numpy.cos(t), sizes[0] * numpy.sin(t), -sizes[0] * numpy.sin(t), sizes[0] * numpy.cos(t))), -math.pi / 2, math.pi / 2
    bottom, top, height = sizes[0], sizes[-2], sizes[-1]
    slope = (top - bottom) / height
    return (lambda t: (bottom + slope * t, t, slope + 0.0 * t, 1.0 + 0.0 * t)), 0.0, height


def exact(kind, sizes, tilt, off):
    """Length, area and loops of the section by a plane whose normal is askew to the axis by `tilt`, `off` from the origin."""
    profile, first, last = profiles(kind, sizes)
    sine, cosine = math.sin(tilt), math.cos(tilt)

    def cosine_of_angle(t):
        r, z, *_ = profile(t)
        return (off - z * cosine) / (r * sine)

    # The angle is acos of that: it begins and ends where that is ±1. A turn of a torus starts where it has no angle, if there is such a place.
    excess = lambda t: abs(cosine_of_angle(t)) - 1  # noqa: E731
    count = 4001
    places = first + (last - first) * (numpy.arange(count) + 0.5) / count
    if kind == "torus":
        start = places[int(numpy.argmax([excess(t) for t in places]))]
        places = start + 2 * math.pi * numpy.arange(count + 1) / count
        first, last = places[0], places[-1]
    else:
        tiny = 1e-9 if kind == "sphere" else 0.0
        places = numpy.concatenate([[first + tiny], places, [last - tiny]])
    values = numpy.array([excess(t) for t in places])
    ends = [(places[0], False)] if values[0] < 0 else []
    for k in range(len(places) - 1):
        if values[k] * values[k + 1] < 0:
            ends.append((brentq(excess, places[k], places[k + 1], xtol=1e-15, rtol=1e-15), True))
    if values[-1] < 0:
        ends.append((places[-1], False))
    length, area, loops = 0.0, 0.0, 0
    for (a, closes), (b, opens) in zip(ends[::2], ends[1::2]):
        whole = kind == "torus" and not closes and not opens
        loops += 2 if whole else 1
        before = None
        for n in (64, 128, 256, 512, 1024, 2048):
            x, w = gauss(n)
            # The sine takes the roots at the ends away.
            t = 0.5 * (a + b) + 0.5 * (b - a) * numpy.sin(0.5 * math.pi * x)
            w = w * 0.5 * (b - a) * 0.5 * math.pi * numpy.cos(0.5 * math.pi * x)
            r, z, dr, dz = profile(t)
            c = numpy.clip((off - z * cosine) / (r * sine), -1, 1)
            s = numpy.sqrt(1 - c * c)
            # x = r c and height turned into the plane; y = r s: two halves.
            dx = -dz * cosine / sine
            dy = dr * s - c * (dx - dr * c) / s
            found = (2 * w @ numpy.sqrt(dx**2 + dz**2 + dy**2), 2 * w @ (r * s * (dx * cosine - dz * sine)))
            if before and abs(found[0] - before[0]) <= 1e-13 * found[0] and abs(found[1] - before[1]) <= 1e-13 * abs(found[1]):
                break
            before = found
        length, area = length + found[0], area + found[1]
        if not whole:
            for end, on in ((a, closes), (b, opens)):
                if not on:
                    r = profile(end)[0]
                    length += 2 * r * math.sqrt(1 - cosine_of_angle(end) ** 2)
    return length, abs(area), loops


def turned():
    origin, axis, x = [0.3, -0.2, 0.5], [0.2, -0.4, 1.0], [1.0, 0.5, 0.0]
    axes = gp_Ax2(gp_Pnt(*origin), gp_Dir(*axis), gp_Dir(*x))
    z, x_way = xyz(axes.Direction()), xyz(axes.XDirection())
    y_way = numpy.cross(z, x_way)
    cases = []
    for kind, sizes, makes, planes in [
        ("cylinder", [1.5, 4.0], BRepPrimAPI_MakeCylinder, [(0.3, 2.0), (0.7, 1.1), (1.2, 0.4), (1.5, 0.9), (1.0, 2.0), (0.02, 1.0)]),
        ("cone", [2.0, 0.5, 3.0], BRepPrimAPI_MakeCone, [(0.3, 1.2), (0.9, 0.5), (1.1, -0.6), (1.3, 1.0), (1.5, 0.2), (0.05, 2.0)]),
        ("sphere", [2.5], BRepPrimAPI_MakeSphere, [(0.4, 0.0), (0.4, 1.9), (1.2, -1.0), (1.57, 2.3), (0.9, 2.49)]),
        ("torus", [3.0, 1.0], BRepPrimAPI_MakeTorus, [(0.2, 0.1), (0.2, 0.9), (0.9, 0.5), (1.2, 1.9), (1.5, 0.3), (1.5, 2.5), (1.5, 3.6), (0.6, 1.7), (0.05, -0.6)]),
    ]:
        made = [*sizes[:1], *sizes] if kind == "cylinder" else sizes
        solid = makes(axes, *sizes).Shape()
        for number, (tilt, off) in enumerate(planes):
            l, a, loops = exact(kind, made, tilt, off)
            turn = 0.7 + 1.3 * number
            normal = math.sin(tilt) * (math.cos(turn) * x_way + math.sin(turn) * y_way) + math.cos(tilt) * z
            normal = numpy.array(told(normal))
            point = numpy.array(origin) + off * normal
            theirs = cut(solid, point, list(map(float, normal)), 10.0)
            case = {"kind": kind, "sizes": sizes, "origin": origin, "axis": axis, "x": x, **theirs}
            # The closed form is sure.
            del case["unsure"], case["off"]
            case["theirs"] = [theirs.get("length"), theirs.get("area")]
            print(kind, tilt, off, (l, a, loops), theirs.get("length"), theirs.get("area"), theirs.get("loops"), theirs.get("left_out"), file=sys.stderr)
            case["length"], case["area"], case["loops"] = told(l), told(a), loops
            cases.append(case)
    return cases


if __name__ == "__main__":
    folder = pathlib.Path(__file__).parents[4] / "tests" / "data" / "step"
    only = sys.argv[1:]
    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in (".stp", ".step") and (not only or path.name in only))
    files = {path.name: of_file(path) for path in paths} if only != ["round"] else {}
    files = {name: solids for name, solids in files.items() if solids}
    rows = [f'  {json.dumps(name)}: [\n' + ",\n".join("   " + json.dumps(solid, separators=(",", ":")) for solid in solids) + "\n  ]" for name, solids in files.items()]
    rounds = ",\n".join("  " + json.dumps(case, separators=(",", ":")) for case in turned())
    left_out = collections.Counter(name for solids in files.values() for solid in solids for case in solid["cuts"] for name in case.get("left_out", ()))
    os.write(_out, ('{\n "left_out": ' + json.dumps(dict(sorted(left_out.items()))) + ',\n "files": {\n' + ",\n".join(rows) + '\n },\n "round": [\n' + rounds + "\n ]\n}\n").encode())
