"""Golden contacts of surfaces along an edge by OpenCASCADE: `python contacts.py > contacts.json` (cadquery-ocp, of scripts/oracles.sh).

Two surfaces each, that have the edge u = 0 of the second and u = 1 of the first in common. At many places of it: the angle between the
tangent planes, and the difference of the normal curvatures square to the edge, each from the surface's own principal curvatures and
directions by Euler's theorem; and the largest principal curvature of the first. The largest of each is written.

`python contacts.py ship.loft.json` says the same of a document's polynomial surfaces `hull` (its edge u1) and `deck` (u0), as
examples/matched-deck leaves them: to be compared with what the step reports.
"""

import json
import math
import sys

import numpy as np
from OCP.Geom import Geom_BSplineSurface
from OCP.GeomLProp import GeomLProp_SLProps
from OCP.collections import Array1_double, Array1_int, Array2_double, Array2_gp_Pnt
from OCP.gp import gp_Dir, gp_Pnt, gp_Vec

PLACES = 4000


def knots(degree, n):
    count = n - degree
    k, m = Array1_double(1, count + 1), Array1_int(1, count + 1)
    for i in range(count + 1):
        k.SetValue(i + 1, i / count)
        m.SetValue(i + 1, degree + 1 if i in (0, count) else 1)
    return k, m


def surface(points, weights, p, q):
    rows, columns = len(points), len(points[0])
    array, w = Array2_gp_Pnt(1, rows, 1, columns), Array2_double(1, rows, 1, columns)
    for i in range(rows):
        for j in range(columns):
            array.SetValue(i + 1, j + 1, gp_Pnt(*points[i][j]))
            w.SetValue(i + 1, j + 1, weights[i][j])
    (ku, mu), (kv, mv) = knots(p, rows), knots(q, columns)
    return Geom_BSplineSurface(array, w, ku, kv, mu, mv, p, q, False, False)


def vector(v):
    return np.array([v.X(), v.Y(), v.Z()])


def at(s, u, v):
    """The normal, the unit tangent along v, the normal curvature square to it, the largest principal curvature, and the way along u."""
    props = GeomLProp_SLProps(s, u, v, 2, 1e-12)
    p, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    s.D1(u, v, p, du, dv)
    normal, du, dv = vector(props.Normal()), vector(du), vector(dv)
    along = dv / np.linalg.norm(dv)
    across = np.cross(normal, along)
    # The first answer of this version is 0 (seen with 8.0.1): asked for twice.
    props.MaxCurvature(), props.MinCurvature()
    first, second = gp_Dir(), gp_Dir()
    umbilic = props.IsUmbilic()
    if not umbilic:
        props.CurvatureDirections(first, second)
    high, low = props.MaxCurvature(), props.MinCurvature()
    if umbilic:
        curvature = high
    else:
        cosine = float(np.dot(vector(first), across))
        curvature = high * cosine**2 + low * (1 - cosine**2)
    return normal, along, curvature, max(abs(high), abs(low)), du


def document(name):
    """The surfaces `hull` and `deck` of a document, clamped and polynomial."""
    with open(name) as file:
        objects = {o["name"]: o["surface"] for o in json.load(file)["objects"]}
    for name in ("hull", "deck"):
        s = objects[name]
        points, spaces = s["points"], []
        for space in (s["u"], s["v"]):
            places = sorted(set(space["knots"]))
            k, m = Array1_double(1, len(places)), Array1_int(1, len(places))
            for i, place in enumerate(places):
                # Over [0, 1]: neither angles nor curvatures know of parameters.
                k.SetValue(i + 1, (place - places[0]) / (places[-1] - places[0]))
                m.SetValue(i + 1, space["knots"].count(place))
            spaces.append((k, m, space["degree"]))
        array = Array2_gp_Pnt(1, len(points), 1, len(points[0]))
        for i, row in enumerate(points):
            for j, point in enumerate(row):
                array.SetValue(i + 1, j + 1, gp_Pnt(*point))
        (ku, mu, p), (kv, mv, q) = spaces
        yield Geom_BSplineSurface(array, ku, kv, mu, mv, p, q, False, False)


def worst(first, second):
    angle = curvature = largest = 0.0
    for k in range(PLACES + 1):
        v = k / PLACES
        n, along, one, most, out = at(first, 1.0, v)
        m, _, other, _, inwards = at(second, 0.0, v)
        sign = 1.0 if np.dot(n, m) >= 0 else -1.0
        between = math.atan2(np.linalg.norm(np.cross(n, m)), abs(np.dot(n, m)))
        square = out - along * np.dot(along, out)
        if np.dot(square, inwards) < 0:
            between = math.pi - between
        angle, largest = max(angle, between), max(largest, most)
        # OpenCASCADE counts curvature by the surface's own normal.
        curvature = max(curvature, abs(one - sign * other))
    return {"angle": angle, "curvature": curvature, "largest": largest}


def sheets(p, q, seed, skew, rational):
    """Two rough sheets with an edge in common; rows of the second run along the edge by `skew`."""
    rows, columns = p + 3, q + 4
    wave = lambda i, j, k: 0.1 * math.sin(1.3 * i + 2.1 * j + seed + 1.7 * k)
    weight = lambda i, j: 1 + 0.4 * math.sin(seed + 1.7 * i + 0.9 * j) if rational else 1.0
    first = [[[i - rows + 1.0, j + wave(i, j, 0), wave(i, j, 1) + 0.05 * (i - rows + 1) ** 2] for j in range(columns)] for i in range(rows)]
    ws = [[weight(i, j) for j in range(columns)] for i in range(rows)]
    second = [[[1.0 * i, j + skew * i + wave(i, j, 2), wave(i, j, 3) + 0.1 * i] for j in range(columns)] for i in range(rows)]
    wt = [[weight(i + 7, j) for j in range(columns)] for i in range(rows)]
    second[0], wt[0] = first[-1], ws[-1]
    return first, ws, second, wt


def main():
    if len(sys.argv) > 1:
        found = worst(*document(sys.argv[1]))
        print(f"angle {math.degrees(found['angle']):.5f}°, curvature {found['curvature']:.6f} "
              f"({100 * found['curvature'] / found['largest']:.3f} %)")
        return
    cases = []
    for seed, (p, q, skew, rational) in enumerate([(3, 3, 0.0, False), (3, 3, 5.6, False), (2, 4, -3.0, False), (5, 2, 2.0, True),
                                                    (4, 5, 8.0, True), (7, 3, -1.0, False), (2, 2, 0.5, True)]):
        first, ws, second, wt = sheets(p, q, seed, skew, rational)
        found = worst(surface(first, ws, p, q), surface(second, wt, p, q))
        cases.append({"degrees": [p, q], "skew": skew, "rational": rational, "first": first, "first_weights": ws, "second": second,
                      "second_weights": wt, **found})
    json.dump(cases, sys.stdout)
    print()


if __name__ == "__main__":
    main()
