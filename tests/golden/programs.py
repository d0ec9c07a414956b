#!/usr/bin/env python3
"""Makes `programs.json`: quadratic programs, solved by the interior-point solver Clarabel.

    python programs.py > programs.json          (needs numpy, scipy and clarabel)

min d'Wd under rows f.d =, >= or <= b. W is a tridiagonal positive definite matrix (null: the identity), rows are sparse
lists of [column, value]. A case: `n`, `metric` (the diagonal and the one beside it), `rows`, `senses`, `rhs`, and what came
of it: `d`, or null where there is no solution. Every number of the input is short, so that it is read alike everywhere.
"""
import json

import clarabel
import numpy as np
from scipy import sparse

RANDOM = np.random.default_rng(1983)


def short(x):
    return np.round(np.asarray(x, float), 2).tolist()


def solve(n, metric, rows, senses, rhs):
    p = sparse.identity(n) if metric is None else sparse.diags([metric[1], metric[0], metric[1]], [-1, 0, 1])
    f = np.zeros((len(rows), n))
    for i, row in enumerate(rows):
        for column, value in row:
            f[i, column] += value
    b, s = np.array(rhs), np.array(senses)
    a = np.vstack([f[s == "="], -f[s == ">"], f[s == "<"]])
    h = np.concatenate([b[s == "="], -b[s == ">"], b[s == "<"]])
    cones = [clarabel.ZeroConeT(int(sum(s == "="))), clarabel.NonnegativeConeT(int(sum(s != "=")))]
    upper = sparse.triu(sparse.csc_matrix(2.0 * p), format="csc")
    # As exact as it gets: an interior point does not always come closer.
    for tolerance in (1e-12, 1e-10, 1e-8):
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
        answer = clarabel.DefaultSolver(upper, np.zeros(n), sparse.csc_matrix(a), h, cones, settings).solve()
        status = str(answer.status)
        if status in ("Solved", "PrimalInfeasible"):
            return list(answer.x) if status == "Solved" else None
    raise SystemExit(f"not solved: {status}")


def case(n, count, equations, banded, contradicting):
    metric = None
    if banded:
        metric = [short(RANDOM.uniform(1.0, 3.0, n)), short(RANDOM.uniform(-0.45, 0.45, n - 1))]
    rows, senses, rhs = [], [], []
    for k in range(count):
        width = int(RANDOM.integers(1, 5))
        first = int(RANDOM.integers(0, n - width + 1))
        rows.append([[first + j, v] for j, v in enumerate(short(RANDOM.uniform(-2.0, 2.0, width)))])
        senses.append("=" if k < equations else ">" if RANDOM.random() < 0.5 else "<")
        rhs.append(short(RANDOM.uniform(-1.5, 1.5)))
    if contradicting:
        k = count - 1
        rows.append([[c, -v] for c, v in rows[k]])
        senses.append(senses[k])
        side = 1.0 if senses[k] == ">" else -1.0
        rhs.append(short(side * 0.5 - rhs[k]))
    return {"n": n, "metric": metric, "rows": rows, "senses": senses, "rhs": rhs,
            "d": solve(n, metric, rows, senses, rhs)}


def main():
    cases = []
    for k in range(40):
        n = int(RANDOM.integers(4, 30))
        count = int(RANDOM.integers(2, 2 * n))
        cases.append(case(n, count, min(count, int(RANDOM.integers(0, 1 + n // 4))), k % 2 == 1, k % 8 == 7))
    print(json.dumps({"cases": cases}, separators=(",", ":")).replace('{"n"', '\n{"n"'))


main()
