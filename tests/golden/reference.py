"""Makes the expected numbers of four golden files from the inputs that stand in them, by the book:

    basis.json   (kernel)       basis functions and derivatives: Cox and de Boor's recurrence in exact rationals
    area.json    (area-volume)  area forms and areas: piecewise polynomials multiplied and integrated in exact rationals
    volume.json  (area-volume)  volumes: Gauss-Legendre quadrature of the divergence theorem, more points than are exact
    edit.json    (here)         least adjustments: exact stencils, the pseudo-inverse of numpy

Nothing is shared with the project, and nothing is left out: every case of a file is made anew.

    reference.py FILE           prints the file with its numbers made anew
    reference.py --check FILE…  says how far the numbers in the files are from these; fails above 1e-12 (relative)

The inputs were drawn once, by a program that was not kept; these are the numbers that belong to them.
"""
import json
import sys
from fractions import Fraction

import numpy as np


def exact(values):
    return [Fraction(v) for v in values]


class Space:
    """A degree and knots as documents have them: open, or periodic with one period of knots."""

    def __init__(self, said):
        self.p, self.periodic = said["degree"], said["periodic"]
        knots, p = exact(said["knots"]), said["degree"]
        if self.periodic:
            self.n, period = len(knots) - 1, knots[-1] - knots[0]
            at = lambda i: knots[i % self.n] + period * (i // self.n)
            # Vertex i multiplies the B-spline whose support starts at knots[i]; those before the period reach into it.
            self.flat = [at(i) for i in range(-p, self.n + p + 1)]
            self.first = -p
            self.domain = (knots[0], knots[-1])
        else:
            self.n, self.flat, self.first = len(knots) - p - 1, knots, 0
            self.domain = (knots[p], knots[self.n])

    def vertex(self, i):
        """The vertex that unrolled function i belongs to."""
        return (i + self.first) % self.n

    def count(self):
        return len(self.flat) - self.p - 1

    def pieces(self):
        """The spans within the domain that have a length."""
        a, b = self.domain
        edges = sorted({k for k in self.flat if a <= k <= b})
        return list(zip(edges, edges[1:]))

    def polynomial(self, i, piece, degree=None):
        """Function i on a piece as coefficients of powers of u - piece[0], by the recurrence."""
        k = self.p if degree is None else degree
        t, a = self.flat, piece[0]
        if k == 0:
            return [Fraction(1 if t[i] <= a < t[i + 1] else 0)]
        out = [Fraction(0)] * (k + 1)
        for j, start, sign, width in ((i, t[i], 1, t[i + k] - t[i]), (i + 1, t[i + k + 1], -1, t[i + k + 1] - t[i + 1])):
            if width == 0:
                continue
            lower = self.polynomial(j, piece, k - 1)
            for power, c in enumerate(lower):
                out[power] += sign * (a - start) * c / width
                out[power + 1] += sign * c / width
        return out

    def row(self, u, order):
        """The derivatives of that order of all vertices' functions at u; at a knot those of the piece to the right."""
        u = Fraction(u)
        a, b = self.domain
        if self.periodic:
            u = a + (u - a) % (b - a)
        piece = next((q for q in self.pieces() if q[0] <= u < q[1]), self.pieces()[-1])
        row = [Fraction(0)] * self.n
        for i in range(self.count()):
            c = derived(self.polynomial(i, piece), order)
            row[self.vertex(i)] += sum(c * (u - piece[0]) ** k for k, c in enumerate(c))
        return row


def derived(c, order=1):
    for _ in range(order):
        c = [k * v for k, v in enumerate(c)][1:]
    return c


def integral(c, width):
    return sum(v * width ** (k + 1) / (k + 1) for k, v in enumerate(c))


def product(a, b):
    out = [Fraction(0)] * (len(a) + len(b))
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += x * y
    return out


def basis(case):
    case["row"] = [float(v) for v in Space(case["space"]).row(case["u"], case["order"])]


def area(case):
    space = Space(case["curve"])
    form = [[Fraction(0)] * space.n for _ in range(space.n)]
    for piece in space.pieces():
        live = [(space.vertex(i), space.polynomial(i, piece)) for i in range(space.count())]
        live = [(v, c) for v, c in live if any(c)]
        for v, b in live:
            for w, c in live:
                both = integral(product(b, derived(c)), piece[1] - piece[0])
                form[v][w] += both
                form[w][v] -= both
    xs, ys = (exact(p[k] for p in case["curve"]["points"]) for k in (0, 1))
    twice = sum(form[i][j] * xs[i] * ys[j] for i in range(space.n) for j in range(space.n))
    case["form"] = [[float(v) for v in row] for row in form]
    case["area"] = float(twice / 2)


def samples(space, points):
    """Gauss points and weights of all pieces, and the values and derivatives of all vertices' functions there."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    where, by, rows, slopes = [], [], [], []
    for a, b in space.pieces():
        live = [(space.vertex(i), space.polynomial(i, (a, b))) for i in range(space.count())]
        half = float(b - a) / 2
        for node, weight in zip(nodes, weights):
            s = half * (1 + node)
            where.append(float(a) + s)
            by.append(weight * half)
            row, slope = np.zeros(space.n), np.zeros(space.n)
            for v, c in live:
                row[v] += np.polyval([float(x) for x in reversed(c)], s)
                slope[v] += np.polyval([float(x) for x in reversed(derived(c))] or [0.0], s)
            rows.append(row)
            slopes.append(slope)
    return np.array(by), np.array(rows), np.array(slopes)


def volume(case):
    u, v = Space(case["surface"]["u"]), Space(case["surface"]["v"])
    (wu, bu, du), (wv, bv, dv) = samples(u, 2 * u.p + 2), samples(v, 2 * v.p + 2)
    net = np.array(case["surface"]["points"])
    at = lambda a, b: np.einsum("ia,jb,abk->ijk", a, b, net)
    point, along, across = at(bu, bv), at(du, bv), at(bu, dv)
    flux = np.einsum("ijk,ijk->ij", point, np.cross(along, across)) / 3
    case["volume"] = float(np.einsum("i,j,ij->", wu, wv, flux))


def edit(case):
    space = Space(case["curve"])
    points = np.array(case["curve"]["points"])
    free = [i for i in range(space.n) if i not in [k % space.n for k in case["lock"]]]
    rows, change = [], []
    for said in case["constraints"]:
        row = np.array([float(x) for x in space.row(said["at"], said.get("order", 0))])
        present = row @ points
        wanted = {"keep": lambda _: present, "to": np.array, "by": lambda by: present + np.array(by),
                  "scale": lambda factor: present * factor}
        form = next(f for f in wanted if f in said)
        rows.append(row)
        change.append(wanted[form](said[form]) - present)
    rows, change = np.array(rows), np.array(change)
    case["condition"] = float(np.linalg.cond(rows))
    rows = rows[:, free]
    d = np.zeros_like(points)
    # numpy's cut-off for the rank is relative to the largest singular value; rows are scaled to unit length first.
    scale = 1 / np.linalg.norm(rows, axis=1)
    d[free] = np.linalg.pinv(rows * scale[:, None], rcond=1e-12) @ (change * scale[:, None])
    case["points"], case["adjustment"] = (points + d).tolist(), float(np.linalg.norm(d))


MAKERS = {"row": basis, "form": area, "volume": volume, "points": edit}


def remake(said):
    for case in said["cases"]:
        MAKERS[next(name for name in MAKERS if name in case)](case)
    return said


def numbers(value):
    if isinstance(value, dict):
        return [x for v in value.values() for x in numbers(v)]
    if isinstance(value, list):
        return [x for v in value for x in numbers(v)]
    return [float(value)] if isinstance(value, (int, float)) and not isinstance(value, bool) else []


def main():
    if sys.argv[1:2] != ["--check"]:
        with open(sys.argv[1], encoding="utf-8") as file:
            json.dump(remake(json.load(file)), sys.stdout)
        return
    for name in sys.argv[2:]:
        with open(name, encoding="utf-8") as file:
            text = file.read()
        before, after = json.loads(text), remake(json.loads(text))
        worst = 0.0
        for old, new in zip(before["cases"], after["cases"]):
            a, b = np.array(numbers(old)), np.array(numbers(new))
            worst = max(worst, float(np.abs(a - b).max() / max(1.0, np.abs(a).max())))
        print(f"{name}: {len(after['cases'])} cases, off by {worst:.1e}")
        if not worst <= 1e-12:
            sys.exit(1)


if __name__ == "__main__":
    main()
