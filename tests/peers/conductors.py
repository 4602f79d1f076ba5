"""Prints the table of src/import/conductors.rs from the spectra that are installed with Mitsuba; see README.md."""

import pathlib
import re

import mitsuba as mi
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
SPECTRA = pathlib.Path(mi.__file__).parent / "data" / "ior"
WAVELENGTHS = np.arange(360.0, 831.0)
TO_RGB = np.array([[3.240479, -1.537150, -0.498535], [-0.969256, 1.875991, 0.041556], [0.055648, -0.204043, 1.057311]])


def observer():
    """RGB weights of each wavelength: the observer's under daylight, from the table that the crate has."""
    text = (ROOT / "src/import/spectrum.rs").read_text()
    rows = np.array([[float(x) for x in row.split(",")] for row in re.findall(r"^    \[([^\]]*)\],$", text, re.MULTILINE)])
    x, y, z, daylight = (np.interp(WAVELENGTHS, 360 + 5 * np.arange(len(rows)), column) for column in rows.T)
    return TO_RGB @ (np.array([x, y, z]) * daylight) / (y * daylight).sum()


def reflectance(n, k):
    return ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)


def fitted(n, k, weights):
    """RGB of n, and k such that the RGB of the reflectance at normal incidence is met."""
    exact = reflectance(n, k)
    r = np.clip(weights @ exact, 0, exact.max())
    eta = np.clip(weights @ n, n.min(), n.max())
    square = (r * (eta + 1) ** 2 - (eta - 1) ** 2) / (1 - r)
    # No k would do where n alone reflects more.
    eta = np.where(square < 0, (1 + np.sqrt(r)) / (1 - np.sqrt(r)), eta)
    return eta, np.sqrt(np.maximum(square, 0)), r


def spectrum(name):
    """Index and extinction at all wavelengths; zeros are gaps in the source."""
    (x, n), (y, k) = (np.loadtxt(SPECTRA / f"{name}.{part}.spd").T for part in ("eta", "k"))
    known = n > 0
    return np.interp(WAVELENGTHS, x[known], n[known]), np.interp(WAVELENGTHS, y, k)


def main():
    mi.set_variant("scalar_rgb")
    weights = observer()
    names = sorted(path.name.removesuffix(".eta.spd") for path in SPECTRA.glob("*.eta.spd"))
    for name in names:
        plain = name.removesuffix("_palik")
        if plain != name and plain in names and np.array_equal(spectrum(name), spectrum(plain)):
            continue
        eta, k, _ = fitted(*spectrum(name), weights)
        print(f'    ("{name}", [{", ".join(f"{x:.5g}" for x in eta)}], [{", ".join(f"{x:.5g}" for x in k)}]),')


if __name__ == "__main__":
    main()
