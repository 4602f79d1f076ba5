"""Error times processor time of path tracing here and in Mitsuba, scene by scene; see README.md."""

import argparse
import pathlib

import numpy as np

import scenes
from renderers import OUT, Here, Mitsuba, Task, save

# Without roulette, deeper paths cost time and hold no light; the same limit for both in any case.
MOST_EVENTS = 7


class Found:
    """Images of one renderer that differ in their seeds, and what each took."""

    def __init__(self, renderer, samples, seeds):
        runs = [renderer.render(samples, seed) for seed in range(seeds)]
        self.images = np.array([run.image for run in runs])
        self.seconds = np.mean([run.seconds for run in runs])
        self.samples = samples

    def errors(self, scale):
        """Mean squared errors of the single images, relative to the square of `scale`, each against the mean of all, which takes n/(n - 1)."""
        n = len(self.images)
        return ((self.images - self.images.mean(0)) ** 2 / scale).mean((1, 2, 3)) * n / (n - 1)


def scale(*found):
    """The denominator of relMSE: the squared image, and a hundredth of the square of its mean."""
    image = np.mean([f.images.mean(0) for f in found], 0)
    return image**2 + 0.01 * image.mean() ** 2


def compare(here, there):
    """Ratio of error times time with its range of 95 %."""
    costs = [(f.errors(scale(here, there)), f.seconds) for f in (here, there)]
    ratio = costs[0][0].mean() * costs[0][1] / (costs[1][0].mean() * costs[1][1])
    spread = np.sqrt(sum((e.std(ddof=1) / e.mean()) ** 2 / len(e) for e, _ in costs))
    factor = np.exp(2.14 * spread)  # Student's t with 14 degrees of freedom, as of 8 seeds each
    return ratio, ratio / factor, ratio * factor


def difference(here, there):
    """Difference of the means of the image and its standard error, both relative; root mean square over 8 × 8 blocks in standard errors."""
    means = [f.images.mean((1, 2, 3)) for f in (here, there)]
    relative = means[0].mean() / means[1].mean() - 1
    error = np.sqrt(sum(m.var(ddof=1) / len(m) for m in means)) / means[1].mean()
    parts = [np.array([[b.mean((1, 2)) for b in np.array_split(row, 8, 2)] for row in np.array_split(f.images, 8, 1)]) for f in (here, there)]
    deviation = np.sqrt(sum(p.var(2, ddof=1) / p.shape[2] for p in parts))
    lit = deviation > 1e-4 * parts[1].mean(2)
    z = (parts[0].mean(2) - parts[1].mean(2))[lit] / deviation[lit]
    return relative, error, np.sqrt((z**2).mean())


def row(title, here, there):
    relative, error, blocks = difference(here, there)
    ratio, low, high = compare(here, there)
    print(
        f"| {title} | {here.samples} in {here.seconds:.2f} s | {there.samples} in {there.seconds:.2f} s | {relative:+.2%} ± {error:.2%} "
        f"| {blocks:.2f} | {ratio:.2f} [{low:.2f}, {high:.2f}] |",
        flush=True,
    )


def prepare(source, size):
    """The scene's files, copied, and its task at a size of about `size` pixels per side."""
    path, names = scenes.copy(OUT, source)
    parameters = {}
    for side in (["resx", "resy"], ["width", "height"], ["res"]):
        if set(side) <= set(names):
            parameters = dict.fromkeys(side, size)
    if "integrator" in names:
        parameters["integrator"] = "path"
    depth = int(names["max_depth"])
    return Task(path, MOST_EVENTS if depth < 0 else min(depth - 1, MOST_EVENTS), parameters)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="+", type=pathlib.Path, help="Mitsuba files")
    parser.add_argument("--samples", type=int, default=64, help="per pixel here; Mitsuba gets the same time")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--sampler", default="sobol", help="here: independent, stratified or sobol")
    parser.add_argument("--variants", default="llvm_ad_rgb,scalar_rgb")
    parser.add_argument("--samplers", default="independent,multijitter,orthogonal", help="of Mitsuba; the best is compared in full")
    options = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    print("| scene, Mitsuba's variant and sampler | here, samples | there | mean of the image | blocks, z | error × time, here / there |\n|---|---|---|---|---|---|")
    for source in options.scenes:
        task = prepare(source, options.size)
        here = Found(Here(task, sampler=options.sampler), options.samples, options.seeds)
        name = source.parent.name
        save(here.images.mean(0), f"{name} here")
        for variant in options.variants.split(","):
            best = None
            for sampler in options.samplers.split(","):
                mitsuba = Mitsuba(task, variant, sampler=sampler)
                # The power of two whose time is next to the time here; some samplers take the next number that they can.
                power = np.log2(16 * here.seconds / mitsuba.render(16, 0).seconds)
                samples = mitsuba.count(2 ** max(4, round(power)))
                trial = Found(mitsuba, samples, 2)
                cost = trial.errors(scale(here)).mean() * trial.seconds
                if best is None or cost < best[0]:
                    best = (cost, sampler, mitsuba, samples)
            _, sampler, mitsuba, samples = best
            there = Found(mitsuba, samples, options.seeds)
            save(there.images.mean(0), f"{name} {variant}")
            row(f"{name}, `{variant}`, {sampler}", here, there)


if __name__ == "__main__":
    main()
