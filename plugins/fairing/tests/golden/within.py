#!/usr/bin/env python3
"""Makes `within.json`: the least energy with no control vertex further than a distance from its place.

    python within.py > within.json          (needs numpy and scipy)

The same cases as `fair.py` makes (see there), with `distance`, a part of how far the fair shape goes without it, and `least`,
the least energy: by sequential quadratic programming (scipy's SLSQP) with one quadratic constraint a vertex.
"""
import json

import numpy as np
from scipy.optimize import minimize

import fair


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
    K, g = (A3 @ N).T @ (A3 @ N), (A3 @ N).T @ (A3 @ x0.ravel() - r3)
    scale = np.sum((A3 @ x0.ravel() - r3) ** 2)
    moved = lambda y: (N @ y).reshape(-1, 3)
    done = minimize(
        lambda y: (y @ K @ y + 2 * g @ y) / scale + 1,
        np.zeros(N.shape[1]),
        jac=lambda y: 2 * (K @ y + g) / scale,
        constraints={
            "type": "ineq",
            "fun": lambda y: distance**2 - np.sum(moved(y) ** 2, axis=1),
            "jac": lambda y: np.array([-2 * moved(y)[i] @ N[3 * i : 3 * i + 3] for i in range(len(x0))]),
        },
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 2000},
    )
    # Status 8: as far as rounding lets it.
    assert done.status in (0, 8), done
    case["distance"], case["least"], case["before"] = distance, float(done.fun * scale), float(scale)
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
answers = [least(case, 0.2 + 0.1 * (i % 7)) for i, case in enumerate(cases())]
# SLSQP works to a part of the first energy: what is far below it, it does not resolve.
print(",\n".join(json.dumps(case) for case in answers if case["least"] > 1e-3 * case["before"]))
print("]")
