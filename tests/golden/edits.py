#!/usr/bin/env python3
"""Makes `edits.json`: least adjustments of random curves under random linear constraints.

    python edits.py > edits.json          (needs numpy and scipy)

For each curve the wanted change b of c functionals of its n control vertices is met by the change d of least
norm, F d = b, ||d|| = min, with F a dense matrix over all 3n coordinates and d from a singular value
decomposition (numpy.linalg.pinv). Basis functions are scipy's. Every number of the input is short, so that
it is read alike everywhere; results have all digits.

A case: `curve`; `lock`, vertices that may not move; `constraints`, each with `kind`, `at` and one of `to`, `by`,
`keep`; `condition` of F; `points`, [index, x, y, z] of every vertex that moved, and `adjustment`, the norm of d.
"""
import json

import numpy as np
from scipy.interpolate import BSpline

RANDOM = np.random.default_rng(20260)
WORST_CONDITION = 300.0  # of F: a solver that squares it still has 1e-9 to spare


def short(x, digits=3):
    """Numbers rounded so that they print short."""
    return np.round(np.asarray(x, float), digits).tolist()


def flat_knots(curve):
    """The knots as an open knot vector; a periodic one is unrolled by its degree at both ends."""
    p, t = curve["degree"], np.array(curve["knots"])
    if not curve["periodic"]:
        return t
    n, period = len(t) - 1, t[-1] - t[0]
    return np.array([t[k % n] + (k // n) * period if k != n else t[n] for k in range(-p, n + p + 1)])


def polynomial_row(curve, u, order):
    """The order-th derivative at u of every vertex's polynomial basis function."""
    p, t = curve["degree"], flat_knots(curve)
    count, n = len(t) - p - 1, len(curve["points"])
    row = np.zeros(n)
    for k in range(count):
        unit = np.zeros(count)
        unit[k] = 1.0
        row[(k - p) % n if curve["periodic"] else k] += BSpline(t, unit, p)(u, nu=order)
    return row


def row(curve, u, order):
    """The order-th derivative at u of every vertex's basis function, rational where the curve has weights."""
    if "weights" not in curve:
        return polynomial_row(curve, u, order)
    w = np.array(curve["weights"])
    a = [polynomial_row(curve, u, k) * w for k in range(order + 1)]
    s = [x.sum() for x in a]
    r = [a[0] / s[0]]
    if order >= 1:
        r.append((a[1] - s[1] * r[0]) / s[0])
    if order >= 2:
        r.append((a[2] - 2 * s[1] * r[1] - s[2] * r[0]) / s[0])
    return r[order]


def random_curve(kind, degree):
    """A curve with uneven knots; for `repeated` one interior knot is there twice."""
    n = int(RANDOM.integers(degree + 3, degree + 9))
    step = lambda m: 0.5 + RANDOM.random(m)  # noqa: E731
    if kind == "periodic":
        knots = np.concatenate([[0], np.cumsum(step(n))]) + RANDOM.random()
    elif kind == "floating":
        knots = np.cumsum(step(n + degree + 1)) - 2
    else:
        inner = np.concatenate([[0], np.cumsum(step(n - degree))])
        knots = np.concatenate([np.full(degree, inner[0]), inner, np.full(degree, inner[-1])])
        if kind == "repeated" and degree > 1:
            knots[degree + 2] = knots[degree + 1]
    curve = {"degree": degree, "periodic": kind == "periodic", "knots": short(knots),
             "points": short(RANDOM.normal(0, 4, (n, 3)))}
    if kind == "rational":
        curve["weights"] = short(0.5 + 1.5 * RANDOM.random(n))
    return curve


def domain(curve):
    t = curve["knots"]
    return (t[0], t[-1]) if curve["periodic"] else (t[curve["degree"]], t[-curve["degree"] - 1])


def random_constraint(curve):
    """A constraint with the rows (k x 3n) and the wanted changes it means."""
    a, b = domain(curve)
    p, n, points = curve["degree"], len(curve["points"]), np.array(curve["points"])
    at = short(a + (b - a) * (0.02 + 0.96 * RANDOM.random()), 4)
    what = RANDOM.choice(["position", "position", "derivative", "vertex", "tangent", "orthogonal", "linear"])
    if what in ("tangent", "orthogonal"):
        vector = short(RANDOM.normal(size=3), 2)
        slope = row(curve, at, 1)
        if what == "orthogonal":  # C'.vector = 0
            normals = [np.array(vector)]
            said = {"kind": what, "at": at, "to": vector}
        else:  # C' parallel to vector: nothing across it
            normals = np.linalg.svd(np.array([vector]))[2][1:]
            said = {"kind": what, "at": at, "direction": vector}
        rows = np.array([np.kron(slope, normal) for normal in normals])
        return said, rows, -rows @ points.ravel()
    if what == "linear":  # sum of a_i . P_i
        terms = [{"vertex": int(v), "vector": short(RANDOM.normal(size=3), 2)}
                 for v in RANDOM.choice(n, size=2, replace=False)]
        rows = np.zeros((1, 3 * n))
        for term in terms:
            rows[0, 3 * term["vertex"]:3 * term["vertex"] + 3] = term["vector"]
        change = short(RANDOM.normal(), 3)
        return {"kind": what, "terms": terms, "by": change}, rows, np.array([change])
    if what == "vertex":
        index = int(RANDOM.integers(n))
        said, stencil = {"kind": what, "index": index}, np.eye(n)[index]
    else:
        order = 0 if what == "position" else int(RANDOM.integers(1, min(p, 2) + 1))
        said, stencil = {"kind": what, "at": at}, row(curve, at, order)
        if order:
            said["order"] = order
    rows, present = np.kron(stencil, np.eye(3)), stencil @ points
    if RANDOM.random() < 0.25:
        axis = int(RANDOM.integers(3))
        said["axis"] = "xyz"[axis]
        rows, present = rows[axis:axis + 1], present[axis]
    form = RANDOM.choice(["to", "by", "keep"])
    if form == "keep":
        said["keep"] = True
        return said, rows, np.zeros(len(rows))
    value = short(RANDOM.normal(0, 2, np.shape(present)), 3)
    said[form] = value
    change = np.array(value) - (present if form == "to" else 0)
    return said, rows, np.atleast_1d(change)


def case(kind, degree):
    """A random case whose equations are independent and well conditioned, and not all of them zero."""
    while True:
        curve = random_curve(kind, degree)
        n = len(curve["points"])
        lock = sorted(int(i) for i in RANDOM.choice(n, size=int(RANDOM.choice([0, 0, 1, 2])), replace=False))
        parts = [random_constraint(curve) for _ in range(int(RANDOM.integers(1, 5)))]
        rows, change = np.vstack([r for _, r, _ in parts]), np.concatenate([c for _, _, c in parts])
        free = np.array([3 * v + k for v in range(n) if v not in lock for k in range(3)])
        narrow = rows[:, free]
        singular = np.linalg.svd(narrow, compute_uv=False)
        if len(rows) > len(free) or singular[-1] * WORST_CONDITION < singular[0] or not np.any(change):
            continue
        d = np.zeros(3 * n)
        d[free] = np.linalg.pinv(narrow) @ change
        assert np.abs(rows @ d - change).max() < 1e-11 * max(1.0, np.abs(change).max())
        d = d.reshape(n, 3)
        after = np.array(curve["points"]) + d
        return {"curve": curve, "lock": lock, "constraints": [said for said, _, _ in parts],
                "condition": float(singular[0] / singular[-1]),
                "points": [[i, *after[i].tolist()] for i in range(n) if np.any(np.abs(d[i]) > 1e-14)],
                "adjustment": float(np.linalg.norm(d))}


def main():
    kinds = ["open", "floating", "periodic", "repeated", "rational"]
    cases = [case(kind, degree) for degree in range(1, 6) for kind in kinds for _ in range(12)]
    print('{"what": "least adjustments of curves; tests/golden/edits.py says how they were made", "cases": [')
    print(",\n".join(json.dumps(c, separators=(",", ":")) for c in cases))
    print("]}")


if __name__ == "__main__":
    main()
