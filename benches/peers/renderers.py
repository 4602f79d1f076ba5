"""One interface to every renderer: an image, and the processor time that drawing its samples took, without loading and compiling."""

import dataclasses
import pathlib
import re
import subprocess
import sys
import time

import drjit as dr
import mitsuba as mi
import numpy as np

import luxcore

ROOT = pathlib.Path(__file__).resolve().parents[2]
RENDER = ROOT / "target" / "release" / "examples" / "render"
OUT = ROOT / "target" / "peers"

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)
# A pool of one thread can hang, also while an image file is read; the processor that the process is pinned to makes two threads one.
dr.set_thread_count(2)


@dataclasses.dataclass
class Task:
    """What to draw: paths of up to `events` scattering events of the scene, without roulette; the parameters are those of its file."""

    scene: pathlib.Path
    events: int
    parameters: dict


@dataclasses.dataclass
class Measured:
    image: np.ndarray
    seconds: float
    samples: int

    @property
    def speed(self):
        return self.samples / self.seconds


def load(path):
    """An image file as array of linear RGB."""
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.array(bitmap, dtype=np.float64)


def save(image, name):
    """Writes an image for a look at it."""
    path = OUT / (re.sub(r"\W+", "-", name).strip("-") + ".png")
    mi.Bitmap(image.astype(np.float32)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True).write(str(path))


class Here:
    """This crate, one process for each image."""

    def __init__(self, task, integrator="path-tracing", sampler="independent"):
        self.task, self.integrator, self.sampler = task, integrator, sampler

    def render(self, samples, seed):
        out = OUT / "here.exr"
        task = self.task
        command = [RENDER, "--scene", task.scene, "--strict", "--threads", 1, "--filter", "box", "--integrator", self.integrator]
        command += ["--sampler", self.sampler, "--samples", samples, "--seed", seed, "--max-bounces", task.events, "--no-roulette", "--out", out]
        command += [word for name, value in task.parameters.items() for word in ("-D", f"{name}={value}")]
        done = subprocess.run([*map(str, command)], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(done.stderr)
        seconds = float(re.search(r"([\d.]+) s of processors", done.stdout)[1])
        count = int(re.search(r"(\d+) in all", done.stdout)[1])
        return Measured(load(out), seconds, count)


class Mitsuba:
    """Mitsuba 3 in this process. The first image compiles the kernel and is thrown away."""

    def __init__(self, task, variant, integrator="path", sampler="independent"):
        mi.set_variant(variant)
        mi.set_log_level(mi.LogLevel.Error)  # of this variant: no progress bars
        self.variant, self.sampler = variant, sampler
        self.scene = mi.load_file(str(task.scene), sampler=sampler, **task.parameters)
        # A depth is an edge.
        self.integrator = mi.load_dict({"type": integrator, "max_depth": task.events + 1, "rr_depth": 1 << 20})
        self.warm = set()

    def count(self, samples):
        """The number of samples that the sampler makes of this one."""
        mi.set_variant(self.variant)
        return mi.load_dict({"type": self.sampler, "sample_count": samples}).sample_count()

    def render(self, samples, seed):
        mi.set_variant(self.variant)
        if samples not in self.warm:
            self.warm.add(samples)
            np.array(mi.render(self.scene, spp=samples, seed=1 << 20, integrator=self.integrator))
        start = time.process_time()
        image = np.array(mi.render(self.scene, spp=samples, seed=seed, integrator=self.integrator), dtype=np.float64)
        seconds = time.process_time() - start
        return Measured(image[:, :, :3], seconds, image.shape[0] * image.shape[1] * samples)


class LuxCore:
    """LuxCore's bidirectional path tracer, one process for each image of Mitsuba's Cornell box."""

    def __init__(self, task, depth, engine="BIDIRCPU"):
        self.engine, self.depth = engine, depth
        self.scene = OUT / "luxcore.json"
        luxcore.export(mi.cornell_box(), (task.parameters["width"], task.parameters["height"]), self.scene)

    def render(self, samples, seed):
        image = OUT / "luxcore.npy"
        script = pathlib.Path(__file__).with_name("luxcore.py")
        command = [sys.executable, script, self.scene, self.engine, samples, seed, self.depth, image]
        done = subprocess.run([*map(str, command)], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(done.stderr)
        seconds, count = re.search(r"seconds ([\d.]+) samples (\d+)", done.stdout).groups()
        return Measured(np.load(image), float(seconds), int(count))
