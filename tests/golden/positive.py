#!/usr/bin/env python3
"""Makes `positive.json`: fine tuning with an α that has to be positive everywhere, solved by the interior-point solver Clarabel.

    python positive.py > positive.json          (needs numpy, scipy and clarabel)

A curve C in the plane, α a spline of degree `alpha_degree` on the derivative's knots. Both ends stay, ∫ (α - 1) C' = 0; α is at least .001 at two thousand
places of each span, which is as good as everywhere. A case: `degree`, `knots`, `points`, `alpha_degree`, `at`; `most`, the largest α(at) that can be had;
`to`, a part of that, and `alpha`, the values of the α nearest to 1 in ∫ (α - 1)² with α(at) = `to`.
"""
import json

import clarabel
import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline

RANDOM = np.random.default_rng(1602)
BOUND = 1e-3


def program(p, q, equations, targets, below, bounds):
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = 500
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-11
    a = sparse.csc_matrix(np.vstack([equations, below]))
    cones = [clarabel.ZeroConeT(len(targets)), clarabel.NonnegativeConeT(len(bounds))]
    upper = sparse.triu(sparse.csc_matrix(p), format="csc")
    answer = clarabel.DefaultSolver(upper, q, a, np.concatenate([targets, bounds]), cones, settings).solve()
    return np.array(answer.x) if str(answer.status) in ("Solved", "AlmostSolved") else None


def basis(knots, degree, places):
    return BSpline.design_matrix(places, knots, degree, extrapolate=False).toarray()


def case(degree, alpha_degree, spans):
    inner = np.cumsum(RANDOM.uniform(0.5, 1.5, spans)).round(2)
    breaks = np.concatenate([[0.0], inner])
    knots = np.concatenate([[0.0] * degree, breaks, [breaks[-1]] * degree])
    n = len(knots) - degree - 1
    angle = np.linspace(0, 4.5, n)
    points = np.stack([1.5 * angle, np.cos(2 * angle)], 1) + RANDOM.uniform(-0.2, 0.2, (n, 2))
    points = points.round(2)
    own = np.concatenate([[0.0] * alpha_degree, breaks, [breaks[-1]] * alpha_degree])
    count = len(own) - alpha_degree - 1
    x, w = np.polynomial.legendre.leggauss(degree + alpha_degree + 1)
    slope = BSpline(knots, points, degree).derivative()
    moments, gram = np.zeros((2, count)), np.zeros((count, count))
    for a, b in zip(breaks[:-1], breaks[1:]):
        t, weight = a + (b - a) * (x + 1) / 2, w * (b - a) / 2
        rows = basis(own, alpha_degree, t)
        moments += (slope(t) * weight[:, None]).T @ rows
        gram += rows.T @ (rows * weight[:, None])
    dense = np.unique(np.concatenate([np.linspace(a, b, 2001) for a, b in zip(breaks[:-1], breaks[1:])]))
    dense[-1] = breaks[-1]
    below, bounds = -basis(own, alpha_degree, dense), np.full(len(dense), -BOUND)
    at = round(float(RANDOM.uniform(0.15, 0.85) * breaks[-1]), 2)
    there = basis(own, alpha_degree, [at])[0]
    kept = moments @ np.ones(count)
    # All tangents look ahead, so that what is more in one place has to be less in others.
    far = program(np.zeros((count, count)), -there, moments, kept, below, bounds)
    if far is None:
        return None
    most = float(there @ far)
    to = round(1.0 + 0.97 * (most - 1.0), 4)
    near = program(2 * gram, -2 * gram @ np.ones(count), np.vstack([moments, there]), np.append(kept, to), below, bounds)
    if near is None:
        return None
    return {
        "degree": degree,
        "knots": knots.tolist(),
        "points": points.tolist(),
        "alpha_degree": alpha_degree,
        "at": at,
        "most": most,
        "to": to,
        "alpha": near.tolist(),
        "values_below_zero": int((near < 0).sum()),
    }


cases = []
for degree in (2, 3, 4, 5, 7):
    for alpha_degree in sorted({1, 2, degree - 1}):
        for spans in (3, 5, 8):
            found = case(degree, alpha_degree, spans)
            if found:
                cases.append(found)
print(json.dumps({"bound": BOUND, "cases": cases}, indent=None, separators=(",", ":")))
