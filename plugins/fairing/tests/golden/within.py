#!/usr/bin/env python3
"""Makes `within.json`: the least energy with no control vertex further than a distance from its place.

    python within.py > within.json          (needs numpy and scipy)

The same cases as `fair.py` makes (see there), with `distance`, a part of how far the fair shape goes without it, and `least`,
the least energy: by sequential quadratic programming (scipy's SLSQP) with one quadratic constraint a vertex. SLSQP works to a part of
the energy that it starts with, which may be a million times the least; so it starts again from where it stopped, in units of
what is left. That the answer is the least is certified by its dual: with weights t >= 0 (least squares under signs, scipy's nnls),

    min |B y + c|^2 + sum t_i (|N_i y|^2 - distance^2)

is never above the least energy, and here not more than 1e-9 of it below the answer.
"""
import json

import numpy as np
from scipy.optimize import minimize, nnls

import fair


def bound(B, c, N, distance, t):
    """The dual's value: a bound of the least energy from below."""
    S = np.vstack([B, np.repeat(np.sqrt(t), 3)[:, None] * N])
    r = np.concatenate([-c, np.zeros(len(N))])
    y = np.linalg.lstsq(S, r, rcond=None)[0]
    return np.sum((S @ y - r) ** 2) - distance**2 * np.sum(t)


def least(case, part):
    free_answer = np.array(fair.solve(dict(case))["fair"])
    spaces = [fair.Space(case["degree"], case["knots"], case["periodic"])]
    x0 = np.array(case["points"], float)
    A, r = fair.squares(case, spaces, x0)
    A3, r3 = np.kron(A, np.eye(3)), r.ravel()
    distance = float(np.round(part * np.max(np.linalg.norm(free_answer - x0, axis=1)), 3))
    F = [np.kron(fair.stencil(case, spaces, at, order), np.eye(3)[axis]) for _, at, order, _ in case["constraints"] for axis in range(3)]
    F = np.array(F).reshape(-1, x0.size)
    N = np.linalg.svd(F)[2][len(F) :].T
    # |A x - r| in as many numbers as there are unknowns and one.
    R = np.linalg.qr(np.column_stack([A3 @ N, A3 @ x0.ravel() - r3]))[1]
    B, c = R[:, :-1], R[:, -1]
    energy = lambda y: np.sum((B @ y + c) ** 2)
    moved = lambda y: (N @ y).reshape(-1, 3)
    y = np.zeros(N.shape[1])
    for _ in range(4):
        scale = energy(y)
        done = minimize(
            lambda y: energy(y) / scale,
            y,
            jac=lambda y: 2 * B.T @ (B @ y + c) / scale,
            constraints={
                "type": "ineq",
                "fun": lambda y: distance**2 - np.sum(moved(y) ** 2, axis=1),
                "jac": lambda y: np.array([-2 * moved(y)[i] @ N[3 * i : 3 * i + 3] for i in range(len(x0))]),
            },
            method="SLSQP",
            options={"ftol": 1e-15, "maxiter": 5000},
        )
        # Status 8: as far as rounding lets it.
        assert done.status in (0, 8), done
        y = done.x
    far = np.linalg.norm(moved(y), axis=1)
    assert np.max(far) < distance * (1 + 1e-12), far
    at = np.flatnonzero(far > distance * (1 - 1e-5))
    pulls = np.array([2 * N[3 * i : 3 * i + 3].T @ moved(y)[i] for i in at]).reshape(-1, len(y)).T
    t = np.zeros(len(x0))
    if len(at):
        t[at] = nnls(pulls, -2 * B.T @ (B @ y + c))[0]
    assert energy(y) - bound(B, c, N, distance, t) < 1e-9 * energy(y)
    case["distance"], case["least"], case["before"] = distance, float(energy(y)), float(c @ c)
    return case


def cases():
    for case in fair.cases():
        if isinstance(case["degree"], list) or case["lock"] or any(k == "tangent" for k, *_ in case["constraints"]):
            continue
        # What is asked is kept.
        spaces = [fair.Space(case["degree"], case["knots"], case["periodic"])]
        for asked in case["constraints"]:
            row = fair.stencil(case, spaces, asked[1], asked[2])
            asked[3] = (row @ np.array(case["points"])).tolist()
        yield case


print("[")
print(",\n".join(json.dumps(least(case, 0.2 + 0.1 * (i % 7))) for i, case in enumerate(cases())))
print("]")
