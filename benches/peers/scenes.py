"""Scenes that every renderer reads from the same files: Mitsuba's XML, written or copied below one directory."""

import pathlib
import re
import shutil

import mitsuba as mi
import numpy as np

FILM = """  <sensor type="perspective">
    <float name="fov" value="{fov}"/>
    <transform name="to_world"><lookat origin="{origin}" target="{target}" up="0, 1, 0"/></transform>
    <sampler type="$sampler"/>
    <film type="hdrfilm">
      <integer name="width" value="$width"/>
      <integer name="height" value="$height"/>
      <string name="pixel_format" value="rgb"/>
      <rfilter type="box"/>
    </film>
  </sensor>
"""
DEFAULTS = '  <default name="sampler" value="independent"/>\n  <default name="width" value="256"/>\n  <default name="height" value="256"/>\n'
MESH_CAMERAS = {"room": ("-4.8, 0.9, 3.7", "0.6, -0.9, -0.8", 65)}
MESH_LAMPS = {"room": ("0, 2.98, 0", 20)}


def write(path, body):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<scene version="3.0.0">\n{DEFAULTS}{body}</scene>\n')
    return path


def cornell_box(directory):
    """The Cornell box that is built into Mitsuba: materials and shapes by number, the rest as it is."""
    box = mi.cornell_box()
    numbers = lambda values: ", ".join(f"{float(x):.9g}" for x in np.ravel(values))
    body = FILM.format(fov=39.3077, origin="0, 0, 3.9", target="0, 0, 0")
    for name, entry in box.items():
        kind = entry.get("type") if isinstance(entry, dict) else None
        if kind == "diffuse":
            colour = numbers(entry["reflectance"]["value"])
            body += f'  <bsdf type="diffuse" id="{name}"><rgb name="reflectance" value="{colour}"/></bsdf>\n'
        elif kind in ("rectangle", "cube"):
            matrix = numbers(entry["to_world"].matrix).replace(",", "")
            lamp = entry.get("emitter")
            radiance = f'<emitter type="area"><rgb name="radiance" value="{numbers(lamp["radiance"]["value"])}"/></emitter>' if lamp else ""
            transform = f'<transform name="to_world"><matrix value="{matrix}"/></transform>'
            body += f'  <shape type="{kind}" id="{name}">{transform}<ref id="{entry["bsdf"]["id"]}"/>{radiance}</shape>\n'
    return write(directory / "cornell-box.xml", body)


def mesh(directory, source, name):
    """A grey mesh under a square lamp; `source` is a directory as of the example raykernel."""
    data = (source / f"{name}.mesh").read_bytes()
    vertices, triangles = np.frombuffer(data, "<u4", 2, 4)
    positions = np.frombuffer(data, "<f4", 3 * vertices, 12)
    faces = np.empty(triangles, [("count", "u1"), ("indices", "<u4", 3)])
    faces["count"], faces["indices"] = 3, np.frombuffer(data, "<u4", 3 * triangles, 12 + 12 * vertices).reshape(-1, 3)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
    header += f"element face {triangles}\nproperty list uchar uint vertex_indices\nend_header\n"
    directory.mkdir(parents=True, exist_ok=True)
    (directory / f"{name}.ply").write_bytes(header.encode() + positions.tobytes() + faces.tobytes())
    origin, target, fov = MESH_CAMERAS.get(name, ("0.8, 2.3, 5.6", "0, 0.6, 0", 50))
    centre, radiance = MESH_LAMPS.get(name, ("-1, 5, 0", 60))
    body = FILM.format(fov=fov, origin=origin, target=target)
    body += f"""  <shape type="ply">
    <string name="filename" value="{name}.ply"/>
    <boolean name="face_normals" value="true"/>
    <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.6, 0.6"/></bsdf></bsdf>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="90"/><translate value="{centre}"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0, 0, 0"/></bsdf>
    <emitter type="area"><rgb name="radiance" value="{radiance}, {radiance}, {radiance}"/></emitter>
  </shape>
"""
    return write(directory / f"{name}.xml", body)


def copy(directory, source):
    """A scene by others, its folder copied, with the box filter and a choice of samplers; and the defaults of its parameters."""
    folder = directory / source.parent.name
    defaults = {}
    for original in list(filter(pathlib.Path.is_file, source.parent.rglob("*"))):
        path = folder / original.relative_to(source.parent)
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix != ".xml":
            shutil.copyfile(original, path)
            continue
        text = original.read_text()
        if path.name == source.name or path.parent != folder:
            defaults |= re.findall(r'<default name="(\w+)" value="([^"]*)"', re.sub(r"<!--.*?-->", "", text, flags=re.S))
        text = re.sub(r'<sampler type="\w+"', '<sampler type="$sampler"', text)
        text = re.sub(r'<rfilter type="\w+"', '<rfilter type="box"', text)
        if path.name == source.name:
            text = re.sub(r"(<scene [^>]*>)", r'\1<default name="sampler" value="independent"/>', text, count=1)
        path.write_text(text)
    return folder / source.name, defaults
