"""LuxCore renders one image: luxcore.py SCENE ENGINE SAMPLES SEED DEPTH IMAGE. A process of its own, because it aborts when Python ends."""

import array
import json
import os
import sys
import time

import numpy as np


SQUARE = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]]
CUBE = [[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


def export(box, size, out):
    """Writes Mitsuba's Cornell box, a dictionary, as numbers."""
    shapes = []
    for entry in box.values():
        kind = entry.get("type") if isinstance(entry, dict) else None
        if kind in ("rectangle", "cube"):
            corners, quads = SQUARE if kind == "rectangle" else CUBE
            vertices = np.c_[corners, np.ones(len(corners))] @ np.array(entry["to_world"].matrix, dtype=float).T
            faces = [[a, b, c] for p, q, r, s in quads for a, b, c in ((p, q, r), (p, r, s))]
            lamp = entry.get("emitter")
            radiance = list(lamp["radiance"]["value"]) if lamp else None
            colour = list(box[entry["bsdf"]["id"]]["reflectance"]["value"])
            shapes.append({"vertices": vertices[:, :3].ravel().tolist(), "faces": np.ravel(faces).tolist(), "colour": colour, "radiance": radiance})
    camera = {"origin": [0, 0, 3.9], "target": [0, 0, 0], "fov": 39.3077}
    out.write_text(json.dumps({"width": size[0], "height": size[1], "camera": camera, "shapes": shapes}))


def properties(scene):
    text = lambda values: " ".join(f"{x:.9g}" for x in values)
    camera = scene["camera"]
    lines = ["scene.camera.type = perspective", "scene.camera.autofocus.enable = 0", "scene.camera.up = 0 1 0"]
    lines += [f"scene.camera.lookat.orig = {text(camera['origin'])}", f"scene.camera.lookat.target = {text(camera['target'])}"]
    lines += [f"scene.camera.fieldofview = {camera['fov']}"]
    for i, shape in enumerate(scene["shapes"]):
        material, name = f"scene.materials.m{i}", f"scene.objects.s{i}"
        lines += [f"{material}.type = matte", f"{material}.kd = {text(shape['colour'])}"]
        if shape["radiance"]:
            lines += [f"{material}.emission = {text(shape['radiance'])}", f"{material}.emission.gain = 1 1 1"]
            lines += [f"{material}.emission.{key} = 0" for key in ("power", "efficency", "normalizebycolor")]
        lines += [f"{name}.material = m{i}", f"{name}.vertices = {text(shape['vertices'])}"]
        lines += [f"{name}.faces = {' '.join(map(str, shape['faces']))}"]
    return "\n".join(lines) + "\n"


def main():
    import pyluxcore

    path, engine, samples, seed, depth, image = sys.argv[1:]
    pyluxcore.Init(lambda message: None)
    with open(path) as file:
        numbers = json.load(file)
    width, height = numbers["width"], numbers["height"]
    description = pyluxcore.Properties()
    description.SetFromString(properties(numbers))
    scene = pyluxcore.Scene()
    scene.Parse(description)
    settings = pyluxcore.Properties()
    # Depths beyond any path switch roulette off. A path of both walks may have up to twice the depth.
    settings.SetFromString(
        f"renderengine.type = {engine}\nrenderengine.seed = {int(seed) + 1}\nsampler.type = RANDOM\nfilm.width = {width}\n"
        f"film.height = {height}\nfilm.filter.type = BOX\nfilm.filter.width = 0.5\nnative.threads.count = 1\nbatch.haltspp = {samples}\n"
        f"path.maxdepth = {depth}\npath.pathdepth.total = {depth}\npath.pathdepth.diffuse = {depth}\nlight.maxdepth = {depth}\n"
        "path.russianroulette.depth = 1000\nlight.russianroulette.depth = 1000\npath.clamping.variance.maxvalue = 0\n"
        "film.imagepipelines.0.0.type = NOP\n"
    )
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(settings, scene))
    start = time.process_time()
    session.Start()
    while not session.HasDone():
        time.sleep(0.02)
        session.UpdateStats()
    session.UpdateStats()
    seconds = time.process_time() - start
    count = session.GetStats().Get("stats.renderengine.total.samplecount").GetFloat()
    session.Stop()
    pixels = array.array("f", bytes(4 * 3 * width * height))
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels)
    np.save(image, np.array(pixels, dtype=np.float64).reshape(height, width, 3)[::-1])
    print(f"seconds {seconds} samples {count:.0f}", flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
