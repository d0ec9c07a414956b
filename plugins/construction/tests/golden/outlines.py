#!/usr/bin/env python3
"""Offsets of planar wires out of lines, arcs and splines by OpenCASCADE: `python outlines.py > outlines.json`.

It takes the Python of scripts/oracles.sh with shapely beside it (`pip install --target FOLDER shapely==2.1.2`, and FOLDER in PYTHONPATH).

A wire is a list of pieces one behind the other: `line` from a point to a point, `arc` from a point through one to another, `spline` of a degree with
vertices, weights and knots. `away` is outwards of closed ones, to the right of open ones where positive. OpenCASCADE's `BRepOffsetAPI_MakeOffset` moves it,
with `GeomAbs_Arc` for round and `GeomAbs_Intersection` for sharp corners, and is held against what becomes of many chords: closed ones by shapely's
`buffer` or, like open ones, by keeping of all moved places those that nothing is nearer to. Where it refuses, or what it gives has another number of loops, length or
area than theirs, or places at another distance, the case is left out, whichever of the two is wrong, and `left_out` counts it. A loop inside another is a hole.

Sharp corners of lines and arcs have another judge, the closed form of `lines_and_arcs.py`, to 1e-9: of closed wires OpenCASCADE's figures are kept where it agrees; where it refuses, or prolongs arcs as
arcs, which is another convention, those of the closed form are (`"by": "closed form"`), if a union of polygons has the same area; of open ones they always are. `closed_form` counts all these.
"""
import collections
import json
import math
import os
import sys

_out = os.dup(1)
os.dup2(2, 1)

import numpy  # noqa: E402
import shapely  # noqa: E402
from scipy.optimize import minimize_scalar  # noqa: E402

import lines_and_arcs  # noqa: E402

from OCP.BRepAdaptor import BRepAdaptor_Curve  # noqa: E402
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire  # noqa: E402
from OCP.BRepGProp import BRepGProp  # noqa: E402
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakeOffset  # noqa: E402
from OCP.GC import GC_MakeArcOfCircle  # noqa: E402
from OCP.GCPnts import GCPnts_AbscissaPoint  # noqa: E402
from OCP.GProp import GProp_GProps  # noqa: E402
from OCP.Geom import Geom_BSplineCurve  # noqa: E402
from OCP.GeomAbs import GeomAbs_Arc, GeomAbs_Intersection  # noqa: E402
from OCP.TopAbs import TopAbs_ShapeEnum as Kind  # noqa: E402
from OCP.TopExp import TopExp_Explorer  # noqa: E402
from OCP.TopoDS import TopoDS  # noqa: E402
from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int  # noqa: E402
from OCP.gp import gp_Pln, gp_Pnt, gp_Dir  # noqa: E402

# For a curved piece: where lengths and areas are compared, and where distances are.
CHORDS, FINE = 1500, 30000
POINTS = 8


def parts(shape, kind):
    explorer, found = TopExp_Explorer(shape, kind), []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def told(x):
    if isinstance(x, (dict, str, int)) and not isinstance(x, bool):
        return {k: told(v) for k, v in x.items()} if isinstance(x, dict) else x
    return [told(y) for y in x] if hasattr(x, "__len__") else float(f"{x:.12g}")


# The wires. Round numbers, and what is made of them is rounded before it is used.

def line(*points):
    return [{"line": [list(map(float, a)), list(map(float, b))]} for a, b in zip(points, points[1:])]


def arc(center, radius, first, last):
    """By angles in degrees."""
    at = lambda angle: told([center[0] + radius * math.cos(math.radians(angle)), center[1] + radius * math.sin(math.radians(angle))])  # noqa: E731
    return [{"arc": [at(first), at(0.5 * (first + last)), at(last)]}]


def spline(degree, points, weights=None):
    n = len(points)
    inner = list(range(1, n - degree))
    knots = [0.0] * (degree + 1) + [float(k) for k in inner] + [float(n - degree)] * (degree + 1)
    return [{"degree": degree, "spline": told(points), "weights": told(weights or [1.0] * n), "knots": knots}]


def ring(degree, points, weights=None):
    """One that goes on smoothly where it ends."""
    middle = [0.5 * (a + b) for a, b in zip(points[0], points[-1])]
    weights = [weights[0]] + weights + [weights[-1]] if weights else None
    return spline(degree, [middle, *points, middle], weights)


def closed(*points):
    return line(*points, points[0])


def polar(count, radius):
    return [[radius(k) * math.cos(2 * math.pi * k / count), radius(k) * math.sin(2 * math.pi * k / count)] for k in range(count)]


def gear(teeth, inner, outer, narrow):
    """Lines up and down, arcs along tips and grounds."""
    pieces, step = [], 360.0 / teeth
    at = lambda r, angle: told([r * math.cos(math.radians(angle)), r * math.sin(math.radians(angle))])  # noqa: E731
    for k in range(teeth):
        a = k * step
        pieces += arc([0, 0], inner, a, a + 0.4 * step)
        up, down = a + (0.4 + narrow) * step, a + (1.0 - narrow) * step
        pieces += line(at(inner, a + 0.4 * step), at(outer, up))
        pieces += arc([0, 0], outer, up, down)
        pieces += line(at(outer, down), at(inner, (a + step) % 360 if k < teeth - 1 else 0))
    return pieces


def wires():
    told_wires = {
        "L": closed([0, 0], [5, 0], [5, 2], [2, 2], [2, 7], [0, 7]),
        "T": closed([2, 0], [4, 0], [4, 6], [6, 6], [6, 8], [0, 8], [0, 6], [2, 6]),
        "E": closed([0, 0], [5, 0], [5, 1.6], [2, 1.6], [2, 3], [4, 3], [4, 4.6], [2, 4.6], [2, 6.4], [5, 6.4], [5, 8], [0, 8]),
        "M": closed([0, 0], [2, 0], [2, 5], [4, 2.5], [6, 5], [6, 0], [8, 0], [8, 8], [6.5, 8], [4, 5], [1.5, 8], [0, 8]),
        "Z": closed([0, 0], [6, 0], [6, 1.5], [2.5, 1.5], [6, 6.5], [6, 8], [0, 8], [0, 6.5], [3.5, 6.5], [0, 1.5]),
        "star": closed(*polar(14, lambda k: 5.0 if k % 2 == 0 else 3.1)),
        "comb": closed([0, 0], [13, 0], *[q for k in range(6, -1, -1) for q in ([2.0 * k + 1.0, 5.0 + 0.3 * k], [2.0 * k + 0.2, 5.2], [2.0 * k, 1.5])][:-1], ),
        "saw": closed([0, 0], [12, 0], *[q for k in range(11, -1, -1) for q in ([k + 0.9, 3.0], [k + 0.1, 2.0])]),
        "U": line([0, 8], [0, 3]) + arc([3, 3], 3, 180, 360) + line([6, 3], [6, 8], [4.5, 8], [4.5, 3]) + arc([3, 3], 1.5, 0, -180) + line([1.5, 3], [1.5, 8], [0, 8]),
        "C": arc([0, 0], 4, 40, 320) + line(told([4 * math.cos(math.radians(320)), 4 * math.sin(math.radians(320))]), told([2.4 * math.cos(math.radians(320)), 2.4 * math.sin(math.radians(320))]))
        + arc([0, 0], 2.4, 320, 40) + line(told([2.4 * math.cos(math.radians(40)), 2.4 * math.sin(math.radians(40))]), told([4 * math.cos(math.radians(40)), 4 * math.sin(math.radians(40))])),
        "D": line([0, 0], [2, 0]) + arc([2, 3.5], 3.5, -90, 90) + line([2, 7], [0, 7], [0, 0]),
        "slot": arc([0, 0], 1.5, 90, 270) + line([0, -1.5], [7, -1.5]) + arc([7, 0], 1.5, -90, 90) + line([7, 1.5], [0, 1.5]),
        "keyhole": arc([0, 0], 2.5, -60, 240) + line(told([2.5 * math.cos(math.radians(240)), 2.5 * math.sin(math.radians(240))]), [-1.6, -6], [1.6, -6], told([2.5 * math.cos(math.radians(300)), 2.5 * math.sin(math.radians(300))])),
        "dumbbell": arc([0, 0], 2, 30, 330) + line(told([2 * math.cos(math.radians(330)), -1.0]), told([8 - 2 * math.cos(math.radians(30)), -1.0])) + arc([8, 0], 2, 210, 510) + line(told([8 - 2 * math.cos(math.radians(30)), 1.0]), told([2 * math.cos(math.radians(30)), 1.0])),
        "clover": arc([2, 0], 2, -90, 90) + arc([0, 2], 2, 0, 180) + arc([-2, 0], 2, 90, 270) + arc([0, -2], 2, 180, 360),
        "gear 6": gear(6, 3.0, 4.5, 0.1),
        "gear 12": gear(12, 5.0, 6.2, 0.12),
        "gear 20": gear(20, 8.0, 9.2, 0.15),
        "cog": closed(*[q for k in range(16) for q in ([6 * math.cos(k * math.pi / 8), 6 * math.sin(k * math.pi / 8)], [6 * math.cos((k + 0.45) * math.pi / 8), 6 * math.sin((k + 0.45) * math.pi / 8)],
                                                       [7.3 * math.cos((k + 0.5) * math.pi / 8), 7.3 * math.sin((k + 0.5) * math.pi / 8)], [7.3 * math.cos((k + 0.9) * math.pi / 8), 7.3 * math.sin((k + 0.9) * math.pi / 8)])]),
        "bow": line([0, 0], [6, 0]) + spline(3, [[6, 0], [6.5, 2.5], [4, 5], [2, 4], [-1, 3], [0, 0]]),
        "leaf": spline(2, [[0, 0], [3, -2], [6, -1], [8, 2]]) + spline(3, [[8, 2], [5, 4], [2, 4], [0, 0]]),
        "shield": line([0, 6], [0, 3]) + spline(3, [[0, 3], [0, 0], [2, -2], [4, -3]]) + spline(3, [[4, -3], [6, -2], [8, 0], [8, 3]]) + line([8, 3], [8, 6]) + arc([4, -1], math.hypot(4, 7), math.degrees(math.atan2(7, 4)), math.degrees(math.atan2(7, -4))),
    }
    for degree in (2, 3, 4, 5):
        told_wires[f"blob {degree}"] = ring(degree, polar(9, lambda k: 4 + 1.2 * math.sin(2.3 * k + degree)))
        told_wires[f"bean {degree}"] = ring(degree, [[0, -3], [4, -3], [6, 0], [5, 4], [2.5, 1.5], [0, 1], [-2.5, 1.5], [-5, 4], [-6, 0], [-4, -3]],
                                            [1 + 0.4 * math.sin(1.7 * k) for k in range(10)])
        told_wires[f"wave {degree}"] = spline(degree, [[1.2 * k, 2.0 * math.sin(1.9 * k + degree)] for k in range(9)], [1 + 0.3 * math.sin(degree + 1.1 * k) for k in range(9)])
        told_wires[f"hook {degree}"] = spline(degree, [[0, 0], [3, 0.3], [6, 0.2], [8, 2], [7, 4], [5, 4.5], [3.5, 3.5], [4, 2.4]])
    told_wires["path 1"] = line([0, 0], [4, 0], [4, 3], [8, 3], [8, 1], [11, 2])
    told_wires["path 2"] = line([0, 0], [3, 0]) + arc([3, 2], 2, -90, 0) + line([5, 2], [5, 4]) + arc([7, 4], 2, 180, 90) + line([7, 6], [10, 6])
    told_wires["path 3"] = line([0, 0], [3, 2]) + spline(3, [[3, 2], [4, 4], [6, 4], [7, 1], [9, 1]]) + line([9, 1], [11, 4])
    told_wires["zigzag"] = line(*[[1.0 * k, 2.0 * (k % 2)] for k in range(10)])
    for pieces in told_wires.values():
        pieces[:] = told(pieces)
        # Where two pieces meet is one point.
        ends = lambda piece: next(piece[key] for key in ("line", "arc", "spline") if key in piece)  # noqa: E731
        for before, piece in zip(pieces, pieces[1:]):
            ends(piece)[0] = list(ends(before)[-1])
        if math.dist(ends(pieces[0])[0], ends(pieces[-1])[-1]) < 1e-9:
            ends(pieces[-1])[-1] = list(ends(pieces[0])[0])
    return told_wires


def edge(piece):
    point = lambda p: gp_Pnt(p[0], p[1], 0)  # noqa: E731
    if "line" in piece:
        return BRepBuilderAPI_MakeEdge(*map(point, piece["line"])).Edge()
    if "arc" in piece:
        return BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(*map(point, piece["arc"])).Value()).Edge()
    n, values = len(piece["spline"]), sorted(set(piece["knots"]))
    points, weights = Array1_gp_Pnt(1, n), Array1_double(1, n)
    for k in range(n):
        points.SetValue(k + 1, point(piece["spline"][k]))
        weights.SetValue(k + 1, piece["weights"][k])
    knots, times = Array1_double(1, len(values)), Array1_int(1, len(values))
    for k, value in enumerate(values):
        knots.SetValue(k + 1, value)
        times.SetValue(k + 1, piece["knots"].count(value))
    return BRepBuilderAPI_MakeEdge(Geom_BSplineCurve(points, weights, knots, times, piece["degree"], False)).Edge()


def along(edge, count):
    curve = BRepAdaptor_Curve(edge)
    low, high = curve.FirstParameter(), curve.LastParameter()
    values = (curve.Value(low + (high - low) * k / (count - 1)) for k in range(count))
    return [[p.X(), p.Y()] for p in values]


def chords(pieces, count):
    points = []
    for piece in pieces:
        row = piece["line"] if "line" in piece else along(edge(piece), count + 1)
        points += row[1 if points else 0:]
    return numpy.array(points)


def distances_from(points):
    """How far places are from chords."""
    pieces = shapely.linestrings(numpy.stack([points[:-1], points[1:]], axis=1))
    tree = shapely.STRtree(pieces)

    def distances(places):
        places = shapely.points(places)
        return shapely.distance(places, pieces[tree.nearest(places)])

    return distances


def box(edges):
    low, high = numpy.full(2, math.inf), numpy.full(2, -math.inf)
    for one in edges:
        curve = BRepAdaptor_Curve(one)
        a, b = curve.FirstParameter(), curve.LastParameter()
        places = [a + (b - a) * k / 64 for k in range(65)]
        values = numpy.array(along(one, 65))
        for axis in range(2):
            for sign in (1, -1):
                row = sign * values[:, axis]
                k = int(numpy.argmin(row))
                f = lambda t: sign * (curve.Value(t).Y() if axis else curve.Value(t).X())  # noqa: E731
                around = (places[max(k - 1, 0)], places[min(k + 1, 64)])
                best = min(row[k], minimize_scalar(f, bounds=around, method="bounded", options={"xatol": 1e-10 * (b - a)}).fun)
                if sign > 0:
                    low[axis] = min(low[axis], best)
                else:
                    high[axis] = max(high[axis], -best)
    return low, high


def moved(wire, away, join, is_closed):
    """Edges, wires; nothing where OpenCASCADE gives nothing."""
    maker = BRepOffsetAPI_MakeOffset(wire, join, not is_closed)
    try:
        maker.Perform(away)
        shape = maker.Shape()
    except Exception:  # it throws what it likes
        return None
    found = [TopoDS.Wire(one) for one in parts(shape, Kind.TopAbs_WIRE)]
    return ([TopoDS.Edge(one) for one in parts(shape, Kind.TopAbs_EDGE)], found) if found else None


def area(wires):
    plane = gp_Pln(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))
    rings, own = [], []
    for wire in wires:
        face, mass = BRepBuilderAPI_MakeFace(plane, wire, True), GProp_GProps()
        if not face.IsDone():
            return None
        BRepGProp.SurfaceProperties_s(face.Face(), mass, 1e-13)
        own.append(abs(mass.Mass()))
        runs = [along(TopoDS.Edge(one), 33) for one in parts(wire, Kind.TopAbs_EDGE)]
        points = runs.pop(0)
        while runs:
            run = min(runs, key=lambda run: min(math.dist(points[-1], run[0]), math.dist(points[-1], run[-1])))
            runs.remove(run)
            points += run if math.dist(points[-1], run[0]) <= math.dist(points[-1], run[-1]) else run[::-1]
        rings.append(shapely.Polygon(points))
    depth = [sum(other.contains(shapely.Point(ring.exterior.coords[0])) for other in rings if other is not ring) for ring in rings]
    return sum((-1) ** d * a for d, a in zip(depth, own))


def by_buffer(points, away, sharp):
    """Loops, length, area of a closed wire."""
    found = shapely.Polygon(points).buffer(away, quad_segs=400, join_style="mitre" if sharp else "round", mitre_limit=4.0)
    return sum(1 + len(one.interiors) for one in getattr(found, "geoms", [found]) if not one.is_empty), found.length, found.area


def by_places(points, distances, away):
    """Pieces or loops, and length, of what is to the right of a wire, nothing nearer."""
    is_closed = math.dist(points[0], points[-1]) < 1e-9
    ahead = numpy.diff(points, axis=0)
    ahead /= numpy.linalg.norm(ahead, axis=1)[:, None]
    angle = numpy.unwrap(numpy.arctan2(ahead[:, 1], ahead[:, 0]))
    turns = numpy.diff(angle)
    at = lambda p, a: p + away * numpy.stack([numpy.sin(a), -numpy.cos(a)], axis=-1)  # noqa: E731
    corners = [0, *(numpy.flatnonzero(abs(turns) > 0.05) + 1), len(ahead)]
    # The last turn of a closed one leads to where it starts.
    turns = numpy.append(turns, math.remainder(angle[0] - angle[-1], 2 * math.pi) if is_closed else 0.0)
    rows = []
    for first, last in zip(corners, corners[1:]):
        # Between corners along the mean of the directions at each vertex.
        own = angle[first:last]
        mean = numpy.concatenate([own[:1], 0.5 * (own[1:] + own[:-1]), own[-1:]])
        for k in range(last - first):
            p, q = at(points[first + k], mean[k]), at(points[first + k + 1], mean[k + 1])
            n = max(1, int(math.dist(p, q) / 2e-3))
            rows.append(p + (q - p) * (numpy.arange(n + 1) / n)[:, None])
        # Around corners, on the side where there is room.
        if turns[last - 1] * away > 0:
            n = max(2, int(abs(turns[last - 1]) * abs(away) / 2e-3))
            rows.append(at(points[last], angle[last - 1] + turns[last - 1] * numpy.arange(n + 1) / n))
    places = numpy.concatenate(rows)
    near = distances(places) >= abs(away) * (1 - 1e-5)
    if is_closed and not near.all():
        start = int(numpy.argmin(near))
        places, near = numpy.roll(places, -start, axis=0), numpy.roll(near, -start)
    both = near[1:] & near[:-1]
    length = numpy.linalg.norm(numpy.diff(places, axis=0), axis=1)[both].sum()
    starts = numpy.flatnonzero(near & ~numpy.concatenate([[False], near[:-1]]))
    ends = numpy.flatnonzero(near & ~numpy.concatenate([near[1:], [False]]))
    runs = [(a, b) for a, b in zip(starts, ends) if b > a]
    if not is_closed or len(runs) < 2:
        return (len(runs) and 1 + sum(math.dist(places[b], places[a]) > 0.02 for (_, b), (a, _) in zip(runs, runs[1:]))), length
    # Where one ends another starts.
    follows = [min(range(len(runs)), key=lambda j: math.dist(places[b], places[runs[j][0]])) for _, b in runs]
    seen, loops = set(), 0
    for k in range(len(runs)):
        loops += k not in seen
        while k not in seen:
            seen.add(k)
            k = follows[k]
    return loops, length


def is_needle(points, away):
    """Whether a corner is too sharp to be prolonged: the tip would be further than four distances away."""
    ahead = numpy.diff(numpy.concatenate([points, points[1:2]]), axis=0)
    angle = numpy.arctan2(ahead[:, 1], ahead[:, 0])
    turns = [math.remainder(x, 2 * math.pi) for x in numpy.diff(angle)]
    way = 1 if shapely.LinearRing(points).is_ccw else -1
    return any(turn * way * away > 0 and math.cos(0.5 * turn) < 0.25 for turn in turns)


def exactly(parts, away, is_closed, points):
    """The closed form of sharp corners of lines and arcs: runs, and whether an arc is prolonged; nothing of others, or where it cannot be trusted."""
    if parts is None:
        return None
    right = -away if is_closed and not shapely.LinearRing(points).is_ccw else away
    runs, arcs = lines_and_arcs.offset(parts, right, is_closed)
    if not runs or is_closed and lines_and_arcs.check(parts, right, runs) > 1e-6:
        return None
    return runs, arcs


def by_closed_form(name, away, runs, is_closed):
    pieces = [piece for run in runs for piece in run]
    spread = pieces[::max(1, len(pieces) // POINTS)][:POINTS]
    each = max(1, POINTS // len(spread))
    edges = [p for piece in pieces for p in piece.box()]
    case = {"wire": name, "away": away, "corners": "sharp", "by": "closed form", "loops": len(runs), "length": lines_and_arcs.length(runs),
            "low": [min(p[k] for p in edges) for k in (0, 1)], "high": [max(p[k] for p in edges) for k in (0, 1)],
            "points": [piece.at((2 * k + 1) / (2 * each)) for piece in spread for k in range(each)]}
    if is_closed:
        case["area"] = abs(lines_and_arcs.area(runs))
    return told(case)


left_out, closed_form = collections.Counter(), collections.Counter()
cases, given = [], wires()
for name, pieces in given.items():
    builder = BRepBuilderAPI_MakeWire()
    for piece in pieces:
        builder.Add(edge(piece))
    wire, points, fine = builder.Wire(), chords(pieces, CHORDS), chords(pieces, FINE)
    distances = distances_from(fine)
    parts_of_it = lines_and_arcs.read(pieces)
    is_closed = math.dist(points[0], points[-1]) < 1e-9
    if is_closed and not shapely.Polygon(points).is_valid:
        raise SystemExit(f"{name} crosses itself")
    way = 1.0
    if not is_closed:
        # Which side it takes for positive.
        first = moved(wire, 0.01, GeomAbs_Arc, False)
        p, q = points[0], points[1]
        side = min((math.dist(r, p), r) for r in along(first[0][0], 9) + along(first[0][-1], 9))[1] if first else p
        way = -1.0 if (q[0] - p[0]) * (side[1] - p[1]) - (q[1] - p[1]) * (side[0] - p[0]) > 0 else 1.0
    for away in (0.15, 0.6, 1.1, -0.15, -0.45, -0.9):
        for corners, join in (("round", GeomAbs_Arc), ("sharp", GeomAbs_Intersection)):
            if corners == "sharp" and not is_closed:
                exact = exactly(parts_of_it, away, False, points)
                if exact is None:
                    continue
                found = moved(wire, way * away, join, False)
                own = found and sum(GCPnts_AbscissaPoint.Length_s(BRepAdaptor_Curve(one), 1e-12) for one in found[0])
                long = lines_and_arcs.length(exact[0])
                same = bool(found) and len(found[1]) == len(exact[0]) and abs(own - long) <= 1e-9 * long
                closed_form["open sharp: " + ("OpenCASCADE alike" if same else "arcs prolonged" if found and exact[1] else "other length" if found else "refused")] += 1
                print(name, away, corners, "by closed form", long, own, file=sys.stderr)
                cases.append(by_closed_form(name, away, exact[0], False))
                continue
            if is_closed:
                loops, length, inside = by_buffer(points, away, corners == "sharp")
            else:
                (loops, length), inside = by_places(chords(pieces, FINE // 4), distances, away), None
            if loops == 0:
                continue
            if corners == "sharp" and is_needle(points, away):
                left_out["closed sharp: a corner too sharp"] += 1
                continue
            found = moved(wire, way * away, join, is_closed)
            why = None
            if found is None:
                why = "refused"
            else:
                own = sum(GCPnts_AbscissaPoint.Length_s(BRepAdaptor_Curve(one), 1e-12) for one in found[0])
                its_area = area(found[1]) if is_closed else None
                far = max(abs(d - abs(away)) for one in found[0] for d in distances(along(one, 9)))
                differs = lambda loops, length, inside, within: "loops" if len(found[1]) != loops else "length" if abs(own - length) > within * length \
                    else "area" if inside is not None and abs((its_area or 0.0) - inside) > within * inside else None  # noqa: E731
                why = differs(loops, length, inside, 1e-4 if is_closed else 2e-3)
                if is_closed and corners == "round" and why and far <= 1e-6:
                    # shapely makes concave ways simpler before it moves them.
                    way_out = away if shapely.LinearRing(points).is_ccw else -away
                    why = differs(*by_places(chords(pieces, FINE // 10), distances, way_out), None, 1e-3)
                if why is None and corners == "round" and far > 1e-6:
                    why = "distance"
            exact = exactly(parts_of_it, away, True, points) if why and is_closed and corners == "sharp" else None
            if exact:
                runs, arcs = exact
                long, inside = lines_and_arcs.length(runs), abs(lines_and_arcs.area(runs))
                if found and len(found[1]) == len(runs) and abs(own - long) <= 1e-9 * long and abs((its_area or 0.0) - inside) <= 1e-9 * inside:
                    # shapely alone was wrong: it makes concave ways simpler before it moves them.
                    why = None
                    closed_form["closed sharp: OpenCASCADE alike"] += 1
                else:
                    closed_form["closed sharp: " + ("refused" if found is None else "arcs prolonged" if arcs else "other " + why)] += 1
                    print(name, away, corners, "by closed form", long, inside, why, found and own, file=sys.stderr)
                    cases.append(by_closed_form(name, away, runs, True))
                    continue
            print(name, away, corners, why, (loops, length, inside), None if found is None else (len(found[1]), own, its_area, far), file=sys.stderr)
            if why:
                left_out[f"{'closed' if is_closed else 'open'} {corners}: {why}"] += 1
                continue
            low, high = box(found[0])
            spread = found[0][::max(1, len(found[0]) // POINTS)][:POINTS]
            each = max(1, POINTS // len(spread))
            case = {"wire": name, "away": away, "corners": corners, "loops": loops, "length": own, "low": low, "high": high,
                    "points": [p for one in spread for p in along(one, 2 * each + 1)[1::2]]}
            if is_closed:
                case["area"] = its_area
            cases.append(told(case))
compact = lambda x: json.dumps(x, separators=(",", ":"))  # noqa: E731
lines = [' "left_out": ' + json.dumps(dict(sorted(left_out.items()))),
         ' "closed_form": ' + json.dumps(dict(sorted(closed_form.items()))),
         ' "wires": {\n' + ",\n".join(f"  {json.dumps(name)}: {compact(pieces)}" for name, pieces in given.items()) + "\n }",
         ' "cases": [\n' + ",\n".join("  " + compact(case) for case in cases) + "\n ]"]
os.write(_out, ("{\n" + ",\n".join(lines) + "\n}\n").encode())
print(len(cases), dict(left_out), file=sys.stderr)
os._exit(0)
