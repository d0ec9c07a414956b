#!/usr/bin/env python3
"""Makes `fair.json`: fair shapes from dense linear algebra.

    python fair.py > fair.json          (needs numpy and scipy)

The energy of each case is written as ||A x - r||^2 over all 3n coordinates, A dense, from scipy's basis functions at
Gauss-Legendre nodes of every knot span (40 nodes for rational shapes); the constraints as F x = b. The answer is the one of
least energy; of several the one that is nearest to the shape that the least adjustment gives:

    x = x0 + pinv(F) (b - F x0),   then   x += N pinv(A N) (r - A x)   with N a basis of the null space of F (numpy's SVD).

A case: `degree`, `knots`, `periodic` (lists of two for surfaces), `points`, `weights` or null; `energy`, a list of [kind, weight];
`data`, [at, point, weight]; `lock`; `constraints`, [kind, at, order, wanted], kind "derivative" (to = wanted) or "tangent" (wanted = direction);
`fair`, the control vertices; `before` and `after`, the energy.
"""
import json
import math

import numpy as np
from scipy.interpolate import BSpline

RANDOM = np.random.default_rng(4711)


def short(x, digits=3):
    return np.round(np.asarray(x, float), digits).tolist()


class Space:
    def __init__(self, degree, knots, periodic):
        self.p, self.periodic, self.given = degree, periodic, list(knots)
        t = np.array(knots, float)
        if periodic:
            n, period = len(t) - 1, t[-1] - t[0]
            self.n = n
            t = np.array([t[k % n] + (k // n) * period if k != n else t[n] for k in range(-degree, n + degree + 1)])
        else:
            self.n = len(t) - degree - 1
        self.t = t
        self.count = len(t) - degree - 1
        self.a, self.b = t[degree], t[self.count]

    def row(self, u, order):
        out = np.zeros(self.n)
        for k in range(self.count):
            unit = np.zeros(self.count)
            unit[k] = 1.0
            out[(k - self.p) % self.n if self.periodic else k] += BSpline(self.t, unit, self.p)(u, nu=order)
        return out

    def nodes(self, m):
        x, w = np.polynomial.legendre.leggauss(m)
        breaks = np.unique(self.t[self.p : self.count + 1])
        for a, b in zip(breaks[:-1], breaks[1:]):
            for xi, wi in zip(x, w):
                yield 0.5 * (a + b) + 0.5 * (b - a) * xi, 0.5 * (b - a) * wi


def rational(rows, weights):
    """Derivative rows 0..k of R_i = w_i N_i / sum w N from those of N, by Leibniz' rule."""
    if weights is None:
        return rows
    w = np.array(weights)
    out = []
    sums = [float(r @ w) for r in rows]
    for k, r in enumerate(rows):
        value = r * w
        for j in range(1, k + 1):
            value = value - math.comb(k, j) * sums[j] * out[k - j]
        out.append(value / sums[0])
    return out


def curve_row(space, weights, u, order):
    return rational([space.row(u, k) for k in range(order + 1)], weights)[order]


ORDERS = {"near": 0, "stretch": 1, "bend": 2, "variation": 3}


def squares(case, spaces, x0):
    """A (rows over vertices) and r (rows of three)."""
    A, r = [], []
    weights = case["weights"]
    for kind, weight in case["energy"]:
        order = ORDERS[kind]
        if len(spaces) == 1:
            for u, w in spaces[0].nodes(40 if weights else spaces[0].p + 1):
                row = np.sqrt(weight * w) * curve_row(spaces[0], weights, u, order)
                A.append(row)
                r.append(row @ x0 if kind == "near" else np.zeros(3))
        else:
            for k in range(order + 1):
                for u, wu in spaces[0].nodes(spaces[0].p + 1):
                    for v, wv in spaces[1].nodes(spaces[1].p + 1):
                        row = np.outer(spaces[0].row(u, k), spaces[1].row(v, order - k)).ravel()
                        row = row * np.sqrt(weight * math.comb(order, k) * wu * wv)
                        A.append(row)
                        r.append(row @ x0 if kind == "near" else np.zeros(3))
    for at, point, weight in case["data"]:
        row = stencil(case, spaces, at, 0)
        A.append(np.sqrt(weight) * row)
        r.append(np.sqrt(weight) * np.array(point))
    return np.array(A), np.array(r)


def stencil(case, spaces, at, order):
    if len(spaces) == 1:
        return curve_row(spaces[0], case["weights"], at, order)
    orders = order if isinstance(order, list) else [0, 0]
    return np.outer(spaces[0].row(at[0], orders[0]), spaces[1].row(at[1], orders[1])).ravel()


def solve(case):
    if isinstance(case["degree"], list):
        spaces = [Space(*args) for args in zip(case["degree"], case["knots"], case["periodic"])]
    else:
        spaces = [Space(case["degree"], case["knots"], case["periodic"])]
    x0 = np.array(case["points"], float).reshape(-1, 3)
    n = len(x0)
    A, r = squares(case, spaces, x0)
    A3, r3 = np.kron(A, np.eye(3)), r.ravel()
    F, b = [], []
    for kind, at, order, wanted in case["constraints"]:
        row = stencil(case, spaces, at, order)
        if kind == "derivative":
            for axis in range(3):
                unit = np.zeros(3)
                unit[axis] = 1.0
                F.append(np.kron(row, unit))
                b.append(wanted[axis])
        else:  # parallel to a direction: nothing across it
            d = np.array(wanted) / np.linalg.norm(wanted)
            for across in np.linalg.svd(d.reshape(1, 3))[2][1:]:
                F.append(np.kron(row, across))
                b.append(0.0)
    free = np.ones(3 * n, bool)
    for vertex in case["lock"]:
        free[3 * vertex : 3 * vertex + 3] = False
    start = x0.ravel()
    F, b = np.array(F).reshape(-1, 3 * n), np.array(b)
    x = start.copy()
    G = F[:, free]
    N = np.eye(free.sum())
    if len(G):
        x[free] += np.linalg.pinv(G, rcond=1e-12) @ (b - F @ x)
        _, s, vt = np.linalg.svd(G)
        N = vt[int((s > 1e-12 * s[0]).sum()) :].T
    if N.shape[1]:
        x[free] += N @ np.linalg.pinv(A3[:, free] @ N, rcond=1e-9) @ (r3 - A3 @ x)
    case["fair"] = x.reshape(-1, 3).tolist()
    case["before"] = float(np.sum((A3 @ start - r3) ** 2))
    case["after"] = float(np.sum((A3 @ x - r3) ** 2))
    return case


def clamped(p, n, even):
    inner = np.arange(1, n - p) if even else np.sort(RANDOM.uniform(0.2, n - p - 0.2, n - p - 1))
    return [0.0] * (p + 1) + short(inner) + [float(n - p)] * (p + 1)


def cases():
    energies = [[["stretch", 1.0]], [["bend", 1.0]], [["variation", 1.0]], [["bend", 1.0], ["stretch", 0.5]], [["bend", 2.0], ["near", 0.25]]]
    for p in (2, 3, 4, 5):
        for periodic in (False, True):
            for weighted in (False, True):
                for energy in energies:
                    if p < max(ORDERS[k] for k, _ in energy):
                        continue
                    n = int(RANDOM.integers(p + 4, p + 10))
                    knots = short(np.concatenate([[0.0], np.cumsum(RANDOM.uniform(0.4, 1.6, n))])) if periodic else clamped(p, n, p == 3)
                    space = Space(p, knots, periodic)
                    points = short(np.column_stack([np.arange(n), np.zeros(n), np.zeros(n)]) + RANDOM.normal(0, 1, (n, 3)))
                    weights = short(RANDOM.uniform(0.6, 1.7, n)) if weighted else None
                    at = lambda f: round(float(space.a + f * (space.b - space.a)), 3)
                    kinds = int(RANDOM.integers(0, 4))
                    constraints = [["derivative", at(0.11), 0, short(RANDOM.normal(0, 1, 3))]]
                    if kinds >= 1:
                        constraints.append(["derivative", at(0.93), 0, short(RANDOM.normal(0, 1, 3) + 2)])
                    if kinds >= 2:
                        constraints.append(["derivative", at(0.48), 1, short(RANDOM.normal(0, 1, 3))])
                    if kinds >= 3:
                        constraints.append(["tangent", at(0.7), 1, short(RANDOM.normal(0, 1, 3))])
                    data = [[at(f), short(RANDOM.normal(0, 1, 3)), 1.5] for f in (0.3, 0.6)] if kinds == 2 else []
                    lock = [0, n - 1] if kinds == 1 and not periodic else []
                    yield dict(degree=p, knots=knots, periodic=periodic, points=points, weights=weights, energy=energy, data=data, lock=lock, constraints=constraints)
    for periodic in ([False, False], [True, False], [True, True]):
        for energy in ([["stretch", 1.0]], [["bend", 1.0]], [["variation", 1.0]], [["bend", 1.0], ["near", 0.1]]):
            p = [3, 3]
            n = [7, 6]
            knots = [short(np.concatenate([[0.0], np.cumsum(RANDOM.uniform(0.5, 1.5, m))])) if c else clamped(q, m, True) for q, m, c in zip(p, n, periodic)]
            grid = np.array([[i, j, 0.0] for i in range(n[0]) for j in range(n[1])])
            points = short(grid + RANDOM.normal(0, 0.4, grid.shape))
            constraints = [["derivative", [0.5, 0.5], [0, 0], [0.0, 0.0, 1.0]], ["derivative", [2.5, 1.0], [0, 0], [2.0, 1.0, 0.0]], ["derivative", [3.5, 2.5], [0, 0], [3.0, 3.0, 0.5]]]
            yield dict(degree=p, knots=knots, periodic=periodic, points=points, weights=None, energy=energy, data=[], lock=[], constraints=constraints)


if __name__ == "__main__":
    print("[")
    print(",\n".join(json.dumps(solve(case)) for case in cases()))
    print("]")
