"""Makes plugins/area-volume/tests/golden/effort.json: what constraints that contradict one another miss at least, by scipy.

    effort.py > plugins/area-volume/tests/golden/effort.json

`least_squares` of `w (value - target)` over all control vertices, `w` one over the length of the value's gradient where the vertices stand at first: places of
open B-spline curves (`scipy.interpolate.BSpline`) and their lengths (Gauss-Legendre, 80 places a span), nothing shared with the project.
"""
import json

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import least_squares

random = np.random.default_rng(11)


def clamped(p, inner):
    return np.concatenate([np.zeros(p + 1), inner, np.ones(p + 1)])


def case(p, inner, keep, by, share):
    knots = clamped(p, inner)
    n = len(knots) - p - 1
    points = np.column_stack([np.linspace(0, 4, n), np.zeros(n), np.zeros(n)]) + random.uniform(-0.7, 0.7, (n, 3))
    basis = lambda u, k=0: np.array([BSpline(knots, np.eye(n)[i], p).derivative(k)(u) if k else BSpline(knots, np.eye(n)[i], p)(u) for i in range(n)]).T
    x, w = np.polynomial.legendre.leggauss(80)
    ends = np.unique(knots)
    at = np.concatenate([(a + b) / 2 + (b - a) / 2 * x for a, b in zip(ends, ends[1:])])
    weight = np.concatenate([(b - a) / 2 * w for a, b in zip(ends, ends[1:])])
    slope = basis(at, 1)
    length = lambda P: (weight * np.linalg.norm(slope @ P, axis=1)).sum()

    def gradient(P):
        t = slope @ P
        return slope.T @ (weight[:, None] * t / np.linalg.norm(t, axis=1)[:, None])

    to = share * length(points)
    rows = [(basis(np.array([u]))[0], None) for u in keep] + ([(basis(np.array([by[0]]))[0], by[1:])] if by else [])
    targets = [r @ points + (0 if b is None else np.array(b)) for r, b in rows]
    heavy = 1 / np.linalg.norm(gradient(points))

    def misses(v):
        P = v.reshape(n, 3)
        return np.concatenate([(r @ P - t) / np.linalg.norm(r) for (r, _), t in zip(rows, targets)] + [[heavy * (length(P) - to)]])

    def jacobian(v):
        P = v.reshape(n, 3)
        lines = [np.kron(r / np.linalg.norm(r), np.eye(3)[k]) for r, _ in rows for k in range(3)]
        return np.array(lines + [heavy * gradient(P).ravel()])

    found = least_squares(misses, points.ravel(), jacobian, method="trf", xtol=1e-15, ftol=1e-15, gtol=1e-13, max_nfev=20000)
    P = found.x.reshape(n, 3)
    missed = [float(np.linalg.norm(r @ P - t)) for (r, _), t in zip(rows, targets)] + [float(abs(length(P) - to))]
    return dict(degree=p, knots=knots.tolist(), points=points.tolist(), keep=keep, by=by, length=float(to), missed=missed,
                slope=float(np.abs(found.grad).max()))


cases = [
    case(1, [0.3, 0.6], [0.0, 1.0], [], 0.3),
    case(2, [0.5], [0.0, 1.0], [], 0.2),
    case(3, [0.25, 0.5, 0.75], [0.0, 1.0], [], 0.3),
    case(3, [0.4, 0.4, 0.7], [0.0], [1.0, 0.5, 1.0, -0.3], 0.4),
    case(4, [0.5], [0.0, 1.0], [], 0.25),
    case(5, [0.5, 0.6], [0.0, 1.0], [], 0.5),
    case(7, [], [0.0, 1.0], [], 0.5),
]
print(json.dumps(dict(cases=cases), indent=1))
