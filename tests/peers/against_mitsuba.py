"""Holds this crate against Mitsuba 3 on the scenes of tests/data/mitsuba; see README.md."""

import argparse
import pathlib
import subprocess
import tempfile

import mitsuba as mi
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ROOT / "tests" / "data" / "mitsuba"
RENDER = ROOT / "target" / "release" / "examples" / "render"
BLOCKS = 4


def load(path):
    """An image file as array of linear RGB."""
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.array(bitmap, dtype=np.float64)


def blocks(image, columns=BLOCKS, rows=BLOCKS):
    """Means of the image's blocks."""
    y = np.linspace(0, image.shape[0], rows + 1).astype(int)
    x = np.linspace(0, image.shape[1], columns + 1).astype(int)
    return np.array([[image[y[j] : y[j + 1], x[i] : x[i + 1]].mean((0, 1)) for i in range(columns)] for j in range(rows)])


def theirs(name, seeds, samples):
    scene = mi.load_file(str(SCENES / f"{name}.xml"))
    return [np.array(mi.render(scene, seed=seed, spp=samples), dtype=np.float64)[:, :, :3] for seed in range(seeds)]


def ours(name, seeds, samples, integrator):
    images = []
    with tempfile.TemporaryDirectory() as directory:
        out = pathlib.Path(directory) / "image.exr"
        for seed in range(seeds):
            command = [RENDER, "--scene", SCENES / f"{name}.xml", "--strict", "--seed", str(seed + 1), "--samples", str(samples)]
            subprocess.run([*map(str, command), "--integrator", integrator, "--out", str(out)], check=True, capture_output=True)
            images.append(load(out))
    return images


def compare(name, options):
    a = ours(name, options.seeds, options.samples, options.integrator)
    b = theirs(name, options.seeds, options.samples)
    mean = lambda images: np.array([image.mean((0, 1)) for image in images])
    parts = lambda images: np.array([blocks(image) for image in images])

    def z(x, y):
        error = np.sqrt((x.var(0, ddof=1) + y.var(0, ddof=1)) / len(x))
        return (x.mean(0) - y.mean(0)) / np.maximum(error, 1e-5 * np.abs(y.mean(0)) + 1e-12)  # Mitsuba sums in single precision

    whole, block = z(mean(a), mean(b)), z(parts(a), parts(b))
    ratio = mean(a).mean(0) / mean(b).mean(0) - 1
    error = mean(b).std(0, ddof=1) / mean(b).mean(0) / np.sqrt(options.seeds) * np.sqrt(2)
    lit = parts(b).mean(0) > 0
    difference = parts(a).mean(0)[lit] / parts(b).mean(0)[lit] - 1
    print(
        f"{name:18} mean {np.array2string(100 * ratio, precision=3)} % (error {100 * error.max():.2f} %), "
        f"|z| {np.abs(whole).max():.1f}; blocks: |z| up to {np.abs(block).max():.1f}, root mean square {np.sqrt((block**2).mean()):.2f}, "
        f"largest difference {100 * np.abs(difference).max():.2f} %",
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", help="names of scenes; all by default")
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--integrator", default="path-tracing")
    options = parser.parse_args()
    mi.set_variant("scalar_rgb")
    for name in options.scenes or sorted(path.stem for path in SCENES.glob("*.xml")):
        compare(name, options)


if __name__ == "__main__":
    main()
