"""The product of α and a cubic's derivative, and its integral, in OpenCASCADE (peers/product.cpp, compiled here with the compiler of CXX
against Debian's libocct-modeling-data-dev; where that cannot be it says so) and in scipy: both interpolate at as many places as the space that
holds the product has coefficients, which is exact but for rounding. On the inputs of benches/fine_tuning.rs; processor time of one thread, median:

    OPENBLAS_NUM_THREADS=1 python3 benches/peers/fine_tuning.py
"""
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
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


def keep(who, n, seconds):
    """Tells it, and leaves it where the bench's table takes it from."""
    if len(sys.argv) > 1:
        to = pathlib.Path(sys.argv[1], "fine-tuning", who, str(n), "new")
        to.mkdir(parents=True, exist_ok=True)
        (to / "estimates.json").write_text(json.dumps({"median": {"point_estimate": 1e9 * seconds}}))
    print(f"{who}, {n}: {1e6 * seconds:.1f} µs", file=sys.stderr, flush=True)


def opencascade():
    here = pathlib.Path(__file__).parent
    include = os.environ.get("OPENCASCADE", "/usr/include/opencascade")
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder, "product")
        compiler = [os.environ.get("CXX", "g++"), "-O3", "-march=native", "-std=c++17", f"-I{include}"]
        try:
            command = [*compiler, here / "product.cpp", "-lTKMath", "-lTKernel", "-o", program]
            subprocess.run(command, check=True, capture_output=True, text=True)
        except (OSError, subprocess.CalledProcessError) as failed:
            print(f"SKIPPED: OpenCASCADE: {getattr(failed, 'stderr', None) or failed}", file=sys.stderr)
            return
        told = json.loads(subprocess.run([program], check=True, capture_output=True, text=True).stdout)
    for case in told:
        if case["status"] != 0 or not case["off"] < 1e-12:
            sys.exit(f"OpenCASCADE's product is off: {case}")
        keep("OpenCASCADE", case["n"], case["seconds"])


opencascade()
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
    keep("scipy", n, statistics.median(samples))
