"""W5 in numpy: the area form of a periodic cubic, a volume with its gradient, and events that keep an area or a volume, by the
same Gauss rules and the same iteration on the same inputs as benches/area_volume.rs. Processor time of one thread, median.

benches/run.sh area_volume runs it just before ours, with the folder of criterion's results as argument: there it leaves its
medians, so that one table shows both. By hand, with numpy and scipy:

    OPENBLAS_NUM_THREADS=1 python3 benches/peers/area_volume.py
"""
import json
import pathlib
import statistics
import sys
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
    median = 1e9 * statistics.median(samples)
    if len(sys.argv) > 1:
        folder = pathlib.Path(sys.argv[1], name, "numpy", str(size), "new")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "estimates.json").write_text(json.dumps({"median": {"point_estimate": median}}))
    else:
        print(f"| {name} | {size} | {1e-6 * median:.3f} ms |", flush=True)


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


def rules(n):
    """What a volume needs of a uniform periodic cubic space once: values and slopes at five points a span, and weights."""
    values, slopes, weights = functions(np.arange(n + 1.0), 5)
    at = np.repeat(((np.arange(n)[:, None] + np.arange(4)) % n)[:, None, :], 5, 1)
    starts = np.arange(0, 20 * n + 1, 4)
    matrix = lambda x: sp.csr_matrix((x.ravel(), at.ravel(), starts), shape=(5 * n, n))
    return matrix(values), matrix(slopes), weights.ravel()


def volume(points, rule):
    """The volume and its gradient by x, y and z."""
    plain, slope, w = rule
    take = lambda u, v: np.stack([(v @ (u @ points[..., a]).T).T for a in range(3)], 2)
    flux = np.cross(take(slope, plain), take(plain, slope)) * (w[:, None] * w[None, :])[..., None]
    gradient = np.stack([plain.T @ (plain.T @ flux[..., a].T).T for a in range(3)], 2)
    return float((gradient * points).sum()) / 3, gradient


def dragged(points, rows, change, kept, measured):
    """The least adjustment that changes `rows @ points` so and keeps a measure, as a session finds it: the linear rows are met
    by `C`, known beforehand; the gradients, without what disturbs those, by Newton's iteration to the same tolerances."""
    response = np.linalg.solve(rows @ rows.T, rows).T
    linear = response @ change
    d = linear.copy()
    for _ in range(200):
        value, gradient = measured(points + d)
        q = gradient - response @ (rows @ gradient)
        square = (gradient * q).sum()
        tangential = linear - d
        tangential -= (gradient * tangential).sum() / square * q
        step = (kept - value) / square * q + tangential
        if abs(value / kept - 1) <= 2e-13 and np.linalg.norm(step) <= 1e-6 * np.linalg.norm(d):
            return d
        d += step
    raise RuntimeError("it does not converge")


def ring(n):
    a = 2 * np.pi * np.arange(n) / n
    r = 1 + 0.2 * np.sin(3 * a)
    return np.stack([r * np.cos(a), r * np.sin(a), 0 * a], 1)


def area_event(n):
    s, points = knots(n), ring(n)
    phi = form(s)
    rows = np.zeros((2, n))
    for row, share in zip(rows, (0.25, 0.75)):
        u = share * s[-1]
        span = np.searchsorted(s, u, side="right") - 1
        t = np.concatenate([s[-4:-1] - s[-1], s, s[1:4] + s[-1]])
        values, i = [1.0], span + 3
        for d in (1, 2, 3):
            carry, lower, values = 0.0, values, []
            for j in range(d):
                part = lower[j] / (t[i + 1 + j] - t[i + 1 - d + j])
                values.append(carry + (t[i + 1 + j] - u) * part)
                carry = (u - t[i + 1 - d + j]) * part
            values.append(carry)
        row[(span + np.arange(4)) % n] = values

    def measured(p):
        fx, fy = phi @ p[:, 0], phi @ p[:, 1]
        return 0.5 * float(p[:, 0] @ fy), 0.5 * np.stack([fy, -fx, 0 * fx], 1)

    kept = measured(points)[0]
    change = np.array([[0.05, 0.01, 0.0], [0.0, 0.0, 0.0]])
    d = dragged(points, rows, change, kept, measured)
    assert abs(measured(points + d)[0] / kept - 1) < 1e-12 and abs(rows @ d - change).max() < 1e-12
    return lambda: dragged(points, rows, change, kept, measured)


def volume_event(n):
    net, rule = torus(n), rules(n)
    # The stencil of a uniform cubic at a knot, a quarter of the way around.
    share = np.zeros(n)
    share[(n // 4 + np.arange(3)) % n] = np.array([1, 4, 1]) / 6
    rows = np.outer(share, share).reshape(1, -1)
    points = net.reshape(-1, 3)

    def measured(p):
        value, gradient = volume(p.reshape(net.shape), rule)
        return value, gradient.reshape(-1, 3)

    kept, change = measured(points)[0], np.array([[0.05, 0.01, 0.0]])
    d = dragged(points, rows, change, kept, measured)
    assert abs(measured(points + d)[0] / kept - 1) < 1e-12
    return lambda: dragged(points, rows, change, kept, measured)


for n in (1000, 10_000, 100_000):
    s = knots(n)
    assert abs(form(s).sum(1)).max() < 1e-9, "constants enclose nothing"
    measure("W5 area form", n, lambda: form(s))
for n in (20, 50, 100):
    points, rule = torus(n), rules(n)
    value, gradient = volume(points, rule)
    sides = [float((gradient[..., a] * points[..., a]).sum()) / value for a in range(3)]
    assert abs(np.array(sides) - 1).max() < 1e-12, "all three orders of the axes agree"
    measure("W5 volume and gradient", n, lambda: volume(points, rule))
for n in (100, 1000, 10_000):
    measure("W5 area event", n, area_event(n))
for n in (20, 50, 100):
    measure("W5 volume event", n, volume_event(n))
