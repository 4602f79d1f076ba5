"""Holds images of several seeds against a reference, block by block, in standard errors of both; see README.md."""

import argparse

import mitsuba as mi
import numpy as np

CELL = 4


def load(path):
    """An image file as array of linear RGB."""
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.array(bitmap, dtype=np.float64)


def tiles(image, columns, rows):
    """The pixels of each block, of which all have the same size."""
    height, width, _ = image.shape
    return image.reshape(rows, height // rows, columns, width // columns, 3).transpose(0, 2, 1, 3, 4).reshape(rows, columns, -1, 3)


def blocks(image, columns, rows):
    return tiles(image, columns, rows).mean(2)


def noise(reference, columns, rows):
    """Variance of the means of a reference's blocks: cells of pixels against their four neighbours, by the median, which edges do not disturb."""
    height, width, _ = reference.shape
    cells = reference.reshape(height // CELL, CELL, width // CELL, CELL, 3).mean((1, 3))
    p = np.pad(cells, ((1, 1), (1, 1), (0, 0)), mode="edge")
    squares = 0.8 * (cells - 0.25 * (p[:-2, 1:-1] + p[2:, 1:-1] + p[1:-1, :-2] + p[1:-1, 2:])) ** 2
    parts = tiles(squares, columns, rows)
    return np.median(parts, 2) / 0.4549 / parts.shape[2]  # 0.4549 is the median of a squared normal number


def coefficient(base, more, reference, columns, rows):
    """By how much of the images `more` the reference exceeds the images `base`, and the error of that by resampling the blocks."""
    a, b, r = blocks(base.mean(0), columns, rows), blocks(more.mean(0), columns, rows), blocks(reference, columns, rows)
    own = np.array([blocks(image, columns, rows) for image in base]).var(0, ddof=1) / len(base)
    variance = own + noise(reference, columns, rows)
    # Blocks of heavy tails have no standard error to speak of.
    weight = ((variance < (0.03 * r) ** 2).all(-1) & (variance > 0).all(-1))[..., None] / np.maximum(variance, 1e-30)
    upper, lower = ((weight * x).sum(-1).ravel() for x in ((r - a) * b, b * b))
    picks = np.random.default_rng(1).integers(0, upper.size, (2000, upper.size))
    return upper.sum() / lower.sum(), np.std(upper[picks].sum(1) / lower[picks].sum(1))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("reference")
    parser.add_argument("images", nargs="+", help="images of at least two seeds")
    parser.add_argument("--more", nargs="*", default=[], help="images of the next scattering event: how much of it does the reference have?")
    parser.add_argument("--blocks", default="16x16", help="columns and rows")
    options = parser.parse_args()
    mi.set_variant("scalar_rgb")
    columns, rows = map(int, options.blocks.split("x"))
    reference, images = load(options.reference), np.array([load(path) for path in options.images])
    means, r = np.array([blocks(image, columns, rows) for image in images]), blocks(reference, columns, rows)
    mean, error = means.mean(0), means.std(0, ddof=1) / np.sqrt(len(means))
    lit = (r > 1e-6 * r.max()).all(-1)
    ratio, z = mean[lit] / r[lit] - 1, (mean - r)[lit] / np.sqrt(error**2 + noise(reference, columns, rows))[lit]
    whole = images.mean((1, 2)) / reference.mean((0, 1))
    print(f"mean {100 * (whole.mean(0) - 1)} % (error {100 * whole.std(0, ddof=1).max() / np.sqrt(len(images)):.2f} %)")
    print(f"blocks: median {100 * np.median(np.abs(ratio)):.2f} % (error {100 * np.median(error[lit] / r[lit]):.2f} %), root mean square of z {np.sqrt((z**2).mean()):.2f}")
    beyond = (np.abs(ratio) > 0.02).any(-1)
    print(f"beyond 2 %: {beyond.sum()} of {len(beyond)} blocks")
    for (row, column), difference, score in zip(np.argwhere(lit)[beyond], ratio[beyond], z[beyond]):
        print(f"  row {row}, column {column}: {100 * difference} %, z {score}")
    if options.more:
        value, error = coefficient(images, np.array([load(path) for path in options.more]), reference, columns, rows)
        print(f"the reference minus the images has {value:.4f} ± {error:.4f} times the next event")


if __name__ == "__main__":
    main()
