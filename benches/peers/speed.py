"""Samples per second of processor time here and in other renderers, programs in turn; see README.md."""

import argparse
import pathlib

import numpy as np

import scenes
from renderers import OUT, Here, LuxCore, Mitsuba, Task, save


def spread(values, digits=2):
    """Median and range."""
    return f"{np.median(values):.{digits}f} ({min(values):.{digits}f}–{max(values):.{digits}f})"


def table(title, members, samples, repetitions):
    """One row for each renderer; the first is what the others are compared with."""
    runs = {name: [] for name in members}
    for seed in range(repetitions):
        for name, (renderer, factor) in members.items():
            runs[name].append(renderer.render(samples * factor, seed))
    first = next(iter(runs))
    print(f"\n{title}\n\n| renderer | M samples/s | here / there | mean of the image / here |\n|---|---|---|---|")
    mean = {name: np.array([run.image.mean() for run in found]) for name, found in runs.items()}
    for name, found in runs.items():
        ratios = [here.speed / there.speed for here, there in zip(runs[first], found)]
        error = np.hypot(*(mean[n].std(ddof=1) / mean[n].mean() / len(mean[n]) ** 0.5 for n in (first, name))) if repetitions > 1 else np.nan
        ratio = f"{mean[name].mean() / mean[first].mean() - 1:+.2%} ± {error:.2%}"
        save(np.mean([run.image for run in found], 0), f"{title} {name}")
        print(f"| {name} | {spread([run.speed / 1e6 for run in found], 3)} | {spread(ratios)} | {ratio} |", flush=True)


def mitsubas(task, integrator):
    # The vectorised variant is made for many samples at a time.
    return {f"Mitsuba `{variant}`": (Mitsuba(task, variant, integrator), factor) for variant, factor in (("llvm_ad_rgb", 4), ("scalar_rgb", 1))}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tables", nargs="*", help="path, light, bidirectional, or the name of a mesh; the first three by default")
    parser.add_argument("--meshes", type=pathlib.Path, help="directory of meshes as of the example raykernel")
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--samples", type=int, default=16, help="per pixel; four times as many for Mitsuba's vectorised variants")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--events", type=int, default=7, help="the most scattering events")
    options = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    size = {"width": options.size, "height": options.size}
    for name in options.tables or ["path", "light", "bidirectional"]:
        is_box = name in ("path", "light", "bidirectional")
        scene = scenes.cornell_box(OUT) if is_box else scenes.mesh(OUT, options.meshes, name)
        task = Task(scene, options.events, size)
        integrator = {"light": "light-tracing", "bidirectional": "bidirectional"}.get(name, "path-tracing")
        members = {integrator: (Here(task, integrator), 1)}
        if name == "bidirectional":
            # It limits the edges of each walk, not of the path: one limit draws more than here, the other less.
            for depth in (options.events + 1, (options.events + 1) // 2):
                members[f"LuxCore `BIDIRCPU`, walks of {depth} edges"] = (LuxCore(task, depth), 1)
        else:
            members |= mitsubas(task, "ptracer" if name == "light" else "path")
        table(f"Cornell box, {integrator}" if is_box else f"{name}, {integrator}", members, options.samples, options.repetitions)


if __name__ == "__main__":
    main()
