"""Makes evaluation.json: points, derivatives, lengths, curvatures and closest points of curves and surfaces, computed
by OpenCASCADE (the `OCP` package) and SciPy.

    python evaluation.py > evaluation.json

* Points and derivatives: OpenCASCADE (`Geom_BSplineCurve.DN`, `Geom_BSplineSurface.DN`); SciPy's `BSpline` shows at
  which knot the vertices of a periodic direction start.
* Lengths: SciPy's adaptive quadrature of the speed, span by span.
* Curvatures: `GeomLProp_CLProps` and `GeomLProp_SLProps`; torsion from derivatives by the textbook's determinant.
* Closest points: a dense grid of points by OpenCASCADE, the best of them and their neighbours polished by SciPy's
  bounded minimisers; of `GeomAPI_ProjectPointOnCurve` (or `OnSurf`) and this, the closer.

The input is a fixed sequence of numbers, so that the file is the same on every run."""

import json
import math

import numpy as np
import scipy
from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int, Array2_double, Array2_gp_Pnt
from OCP.Geom import Geom_BSplineCurve, Geom_BSplineSurface
from OCP.GeomAPI import GeomAPI_ProjectPointOnCurve, GeomAPI_ProjectPointOnSurf
from OCP.GeomLProp import GeomLProp_CLProps, GeomLProp_SLProps
from OCP.gp import gp_Pnt
from scipy.integrate import quad
from scipy.interpolate import BSpline
from scipy.optimize import minimize, minimize_scalar

state = 1


def number():
    """The next of a fixed sequence of numbers in [0, 1)."""
    global state
    state = (1103515245 * state + 12345) % 2**31
    return state / 2**31


def filled(kind, values):
    array = kind(1, len(values))
    for i, value in enumerate(values):
        array.SetValue(i + 1, value)
    return array


def xyz(v):
    return np.array([v.X(), v.Y(), v.Z()])


def row(v):
    return [float(x) for x in v]


def knots_of(multiplicities):
    """Distinct knots; a short first gap, so that spans differ."""
    knots = [-0.5 + number()]
    for _ in multiplicities[1:]:
        knots.append(knots[-1] + 0.25 + number())
    return knots


def vertex_count(degree, multiplicities, periodic):
    return sum(multiplicities) - (multiplicities[0] if periodic else degree + 1)


def space(degree, knots, multiplicities, periodic):
    """Degree and knots with repetitions: all of them, or those of one period, of which the first then counts once and
    the last as often as the two together."""
    flat = np.repeat(knots, multiplicities)
    if periodic:
        flat = flat[multiplicities[0] - 1 :]
    return {"degree": degree, "periodic": periodic, "knots": row(flat)}


def unrolled(degree, told, vertices):
    """Knots and vertices of SciPy's open spline that is the same on the domain; of a periodic curve, vertex `i` is
    that of the B-spline that starts at knot `i`."""
    flat = np.array(told["knots"])
    if not told["periodic"]:
        return flat, vertices
    period, n = flat[-1] - flat[0], len(flat) - 1
    line = np.concatenate([flat[:-1] - 2 * period, flat[:-1] - period, flat[:-1], flat[:-1] + period, flat[:-1] + 2 * period])
    first = 2 * n - degree
    return line[first : first + n + 2 * degree + 1], np.array([vertices[(k - degree) % n] for k in range(n + degree)])


def rolled(degree, knots, multiplicities, periodic):
    """By how much OpenCASCADE's first vertex is ahead of ours: found by comparison with SciPy, which also shows that
    the two agree."""
    n = vertex_count(degree, multiplicities, periodic)
    values = np.array([math.sin(7.0 * i * i + 1.0) for i in range(n)])
    told = space(degree, knots, multiplicities, periodic)
    curve = Geom_BSplineCurve(
        filled(Array1_gp_Pnt, [gp_Pnt(x, 0.0, 0.0) for x in values]),
        filled(Array1_double, knots),
        filled(Array1_int, multiplicities),
        degree,
        periodic,
    )
    at = np.linspace(knots[0], knots[-1], 50)[1:-1]
    theirs = np.array([curve.Value(float(u)).X() for u in at])
    for turn in range(n if periodic else 1):
        line, vertices = unrolled(degree, told, np.roll(values, -turn))
        if np.abs(BSpline(line, vertices, degree)(at) - theirs).max() < 1e-12:
            return turn
    raise AssertionError("OpenCASCADE and SciPy do not agree")


def parameters(knots, count):
    """Places inside of spans (at knots the side would be a matter of taste)."""
    found = []
    for _ in range(count):
        i = int(number() * (len(knots) - 1))
        share = 0.05 + 0.9 * number()
        found.append(knots[i] + share * (knots[i + 1] - knots[i]))
    return found


def curve_closest(curve, knots, q):
    def distance(u):
        return float(np.linalg.norm(xyz(curve.Value(float(u))) - q))

    grid = np.unique(np.concatenate([np.linspace(a, b, 81) for a, b in zip(knots, knots[1:])]))
    values = np.array([distance(u) for u in grid])
    best = float(values.min())
    for i in np.argsort(values)[:8]:
        low, high = grid[max(i - 1, 0)], grid[min(i + 1, len(grid) - 1)]
        best = min(best, minimize_scalar(distance, bounds=(low, high), method="bounded", options={"xatol": 1e-13}).fun)
    projected = GeomAPI_ProjectPointOnCurve(gp_Pnt(*q), curve)
    return min(best, projected.LowerDistance()) if projected.NbPoints() else best


def surface_closest(surface, us, vs, q):
    def distance(at):
        return float(np.linalg.norm(xyz(surface.Value(float(at[0]), float(at[1]))) - q))

    def squared(at):
        return distance(at) ** 2

    grids = [np.unique(np.concatenate([np.linspace(a, b, 13) for a, b in zip(k, k[1:])])) for k in (us, vs)]
    places = [(u, v) for u in grids[0] for v in grids[1]]
    values = np.array([distance(p) for p in places])
    best = float(values.min())
    bounds = [(us[0], us[-1]), (vs[0], vs[-1])]
    for i in np.argsort(values)[:6]:
        polished = minimize(squared, places[i], bounds=bounds, method="L-BFGS-B", options={"ftol": 1e-16, "gtol": 1e-12})
        simplex = minimize(distance, polished.x, bounds=bounds, method="Nelder-Mead", options={"xatol": 1e-12, "fatol": 1e-14})
        best = min(best, distance(polished.x), float(simplex.fun))
    projected = GeomAPI_ProjectPointOnSurf(gp_Pnt(*q), surface)
    return min(best, projected.LowerDistance()) if projected.NbPoints() else best


def curve_case(degree, multiplicities, periodic, rational):
    knots = knots_of(multiplicities)
    n = vertex_count(degree, multiplicities, periodic)
    points = [[10 * number() - 5 for _ in range(3)] for _ in range(n)]
    weights = [0.4 + 2 * number() if rational else 1.0 for _ in range(n)]
    curve = Geom_BSplineCurve(
        filled(Array1_gp_Pnt, [gp_Pnt(*p) for p in points]),
        filled(Array1_double, weights),
        filled(Array1_double, knots),
        filled(Array1_int, multiplicities),
        degree,
        periodic,
    )
    samples = []
    for u in parameters(knots, 6):
        d = [xyz(curve.Value(u))] + [xyz(curve.DN(u, k)) for k in (1, 2, 3)]
        sample = {"u": u, "derivatives": [row(v) for v in d]}
        if degree > 1 or rational:
            cross = np.cross(d[1], d[2])
            # A curve of degree 1 is straight, with or without weights.
            sample["curvature"] = GeomLProp_CLProps(curve, u, 2, 1e-12).Curvature() if degree > 1 else 0.0
            if degree > 1:
                sample["torsion"] = float(np.dot(cross, d[3]) / np.dot(cross, cross))
        samples.append(sample)

    def speed(u):
        return float(np.linalg.norm(xyz(curve.DN(float(u), 1))))

    pieces = [quad(speed, a, b, epsabs=0, epsrel=1e-13, limit=400) for a, b in zip(knots, knots[1:])]
    assert sum(p[1] for p in pieces) < 2e-11 * sum(p[0] for p in pieces), pieces
    asked = [[16 * number() - 8 for _ in range(3)] for _ in range(3)]
    turn = rolled(degree, knots, multiplicities, periodic)
    points, weights = points[turn:] + points[:turn], weights[turn:] + weights[:turn]
    return {
        "space": space(degree, knots, multiplicities, periodic),
        "points": points,
        "weights": weights if rational else None,
        "samples": samples,
        "length": math.fsum(p[0] for p in pieces),
        "closest": [{"to": q, "distance": curve_closest(curve, knots, np.array(q))} for q in asked],
    }


def surface_case(u, v, rational):
    """`u` and `v`: degree, multiplicities, whether periodic."""
    us, vs = knots_of(u[1]), knots_of(v[1])
    rows, columns = vertex_count(*u), vertex_count(*v)
    points = [[3.0 * i + number(), 3.0 * j + number(), 6 * number()] for i in range(rows) for j in range(columns)]
    if u[2]:
        # Around an axis, so that the surface does not fold over itself.
        turn = [2 * math.pi * (k // columns) / rows for k in range(len(points))]
        points = [[(6 + 2 * number()) * math.cos(t), (6 + 2 * number()) * math.sin(t), p[1]] for t, p in zip(turn, points)]
    weights = [0.4 + 2 * number() if rational else 1.0 for _ in points]
    net, shares = Array2_gp_Pnt(1, rows, 1, columns), Array2_double(1, rows, 1, columns)
    for k, (p, w) in enumerate(zip(points, weights)):
        net.SetValue(k // columns + 1, k % columns + 1, gp_Pnt(*p))
        shares.SetValue(k // columns + 1, k % columns + 1, w)
    surface = Geom_BSplineSurface(
        net,
        shares,
        filled(Array1_double, us),
        filled(Array1_double, vs),
        filled(Array1_int, u[1]),
        filled(Array1_int, v[1]),
        u[0],
        v[0],
        u[2],
        v[2],
    )
    samples = []
    for a, b in zip(parameters(us, 5), parameters(vs, 5)):
        orders = [(i, j) for i in range(4) for j in range(4 - i)]
        values = [surface.Value(a, b) if i + j == 0 else surface.DN(a, b, i, j) for i, j in orders]
        props = GeomLProp_SLProps(surface, a, b, 2, 1e-12)
        assert props.IsCurvatureDefined()
        samples.append(
            {
                "at": [a, b],
                "orders": orders,
                "derivatives": [row(xyz(d)) for d in values],
                "normal": row(xyz(props.Normal())),
                "gaussian": props.GaussianCurvature(),
                "mean": props.MeanCurvature(),
            }
        )
    asked = [[16 * number() - 4 for _ in range(3)] for _ in range(3)]
    turns = rolled(u[0], us, u[1], u[2]), rolled(v[0], vs, v[1], v[2])
    order = [(i + turns[0]) % rows * columns + (j + turns[1]) % columns for i in range(rows) for j in range(columns)]
    points, weights = [points[k] for k in order], [weights[k] for k in order]
    return {
        "u": space(u[0], us, u[1], u[2]),
        "v": space(v[0], vs, v[1], v[2]),
        "points": points,
        "weights": weights if rational else None,
        "samples": samples,
        "closest": [{"to": q, "distance": surface_closest(surface, us, vs, np.array(q))} for q in asked],
    }


curves = []
for rational in (False, True):
    for degree in range(1, 6):
        curves.append(curve_case(degree, [degree + 1, 1, 1, 1, degree + 1], False, rational))
        curves.append(curve_case(degree, [1] * (degree + 4), True, rational))
    curves.append(curve_case(3, [4, 2, 1, 3, 1, 4], False, rational))
    curves.append(curve_case(3, [2, 1, 2, 1, 1, 2], True, rational))
    curves.append(curve_case(9, [10, 1, 2, 10], False, rational))

surfaces = []
for rational in (False, True):
    surfaces.append(surface_case((3, [4, 1, 1, 4], False), (2, [3, 1, 3], False), rational))
    surfaces.append(surface_case((3, [1] * 7, True), (3, [4, 1, 4], False), rational))
    surfaces.append(surface_case((2, [1] * 6, True), (4, [5, 2, 1, 5], False), rational))
    surfaces.append(surface_case((5, [6, 1, 6], False), (2, [3, 2, 3], False), rational))

made_by = f"OpenCASCADE (OCP), SciPy {scipy.__version__}"
print(json.dumps({"made_by": made_by, "curves": curves, "surfaces": surfaces}))
