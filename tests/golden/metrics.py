"""Least adjustments in other metrics than the plain one: weights, falloff, stretch and bend. Prints metrics.json.

The metrics' matrices are made here from their definitions, in exact rationals (reference.py's piecewise polynomials), and the
answers by dense numpy: d = K Fᵀ (F K Fᵀ)⁻¹ b with K the inverse of the metric on the vertices that may move. Nothing is shared
with the project, and no case is left out.
"""
import json

import numpy as np

from reference import Space, derived, integral, product

RANDOM = np.random.default_rng(20261122)


def short(values):
    return [round(float(v), 3) for v in values]


def random_curve(kind, degree):
    n = int(RANDOM.integers(degree + 4, degree + 9))
    if kind == "periodic":
        knots = np.cumsum(RANDOM.integers(1, 5, n + 1) / 2)
    elif kind == "floating":
        knots = np.cumsum(RANDOM.integers(1, 5, n + degree + 1) / 2)
    else:
        inner = np.sort(RANDOM.integers(1, 30, n - degree - 1) / 2) if kind == "open" else np.arange(1.0, n - degree)
        inner = [k for i, k in enumerate(inner) if list(inner[:i]).count(k) < max(1, degree - 1)]
        n = degree + 1 + len(inner)
        knots = np.concatenate([[0.0] * (degree + 1), inner, [max(inner) + 1.0] * (degree + 1)])
    points = [short(p) for p in RANDOM.normal(0, 3, (n, 3))]
    return {"degree": degree, "periodic": kind == "periodic", "knots": [float(k) for k in knots], "points": points}


def smoothness(space, order):
    """(1/L) ∫ b_i b_j + L^(2k) b_i^(k) b_j^(k), over the domain of length L."""
    length = space.domain[1] - space.domain[0]
    matrix = np.zeros((space.n, space.n))
    for piece in space.pieces():
        live = [(space.vertex(i), space.polynomial(i, piece)) for i in range(space.count())]
        live = [(v, c, derived(c, order)) for v, c in live if any(c)]
        for v, b, bk in live:
            for w, c, ck in live:
                plain, rough = (integral(product(x, y), piece[1] - piece[0]) for x, y in ((b, c), (bk, ck)))
                matrix[v, w] += float((plain + length ** (2 * order) * rough) / length)
    return matrix


def falloff(n, radius, periodic):
    """φ(distance/radius), φ(r) = (1-r)³(3r+1): how a vertex takes its neighbours along."""
    def phi(i, j):
        away = min(abs(i - j), n - abs(i - j)) if periodic else abs(i - j)
        r = away / radius
        return 0.0 if r >= 1 else (1 - r) ** 3 * (3 * r + 1)
    return np.array([[phi(i, j) for j in range(n)] for i in range(n)])


def case(kind, degree, metric):
    curve = random_curve(kind, degree)
    space, points = Space(curve), np.array(curve["points"])
    n = space.n
    lock = sorted({int(i) for i in RANDOM.choice(n, size=int(RANDOM.integers(0, 2)), replace=False)})
    free = [i for i in range(n) if i not in lock]
    if metric == "weights":
        said = {"weights": short(RANDOM.uniform(0.2, 5, n))}
        inverse = np.diag([1 / said["weights"][i] for i in free])
    elif metric == "falloff":
        radius = round(float(RANDOM.uniform(1.5, n / 2)), 2)
        said = {"falloff": radius}
        inverse = falloff(n, radius, space.periodic)[np.ix_(free, free)]
    else:
        said = metric
        inverse = np.linalg.inv(smoothness(space, 1 if metric == "stretch" else 2)[np.ix_(free, free)])
    a, b = (float(x) for x in space.domain)
    at = round(a + (b - a) * float(RANDOM.uniform(0.1, 0.9)), 3)
    by = short(RANDOM.normal(0, 1, 3))
    constraints = [{"kind": "position", "at": at, "by": by}]
    rows, change = [space.row(at, 0)], [by]
    if RANDOM.random() < 0.6:
        constraints.append({"kind": "derivative", "at": at, "order": 1, "keep": True})
        rows.append(space.row(at, 1))
        change.append([0.0] * 3)
    f = np.array([[float(v) for v in row] for row in rows])[:, free]
    gram = f @ inverse @ f.T
    d = np.zeros((n, 3))
    d[free] = inverse @ f.T @ np.linalg.solve(gram, np.array(change))
    return {"curve": curve, "lock": lock, "metric": said, "constraints": constraints, "points": (points + d).tolist()}


def main():
    kinds, metrics = ["open", "uniform", "floating", "periodic"], ["weights", "falloff", "stretch", "bend"]
    cases = [case(kind, degree, metric) for degree in range(2, 6) for kind in kinds for metric in metrics for _ in range(2)]
    print('{"what": "least adjustments in other metrics; tests/golden/metrics.py says how they were made", "cases": [')
    print(",\n".join(json.dumps(c, separators=(",", ":")) for c in cases))
    print("]}")


if __name__ == "__main__":
    main()
