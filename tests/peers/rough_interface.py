"""One rough interface under a white sky by this crate, by Mitsuba 3, and by quadrature with the masking-shadowing of each; see README.md."""

import argparse
import pathlib
import subprocess
import tempfile

import mitsuba as mi
import numpy as np
from scipy.special import beta, erf

ROOT = pathlib.Path(__file__).resolve().parents[2]
RENDER = ROOT / "target" / "release" / "examples" / "render"
INDEX = 1.5
SCENE = """<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="2"/></integrator>
    <sensor type="orthographic">
        <transform name="to_world"><lookat origin="{x}, 0, {z}" target="0, 0, 0" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/><rfilter type="box"/></film>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world"><scale value="1000"/></transform>
        <bsdf type="roughdielectric">
            <string name="distribution" value="{kind}"/><float name="alpha" value="{alpha}"/>
            <float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/>
        </bsdf>
    </shape>
    <emitter type="constant"/>
</scene>"""
CASES = [("ggx", 0.1, 0.2), ("ggx", 0.3, 0.2), ("ggx", 0.5, 0.2), ("ggx", 1, 0.5), ("ggx", 1, 0.2), ("beckmann", 1, 0.2), ("ggx", 1, -0.5), ("ggx", 1, -0.2)]


def exact(kind, alpha, cosine, n=1500):
    """R + T/eta² over the visible micro-normals, correlated by height and with independent masking and shadowing."""
    eta, o = (INDEX if cosine > 0 else 1 / INDEX), np.array([np.sqrt(1 - cosine**2), 0, abs(cosine)])

    def smith(z):
        a = z / (alpha * np.sqrt(1 - z * z))
        return 0.5 * (np.sqrt(1 + a**-2.0) - 1) if kind == "ggx" else 0.5 * (erf(a) - 1) + np.exp(-a * a) / (2 * a * np.sqrt(np.pi))

    u, azimuth = np.meshgrid((np.arange(n) + 0.5) / n, 2 * np.pi * (np.arange(n) + 0.5) / n)
    slope = u / (1 - u)
    density = ((1 + slope**2) ** -2 if kind == "ggx" else np.exp(-(slope**2))) / np.pi
    m = np.stack([-alpha * slope * np.cos(azimuth), -alpha * slope * np.sin(azimuth), np.ones_like(u)])
    masked = smith(o[2])
    weight = density * 2 * np.pi * slope / (1 - u) ** 2 * np.maximum(0, np.tensordot(o, m, 1)) / (o[2] * (1 + masked)) / n**2
    m /= np.linalg.norm(m, axis=0)
    c = np.maximum(np.tensordot(o, m, 1), 1e-12)
    far = np.sqrt(np.maximum(0, 1 - (1 - c * c) / eta**2))
    r = 0.5 * (((c - eta * far) / (c + eta * far)) ** 2 + ((eta * c - far) / (eta * c + far)) ** 2)
    up, down = 2 * c * m[2] - o[2], o[2] / eta - (c / eta - far) * m[2]
    reflected, refracted = (weight * r)[up > 0], (weight * (1 - r))[down > 0] / eta**2
    a, b = smith(up[up > 0]), smith(down[down > 0])
    correlated = (reflected * (1 + masked) / (1 + masked + a)).sum() + (refracted * (1 + masked) * beta(1 + masked, 1 + b)).sum()
    return correlated, (reflected / (1 + a)).sum() + (refracted / (1 + b)).sum()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--samples", type=int, default=4096)
    options = parser.parse_args()
    mi.set_variant("scalar_rgb")
    with tempfile.TemporaryDirectory() as directory:
        scene, out = pathlib.Path(directory) / "scene.xml", pathlib.Path(directory) / "image.exr"
        for kind, alpha, cosine in CASES:
            scene.write_text(SCENE.format(kind=kind, alpha=alpha, x=10 * np.sqrt(1 - cosine**2), z=10 * cosine))
            ours, theirs = [], []
            for seed in range(options.seeds):
                subprocess.run([*map(str, [RENDER, "--scene", scene, "--seed", seed + 1, "--samples", options.samples, "--out", out])], check=True, capture_output=True)
                ours.append(np.array(mi.Bitmap(str(out)), dtype=np.float64)[:, :, :3].mean())
                theirs.append(np.array(mi.render(mi.load_file(str(scene)), seed=seed, spp=options.samples), dtype=np.float64).mean())
            columns = [f"{np.mean(x):.4f} ± {np.std(x, ddof=1) / len(x) ** 0.5:.4f} ({value:.4f})" for x, value in zip((ours, theirs), exact(kind, alpha, cosine))]
            print(f"{kind:9} alpha {alpha}, cosine {cosine:4}: here {columns[0]}, Mitsuba {columns[1]}", flush=True)


if __name__ == "__main__":
    main()
