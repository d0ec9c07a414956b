"""W5 in numpy: the area form of a periodic cubic, and a volume with its gradient, by the same Gauss rules on the same inputs
as benches/area_volume.rs. Processor time of one thread, median; needs numpy and scipy:

    OPENBLAS_NUM_THREADS=1 python3 benches/peers/area_volume.py
"""
import statistics
import time

import numpy as np
import scipy.sparse as sp


def measure(name, size, work):
    work()
    samples = []
    for _ in range(31):
        start = time.process_time()
        work()
        samples.append(time.process_time() - start)
    print(f"| {name} | {size} | {1e3 * statistics.median(samples):.3f} ms |", flush=True)


def knots(n):
    """n spans of lengths 0.5 + u_k, u_k by x <- (1664525 x + 1013904223) mod 2^32 from 5."""
    x, at, out = 5, 0.0, [0.0]
    for _ in range(n):
        x = (1664525 * x + 1013904223) % 2**32
        at += 0.5 + x / 2**32
        out.append(at)
    return np.array(out)


def functions(s, m):
    """Values and slopes of the four cubics at m Gauss points of every span (spans, m, 4), and weights (spans, m)."""
    n, period = len(s) - 1, s[-1]
    t = np.concatenate([s[-4:-1] - period, s, s[1:4] + period])
    nodes, shares = np.polynomial.legendre.leggauss(m)
    h = np.diff(s)[:, None]
    u, i = s[:-1, None] + h * (nodes + 1) / 2, np.arange(n)[:, None] + 3
    rows = [np.ones_like(u)]
    for d in (1, 2, 3):
        lower, carry, rows = rows, 0.0, []
        for j in range(d):
            left, right = t[i + 1 - d + j], t[i + 1 + j]
            share = lower[j] / (right - left)
            rows.append(carry + (right - u) * share)
            carry = (u - left) * share
        rows.append(carry)
    quotients = [3 * lower[j] / (t[i + 1 + j] - t[i - 2 + j]) for j in range(3)]
    slopes = [-quotients[0], quotients[0] - quotients[1], quotients[1] - quotients[2], quotients[2]]
    return np.stack(rows, 2), np.stack(slopes, 2), h * shares / 2


def form(s):
    n = len(s) - 1
    values, slopes, weights = functions(s, 3)
    half = np.einsum("sg,sgi,sgj->sij", weights, values, slopes)
    local = half - half.transpose(0, 2, 1)
    at = (np.arange(n)[:, None] + np.arange(4)) % n
    entries = (local.ravel(), (np.repeat(at, 4, 1).ravel(), np.tile(at, (1, 4)).ravel()))
    return sp.coo_matrix(entries, shape=(n, n)).tocsr()


def torus(n):
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    a, b = 2 * np.pi * i / n, 2 * np.pi * j / n
    r = 0.4 + 0.05 * np.sin(3 * a + 2 * b)
    return np.stack([(1 + r * np.cos(b)) * np.cos(a), (1 + r * np.cos(b)) * np.sin(a), r * np.sin(b)], 2)


def volume(points):
    """The volume and its gradient by z: a third of what ours gives."""
    n = len(points)
    values, slopes, weights = functions(np.arange(n + 1.0), 5)
    at = np.repeat(((np.arange(n)[:, None] + np.arange(4)) % n)[:, None, :], 5, 1)
    starts = np.arange(0, 20 * n + 1, 4)
    matrix = lambda x: sp.csr_matrix((x.ravel(), at.ravel(), starts), shape=(5 * n, n))
    plain, slope, w = matrix(values), matrix(slopes), weights.ravel()
    take = lambda u, v, c: (v @ (u @ c).T).T
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    flux = take(slope, plain, x) * take(plain, slope, y) - take(plain, slope, x) * take(slope, plain, y)
    flux *= w[:, None] * w[None, :]
    return float((take(plain, plain, z) * flux).sum()), plain.T @ (plain.T @ flux.T).T


for n in (1000, 10_000, 100_000):
    s = knots(n)
    assert abs(form(s).sum(1)).max() < 1e-9, "constants enclose nothing"
    measure("W5 area form", n, lambda: form(s))
for n in (20, 50, 100):
    points = torus(n)
    value, gradient = volume(points)
    assert abs((gradient * points[..., 2]).sum() / value - 1) < 1e-12
    measure("W5 volume and gradient", n, lambda: volume(points))
