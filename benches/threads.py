"""How much faster two threads are than one, and how much of the loss is the machine's: two processes of one thread each, side by side, against one alone.

cargo build --release --example render && python3 benches/threads.py
"""

import argparse
import pathlib
import re
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]


def start(options, integrator, threads, processors, out):
    command = ["taskset", "-c", processors, options.render, "--scene", "cornell-box", "--size", "256x256", "--max-bounces", "4"]
    command += ["--integrator", integrator, "--samples", options.samples, "--threads", threads, "--out", f"{out}/{processors}.exr"]
    return subprocess.Popen([*map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)


def wall(processes):
    """The longest rendering, without start and end of its process."""
    return max(float(re.search(r"time +([\d.]+) s on the wall", process.communicate()[0])[1]) for process in processes)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--render", default=ROOT / "target" / "release" / "examples" / "render", help="the example's binary")
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--repetitions", type=int, default=5)
    options = parser.parse_args()
    print("| integrator | one thread [s] | two processes, efficiency | two threads, efficiency | threads / processes |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as out:
        for integrator in ("path-tracing", "light-tracing", "bidirectional"):
            alone, ceiling, found = [], [], []
            for _ in range(options.repetitions):
                one = statistics.mean(wall([start(options, integrator, 1, processor, out)]) for processor in "01")
                alone.append(one)
                ceiling.append(one / wall([start(options, integrator, 1, processor, out) for processor in "01"]))
                found.append(one / wall([start(options, integrator, 2, "0,1", out)]) / 2)
            spread = lambda values: f"{statistics.median(values):.3f} ({min(values):.3f}–{max(values):.3f})"
            ratios = [f / c for f, c in zip(found, ceiling)]
            print(f"| {integrator} | {spread(alone)} | {spread(ceiling)} | {spread(found)} | {spread(ratios)} |", flush=True)


if __name__ == "__main__":
    main()
