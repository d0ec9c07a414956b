"""The product of α and a cubic's derivative, and its integral, in scipy: interpolated at the Greville points of the space that holds
the product, which is exact but for rounding. On the inputs of benches/fine_tuning.rs; processor time of one thread, median:

    OPENBLAS_NUM_THREADS=1 python3 benches/peers/fine_tuning.py
"""
import statistics
import time

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline


def sequence(seed, count):
    x, out = seed, []
    for _ in range(count):
        x = (1664525 * x + 1013904223) % 2**32
        out.append(x / 2**32)
    return np.array(out)


def knots(n):
    inner = np.concatenate([[0.0], np.cumsum(0.5 + sequence(5, n - 3))])
    return np.concatenate([[0.0] * 3, inner / inner[-1], [1.0] * 3])


for n in (12, 100, 1000, 10_000):
    i = np.arange(n)
    r = 1 + 0.3 * np.sin(0.31 * i)
    points = np.stack([np.cos(0.05 * i) * r, np.sin(0.05 * i) * r, 0.01 * i], 1)
    slope = BSpline(knots(n), points, 3).derivative()
    slope = BSpline(slope.t[1:-1] if len(slope.t) == n + 4 else slope.t, slope.c[: n - 1], 2)
    alpha = BSpline(slope.t, 0.9 + 0.2 * sequence(7, n - 1), 2)
    inner = np.repeat(np.unique(slope.t)[1:-1], 3)
    t = np.concatenate([[0.0] * 5, inner, [1.0] * 5])
    count = len(t) - 5
    greville = np.array([t[k + 1 : k + 5].mean() for k in range(count)])

    def work():
        product = make_interp_spline(greville, slope(greville) * alpha(greville)[:, None], k=4, t=t)
        return product.antiderivative()

    samples = []
    for _ in range(15):
        start = time.process_time()
        work()
        samples.append(time.process_time() - start)
    print(f"| scipy, by interpolation | {n} | {1e6 * statistics.median(samples):.1f} µs", flush=True)
