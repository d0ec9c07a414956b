"""OpenSubdiv's refinement of the cage of benches/subdivision.rs, on one thread, in doubles: topology and vertices of five levels; and with
the full topology of the last one. Compiles peers/opensubdiv.cpp with the compiler of CXX (g++) against the library of Debian's
libosd-dev; where it lies elsewhere, OPENSUBDIV names the folder with `include` and `lib`. Where it cannot be compiled it says so.

    python3 benches/peers/subdivision.py
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

here = pathlib.Path(__file__).parent
root = os.environ.get("OPENSUBDIV")
where = [f"-I{root}/include", f"-L{root}/lib", f"-Wl,-rpath,{root}/lib"] if root else []
with tempfile.TemporaryDirectory() as folder:
    program = pathlib.Path(folder, "opensubdiv")
    command = [os.environ.get("CXX", "g++"), "-O3", "-march=native", "-std=c++17", str(here / "opensubdiv.cpp"), *where, "-losdCPU", "-o", str(program)]
    try:
        subprocess.run(command, check=True, capture_output=True, text=True)
    except (OSError, subprocess.CalledProcessError) as failed:
        print(f"SKIPPED: OpenSubdiv: {getattr(failed, 'stderr', None) or failed}", file=sys.stderr)
        sys.exit()
    told = json.loads(subprocess.run([program], check=True, capture_output=True, text=True).stdout)
seconds = {step["step"]: step["seconds"] for step in told["steps"]}
peak = {step["step"]: step["peak_mib"] for step in told["steps"]}
points = seconds["interpolate, double"]
for who, topology in (("OpenSubdiv", "refine topology"), ("OpenSubdiv, full", "refine topology, full in the last level")):
    time = 1e9 * (seconds[topology] + points)
    if len(sys.argv) > 1:
        to = pathlib.Path(sys.argv[1], "Catmull-Clark to a million faces", who, "5", "new")
        to.mkdir(parents=True, exist_ok=True)
        (to / "estimates.json").write_text(json.dumps({"median": {"point_estimate": time}}))
    print(f"{told['version']}: {who}: {1e-6 * time:.1f} ms, at most {peak[topology]:.0f} MiB so far", file=sys.stderr)
