"""Fairing in scipy: least bending under sixteen points that stay, on the same inputs as benches/fairing.rs. The energy's matrix and
the constraints in one sparse matrix, factored by SuperLU. Processor time of one thread, median; needs numpy and scipy:

    OPENBLAS_NUM_THREADS=1 python3 benches/peers/fairing.py
"""
import statistics
import time

import numpy as np
import scipy.sparse as sp
from scipy.interpolate import BSpline
from scipy.sparse.linalg import splu


def measure(name, size, work):
    energy = work()
    samples = []
    for _ in range(7):
        start = time.process_time()
        work()
        samples.append(time.process_time() - start)
    print(f"| {name} | {size} | {1e3 * statistics.median(samples):.3f} ms | energy {energy:.9e}", flush=True)


def knots(n):
    """n - 3 spans of lengths 0.5 + u_k over [0, 1], u_k by x <- (1664525 x + 1013904223) mod 2^32 from 5."""
    x, at, inner = 5, 0.0, [0.0]
    for _ in range(n - 3):
        x = (1664525 * x + 1013904223) % 2**32
        at += 0.5 + x / 2**32
        inner.append(at)
    return np.concatenate([[0.0] * 3, np.array(inner) / at, [1.0] * 3])


def rows(t, u, order):
    """Values of the order-th derivatives of all cubics at u, sparse."""
    if order == 0:
        return BSpline.design_matrix(u, t, 3)
    lower = BSpline.design_matrix(u, t[order:-order], 3 - order)
    for d in range(order, 0, -1):
        p = 4 - d
        inner = t[d - 1 : len(t) - d + 1]
        width = inner[p + 1 : -1] - inner[1 : -p - 1]
        share = p / width
        lower = lower @ sp.diags([-share, share], [0, 1], shape=(len(share), len(share) + 1))
    return lower.tocsr()


def grams(t):
    """Integrals of products of the cubics' derivatives of orders 0, 1 and 2."""
    nodes, shares = np.polynomial.legendre.leggauss(4)
    breaks = t[3:-3]
    h = np.diff(breaks)[:, None]
    u, w = (breaks[:-1, None] + h * (nodes + 1) / 2).ravel(), sp.diags((h * shares / 2).ravel())
    return [(lambda r: r.T @ w @ r)(rows(t, u, order)) for order in range(3)]


def solve(energy, stay, points):
    k = stay.shape[0]
    matrix = sp.bmat([[energy, stay.T], [stay, sp.csr_matrix((k, k))]], format="csc")
    right = np.concatenate([np.zeros_like(points), stay @ points])
    x = splu(matrix).solve(right)[: len(points)]
    return float((x * (energy @ x)).sum())


def curve(n):
    i = np.arange(n)
    r = 1 + 0.3 * np.sin(0.31 * i)
    points = np.stack([np.cos(0.05 * i) * r, np.sin(0.05 * i) * r, 0.01 * i], 1)
    t = knots(n)
    return solve(grams(t)[2], rows(t, (np.arange(16) + 0.5) / 16, 0), points)


def surface(n):
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    z = 0.1 * np.sin(0.7 * i) * np.cos(0.5 * j)
    points = np.stack([i / (n - 1), j / (n - 1), z], 2).reshape(-1, 3)
    t = knots(n)
    m, s, b = grams(t)
    at = rows(t, np.arange(4) / 4 + 0.125, 0)
    return solve(sp.kron(b, m) + 2 * sp.kron(s, s) + sp.kron(m, b), sp.kron(at, at), points)


for n in (100, 1000, 10_000):
    measure("fair curve", n, lambda: curve(n))
for n in (25, 50, 100):
    measure("fair surface", n, lambda: surface(n))
