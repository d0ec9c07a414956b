"""Makes refinement.json: control vertices after knot insertion, degree elevation, trimming and opening, computed by
OpenCASCADE (the `OCP` package, Geom_BSplineCurve) and SciPy (BSpline.insert_knot).

    python refinement.py > refinement.json

The input is a fixed sequence of numbers, so that the file is the same on every run."""

import json

import numpy as np
import scipy
from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int
from OCP.Geom import Geom_BSplineCurve
from OCP.gp import gp_Pnt
from scipy.interpolate import BSpline

state = 1


def number():
    """The next of a fixed sequence of numbers in [0, 1)."""
    global state
    state = (1103515245 * state + 12345) % 2**31
    return state / 2**31


def occt(degree, knots, multiplicities, points, weights, periodic):
    poles = Array1_gp_Pnt(1, len(points))
    shares = Array1_double(1, len(points))
    for i, (p, w) in enumerate(zip(points, weights)):
        poles.SetValue(i + 1, gp_Pnt(*p))
        shares.SetValue(i + 1, w)
    values = Array1_double(1, len(knots))
    counts = Array1_int(1, len(knots))
    for i, (k, m) in enumerate(zip(knots, multiplicities)):
        values.SetValue(i + 1, k)
        counts.SetValue(i + 1, m)
    return Geom_BSplineCurve(poles, shares, values, counts, degree, periodic)


def told(curve):
    """Degree, knots with multiplicities, poles and weights."""
    n = curve.NbPoles()
    poles = [curve.Pole(i + 1) for i in range(n)]
    return {
        "degree": curve.Degree(),
        "periodic": curve.IsPeriodic(),
        "knots": [[curve.Knot(i + 1), curve.Multiplicity(i + 1)] for i in range(curve.NbKnots())],
        "points": [[p.X(), p.Y(), p.Z()] for p in poles],
        "weights": [curve.Weight(i + 1) for i in range(n)],
    }


def case(degree, multiplicities, periodic, rational):
    knots = [0.0]
    for _ in multiplicities[1:]:
        knots.append(knots[-1] + 0.25 + number())
    n = sum(multiplicities) - (multiplicities[0] if periodic else degree + 1)
    points = [[10 * number() - 5 for _ in range(3)] for _ in range(n)]
    weights = [0.5 + number() if rational else 1.0 for _ in range(n)]
    make = lambda: occt(degree, knots, multiplicities, points, weights, periodic)
    a, b = knots[0], knots[-1]
    new = a + 0.37 * (b - a)
    result = {"input": told(make()), "new": new, "part": [a + 0.2 * (b - a), a + 0.81 * (b - a)]}
    inserted = make()
    inserted.InsertKnot(new, 2 if degree > 1 else 1, 0.0, True)
    result["inserted"] = told(inserted)
    raised = make()
    raised.IncreaseDegree(degree + 2)
    # OpenCASCADE 8 gives another curve for some periodic ones with repeated knots.
    if make().Value(new).Distance(raised.Value(new)) < 1e-9:
        result["raised"] = told(raised)
    part = make()
    part.Segment(*result["part"])
    result["part_curve"] = told(part)
    if periodic:
        opened = make()
        opened.SetNotPeriodic()
        result["opened"] = told(opened)
    return result


def floating():
    """Unclamped curves, which OpenCASCADE does not insert into: SciPy does."""
    cases = []
    for degree in (2, 3, 5):
        n = degree + 6
        knots = np.cumsum([0.25 + number() for _ in range(n + degree + 1)])
        points = np.array([[10 * number() - 5 for _ in range(3)] for _ in range(n)])
        spline = BSpline(knots, points, degree)
        new = 0.5 * (knots[degree + 1] + knots[degree + 2])
        finer = spline.insert_knot(new, 2)
        cases.append(
            {
                "degree": degree,
                "knots": knots.tolist(),
                "points": points.tolist(),
                "new": new,
                "inserted": {"knots": finer.t[: len(finer.t)].tolist(), "points": finer.c[: n + 2].tolist()},
            }
        )
    return cases


if __name__ == "__main__":
    cases = [
        case(1, [2, 1, 1, 2], False, False),
        case(2, [3, 1, 2, 1, 3], False, False),
        case(3, [4, 1, 1, 2, 3, 1, 4], False, False),
        case(3, [4, 1, 2, 1, 4], False, True),
        case(5, [6, 2, 1, 4, 6], False, True),
        case(8, [9, 3, 1, 9], False, False),
        case(2, [1, 1, 1, 1, 1, 1], True, False),
        case(3, [1, 1, 2, 1, 1, 1, 1], True, False),
        case(3, [2, 1, 1, 3, 1, 2], True, True),
        case(5, [1, 1, 1, 2, 1, 1, 1, 1, 1], True, True),
    ]
    made_by = f"OpenCASCADE (OCP), SciPy {scipy.__version__}"
    print(json.dumps({"made_by": made_by, "cases": cases, "floating": floating()}))
