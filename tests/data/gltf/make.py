"""Writes the test files of this directory: `python3 tests/data/gltf/make.py`. Standard library only; all of it was written for this project."""

import base64
import json
import pathlib
import struct
import zlib

HERE = pathlib.Path(__file__).parent
F32, U16, U8 = 5126, 5123, 5121


class Writer:
    """Collects binary data, and the views and accessors that describe it."""

    def __init__(self):
        self.data, self.views, self.accessors = b"", [], []

    def view(self, data, **more):
        self.data += b"\0" * (-len(self.data) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **more})
        self.data += data
        return len(self.views) - 1

    def accessor(self, kind, rows, component=F32, **more):
        form = {F32: "f", U16: "H", U8: "B"}[component]
        flat = [x for row in rows for x in (row if isinstance(row, (tuple, list)) else (row,))]
        entry = {"bufferView": self.view(struct.pack(f"<{len(flat)}{form}", *flat)), "componentType": component, "count": len(rows), "type": kind, **more}
        if kind == "VEC3":
            entry |= {"min": [min(row[k] for row in rows) for k in range(3)], "max": [max(row[k] for row in rows) for k in range(3)]}
        self.accessors.append(entry)
        return len(self.accessors) - 1

    def into(self, document, uri=None):
        buffer = {"byteLength": len(self.data)}
        if uri is not None:
            buffer["uri"] = uri
        return {"asset": {"version": "2.0", "generator": "pathspace"}, **document, "buffers": [buffer], "bufferViews": self.views, "accessors": self.accessors}

    def embedded(self):
        return "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()


def save(name, document):
    (HERE / name).write_text(json.dumps(document, indent=1) + "\n")


def save_binary(name, document, data):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    (HERE / name).write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)


def png(width, height, pixels, channels):
    """An 8-bit PNG."""
    rows = b"".join(b"\0" + bytes(pixels[y * width * channels:(y + 1) * width * channels]) for y in range(height))
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def jpeg(blocks):
    """A row of 8 x 8 blocks of one (Y, Cb, Cr) each: a baseline JPEG with constant terms only, whose quantum of 8 makes one level of each step."""
    segment = lambda marker, data: struct.pack(">BBH", 0xFF, marker, 2 + len(data)) + data
    constant = bytes([0, 0, 0, 0, 12] + [0] * 12 + list(range(12)))  # twelve sizes, each with a code of four bits
    others = bytes([0x10, 1] + [0] * 15 + [0])  # one code, of one bit: no further terms
    bits, last = "", [128] * 3
    for block in blocks:
        for component, value in enumerate(block):
            step = value - last[component]
            size = abs(step).bit_length()
            bits += f"{size:04b}" + (f"{step if step > 0 else step + (1 << size) - 1:0{size}b}" if size else "") + "0"
        last = block
    bits += "1" * (-len(bits) % 8)
    scan = bytes(int(bits[k:k + 8], 2) for k in range(0, len(bits), 8)).replace(b"\xff", b"\xff\0")
    frame = struct.pack(">BHHB", 8, 8, 8 * len(blocks), 3) + b"".join(bytes([k, 0x11, 0]) for k in (1, 2, 3))
    tables = segment(0xDB, bytes([0] + [8] * 64)) + segment(0xC0, frame) + segment(0xC4, constant) + segment(0xC4, others)
    return b"\xff\xd8" + tables + segment(0xDA, bytes([3, 1, 0, 2, 0, 3, 0, 0, 63, 0])) + scan + b"\xff\xd9"


def punctual(lights):
    return {"extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": lights}}}


def lit(light):
    return {"extensions": {"KHR_lights_punctual": {"light": light}}}


def square(writer, **more):
    """The square from -1 to 1 in the plane z = 0, seen from +z."""
    corners = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    positions = writer.accessor("VEC3", corners)
    uvs = writer.accessor("VEC2", [(0, 1), (1, 1), (1, 0), (0, 0)])
    indices = writer.accessor("SCALAR", [0, 1, 2, 0, 2, 3], U16)
    return {"attributes": {"POSITION": positions, "TEXCOORD_0": uvs}, "indices": indices, **more}


def matte(color):
    return {"pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": 0, "roughnessFactor": 1}}


HALF = 0.70710678118654752


def box():
    """A room of squares from -1 to 1, open to +z, with a lamp below the ceiling and a rotated and a mirrored block of metal and of plastic."""
    writer = Writer()
    wall = square(writer)
    cube = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    block = {"attributes": {"POSITION": writer.accessor("VEC3", cube)},
             "indices": writer.accessor("SCALAR", [i for a, b, c, d in faces for i in (a, b, c, a, c, d)], U8)}
    materials = [
        {"name": "white", **matte((0.75, 0.75, 0.75))}, {"name": "red", **matte((0.625, 0.0625, 0.0625))}, {"name": "green", **matte((0.125, 0.5, 0.125))},
        {"name": "lamp", **matte((0, 0, 0)), "emissiveFactor": [1, 0.75, 0.5], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 16}}},
        {"name": "metal", "pbrMetallicRoughness": {"baseColorFactor": [0.875, 0.625, 0.25, 1], "roughnessFactor": 0.5}},
        {"name": "plastic", "pbrMetallicRoughness": {"baseColorFactor": [0.125, 0.25, 0.75, 1], "metallicFactor": 0.25, "roughnessFactor": 0.375},
         "extensions": {"KHR_materials_ior": {"ior": 1.75}}},
    ]
    mesh = lambda name, primitive, material: {"name": name, "primitives": [{**primitive, "material": material}]}
    meshes = [mesh("white wall", wall, 0), mesh("red wall", wall, 1), mesh("green wall", wall, 2), mesh("lamp", wall, 3),
              mesh("metal block", block, 4), mesh("plastic block", block, 5)]
    nodes = [
        {"name": "room", "children": [1, 2, 3, 4, 5, 6, 7, 8]},
        {"name": "back", "mesh": 0, "translation": [0, 0, -1]},
        {"name": "floor", "mesh": 0, "translation": [0, -1, 0], "rotation": [-HALF, 0, 0, HALF]},
        {"name": "ceiling", "mesh": 0, "translation": [0, 1, 0], "rotation": [HALF, 0, 0, HALF]},
        {"name": "left", "mesh": 1, "translation": [-1, 0, 0], "rotation": [0, HALF, 0, HALF]},
        {"name": "right", "mesh": 2, "matrix": [0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, 1]},
        {"name": "lamp", "mesh": 3, "translation": [0, 0.9375, 0], "rotation": [HALF, 0, 0, HALF], "scale": [0.25, 0.25, 0.25]},
        {"name": "metal block", "mesh": 4, "translation": [-0.375, -0.5, -0.25], "rotation": [0, 0.25, 0, 0.96824583655185422], "scale": [0.25, 0.5, 0.25]},
        {"name": "plastic block", "mesh": 5, "translation": [0.375, -0.75, 0.125], "scale": [-0.25, 0.25, 0.25]},
        {"name": "eye", "camera": 0, "translation": [0, 0, 3.5]},
    ]
    document = {
        "extensionsUsed": ["KHR_materials_emissive_strength", "KHR_materials_ior"], "scene": 0, "scenes": [{"nodes": [0, 9]}], "nodes": nodes,
        "meshes": meshes, "materials": materials,
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.75, "aspectRatio": 1.5, "znear": 0.125}}],
    }
    save("box.gltf", writer.into(document, writer.embedded()))
    save_binary("box.glb", writer.into(document), writer.data)


def lights():
    """Three squares far apart, each below one kind of light, and a camera above each."""
    writer = Writer()
    meshes = [{"primitives": [square(writer, material=0)]}]
    down = {"type": "perspective", "perspective": {"yfov": 0.001, "znear": 0.125}}
    nodes, places = [], [0, 1000, 2000]
    for light, x in enumerate(places):
        nodes += [
            {"name": f"square {light}", "mesh": 0, "translation": [x, 0, 0]},
            {"name": f"light {light}", "translation": [x + 1, 0, 2], "rotation": [0, 0.22975292054736119, 0, 0.97324898946773018], **lit(light)},
            {"name": f"eye {light}", "camera": 0, "translation": [x, 0, 5]},
        ]
    kinds = [{"type": "point", "intensity": 8, "color": [1, 0.5, 0.25]}, {"type": "directional", "intensity": 3, "color": [0.25, 0.5, 1]},
             {"type": "spot", "intensity": 8, "spot": {"innerConeAngle": 0, "outerConeAngle": 0.25}}]
    document = {**punctual(kinds), "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes, "materials": [matte((0.5, 0.5, 0.5))],
                "cameras": [down]}
    save("lights.gltf", writer.into(document, writer.embedded()))


def materials():
    """A row of squares, each with another material, seen in parallel."""
    writer = Writer()
    glass = lambda **more: {"KHR_materials_transmission": {"transmissionFactor": 1}, **more}
    pbr = lambda **more: {"pbrMetallicRoughness": more}
    volume = {"KHR_materials_volume": {"thicknessFactor": 1}}
    looks = [
        ("default", {}),
        ("smooth", pbr(baseColorFactor=[0.5, 0.25, 0.125, 1], metallicFactor=0.5, roughnessFactor=0)),
        ("glass", {**pbr(metallicFactor=0, roughnessFactor=0), "extensions": glass(**volume, KHR_materials_ior={"ior": 1.25})}),
        ("frosted", {**pbr(metallicFactor=0, roughnessFactor=0.5), "extensions": glass(**volume)}),
        ("pane", {**pbr(metallicFactor=0, roughnessFactor=0), "extensions": glass()}),
        ("partly glass", {**pbr(metallicFactor=0.5, roughnessFactor=0), "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5}, **volume}}),
        ("veil", {**pbr(baseColorFactor=[1, 1, 1, 0.25]), "alphaMode": "BLEND"}),
        ("cut away", {**pbr(baseColorFactor=[1, 1, 1, 0.25]), "alphaMode": "MASK", "alphaCutoff": 0.375}),
        ("kept", {**pbr(baseColorFactor=[1, 1, 1, 0.25]), "alphaMode": "MASK", "alphaCutoff": 0.25}),
        ("glow", {"emissiveFactor": [0.5, 0.25, 1], "doubleSided": True}),
        (None, None),
    ]
    primitive = square(writer)
    used = [look for look in looks if look[0] is not None]
    meshes = [{"primitives": [primitive | ({"material": k} if name is not None else {})]} for k, (name, _) in enumerate(looks)]
    nodes = [{"name": name or "none", "mesh": k, "translation": [3 * k, 0, 0]} for k, (name, _) in enumerate(looks)]
    nodes.append({"name": "eye", "camera": 0, "translation": [15, 0, 4]})
    document = {
        "extensionsUsed": ["KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume"],
        "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes, "materials": [{"name": name, **look} for name, look in used],
        "cameras": [{"type": "orthographic", "orthographic": {"xmag": 16.5, "ymag": 1.5, "znear": 0, "zfar": 10}}],
    }
    save("materials.gltf", writer.into(document, writer.embedded()))


def textures():
    """A square with textures of every kind, in external files beside it and in the buffer; names with spaces."""
    writer = Writer()
    color = png(2, 2, [255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 64, 188, 188, 188, 0], 4)
    surface = png(2, 1, [9, 255, 0, 9, 51, 255], 3)
    (HERE / "two by two.png").write_bytes(color)
    repeated = {"wrapS": 10497, "wrapT": 33071, "magFilter": 9728}
    materials = [{
        "name": "painted",
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 0.5, 1, 1],
                                 "metallicRoughnessTexture": {"index": 1}, "roughnessFactor": 0.5},
        "emissiveTexture": {"index": 0}, "emissiveFactor": [0.5, 0.5, 0.5], "alphaMode": "BLEND",
    }, {
        "name": "turned",
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {
            "offset": [0, 1], "rotation": 1.5707963267948966, "scale": [0.5, 0.5]}}}, "metallicFactor": 0},
    }]
    meshes = [{"primitives": [square(writer, material=0)]}, {"primitives": [square(writer, material=1)]}]
    image = writer.view(surface)
    document = {
        "extensionsUsed": ["KHR_texture_transform"], "extensionsRequired": ["KHR_texture_transform"],
        "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"name": "painted", "mesh": 0}, {"name": "turned", "mesh": 1, "translation": [3, 0, 0]}, {"camera": 0, "translation": [0, 0, 4]}],
        "meshes": meshes, "materials": materials, "images": [{"uri": "two%20by%20two.png"}, {"bufferView": image, "mimeType": "image/png"}],
        "samplers": [repeated], "textures": [{"source": 0, "sampler": 0}, {"source": 1, "sampler": 0}],
        "cameras": [{"name": "front", "type": "perspective", "perspective": {"yfov": 1, "znear": 0.125}}],
    }
    (HERE / "textures.bin").write_bytes(writer.data)
    save("textures.gltf", writer.into(document, "textures.bin"))


def meshes():
    """A strip, a fan and triangles without indices; sparse positions, one accessor of them without a base; interleaved and normalised attributes; normals."""
    writer = Writer()
    strip = writer.accessor("VEC3", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 2, 0)])
    fan = writer.accessor("VEC3", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    places = writer.view(struct.pack("<2B", 1, 2))
    values = writer.view(struct.pack("<6f", 2, 0, 0, 0, 2, 0))
    sparse = {"count": 2, "indices": {"bufferView": places, "componentType": U8}, "values": {"bufferView": values}}
    base = writer.accessor("VEC3", [(0, 0, 0), (9, 9, 9), (8, 8, 8)], sparse=sparse)
    writer.accessors.append({"componentType": F32, "count": 3, "type": "VEC3", "sparse": sparse, "min": [0, 0, 0], "max": [2, 2, 0]})
    zero = len(writer.accessors) - 1
    # position, normal (as 8-bit numbers, padded) and uv of each vertex
    vertex = lambda p, n, uv: struct.pack("<3f4b2H", *p, *n, 0, *uv)
    data = vertex((0, 0, 0), (0, 0, 127), (0, 0)) + vertex((1, 0, 0), (127, 0, 127), (65535, 0)) + vertex((0, 1, 0), (0, 127, 127), (0, 65535))
    mixed = writer.view(data, byteStride=20)
    entry = lambda offset, component, kind, **more: writer.accessors.append(
        {"bufferView": mixed, "byteOffset": offset, "componentType": component, "count": 3, "type": kind, **more}) or len(writer.accessors) - 1
    attributes = {"POSITION": entry(0, F32, "VEC3", min=[0, 0, 0], max=[1, 1, 0]), "NORMAL": entry(12, 5120, "VEC3", normalized=True),
                  "TEXCOORD_0": entry(16, U16, "VEC2", normalized=True)}
    primitives = [{"attributes": {"POSITION": strip}, "mode": 5}, {"attributes": {"POSITION": fan}, "mode": 6}, {"attributes": {"POSITION": base}},
                  {"attributes": {"POSITION": zero}}, {"attributes": attributes}]
    document = {"extensionsUsed": ["KHR_mesh_quantization"], "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"name": "all", "primitives": primitives}]}
    save("meshes.gltf", writer.into(document, writer.embedded()))


def wraps():
    """Three squares, each with another wrap mode, on which u runs from -1 to 2 over a JPEG of a grey and a pink half."""
    writer = Writer()
    (HERE / "halves.jpg").write_bytes(jpeg([(100, 128, 128), (150, 128, 178)]))
    stretched = {"extensions": {"KHR_texture_transform": {"offset": [-1, 0], "scale": [3, 1]}}}
    modes = [10497, 33648, 33071]
    materials = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": k, **stretched}, "metallicFactor": 0}} for k in range(3)]
    document = {
        "extensionsUsed": ["KHR_texture_transform"], "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"mesh": k, "translation": [3 * k, 0, 0]} for k in range(3)], "meshes": [{"primitives": [square(writer, material=k)]} for k in range(3)],
        "materials": materials, "images": [{"uri": "halves.jpg"}], "samplers": [{"wrapS": mode, "magFilter": 9728} for mode in modes],
        "textures": [{"source": 0, "sampler": k} for k in range(3)],
    }
    save("wraps.gltf", writer.into(document, writer.embedded()))


def nodes():
    """A lamp with tilted normals, turned inside nodes that scale unevenly, once mirrored and once not; cameras of both kinds inside a turned node."""
    writer = Writer()
    lamp = square(writer, material=0)
    lamp["attributes"]["NORMAL"] = writer.accessor("VEC3", [(0.6, 0, 0.8)] * 4)
    turn = {"rotation": [0.25881904510252076, 0, 0, 0.96592582628906829]}
    quarter = {"rotation": [0, HALF, 0, HALF]}
    document = {
        "scenes": [{"nodes": [0, 3, 6]}],
        "nodes": [
            {"scale": [-2, 1, 3], "children": [1]}, {**turn, "translation": [1, 2, 3], "children": [2]}, {"name": "mirrored", "mesh": 0, "scale": [1, 0.5, 1]},
            {"scale": [2, 1, 3], "children": [4]}, {**turn, "translation": [9, 2, 3], "children": [5]}, {"name": "plain", "mesh": 0, "scale": [1, 0.5, 1]},
            {**quarter, "scale": [2, 2, 2], "children": [7, 8]}, {"name": "perspective", "camera": 0, "translation": [0, 0, 1]},
            {"name": "orthographic", "camera": 1, "translation": [0, 0, 1]},
        ],
        "meshes": [{"primitives": [lamp]}], "materials": [{"emissiveFactor": [1, 1, 1]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "aspectRatio": 2, "znear": 0.125}},
                    {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 1.5, "znear": 0, "zfar": 10}}],
    }
    save("nodes.gltf", writer.into(document, writer.embedded()))


def poses():
    """A mesh with morph targets at three nodes with weights of their own, and a ladder on two skins, of which one mirrors; it is morphed, too."""
    writer = Writer()
    places = writer.view(struct.pack("<B", 2))
    rise = {"count": 1, "indices": {"bufferView": places, "componentType": U8}, "values": {"bufferView": writer.view(struct.pack("<3f", 0, 0, 1))}}
    writer.accessors.append({"componentType": F32, "count": 4, "type": "VEC3", "sparse": rise})
    raised = len(writer.accessors) - 1
    tilt = writer.accessor("VEC3", [(0.75, 0, 0)] * 4)
    padded = writer.view(struct.pack("<16b", *[127, 0, 0, 0] * 4), byteStride=4)
    writer.accessors.append({"bufferView": padded, "componentType": 5120, "normalized": True, "count": 4, "type": "VEC3"})
    aside = len(writer.accessors) - 1
    sheet = square(writer, material=0, targets=[{"POSITION": raised, "NORMAL": tilt}, {"POSITION": aside}])
    sheet["attributes"]["NORMAL"] = writer.accessor("VEC3", [(0, 0, 1)] * 4)
    steps = [(x, y, 0) for y in range(3) for x in range(2)]
    ladder = {
        "attributes": {
            "POSITION": writer.accessor("VEC3", steps), "NORMAL": writer.accessor("VEC3", [(0.6, 0, 0.8)] * 6),
            "JOINTS_0": writer.accessor("VEC4", [(1, 0, 0, 0)] * 6, U8), "WEIGHTS_0": writer.accessor("VEC4", [(w, 255 - w, 0, 0) for w in (0, 0, 51, 51, 255, 255)], U8, normalized=True),
        },
        "indices": writer.accessor("SCALAR", [0, 1, 2, 3, 4, 5], U16), "mode": 5, "material": 0,
        "targets": [{"POSITION": writer.accessor("VEC3", [(0, 0, 0.5)] * 6), "NORMAL": writer.accessor("VEC3", [(-0.6, 0, 0)] * 6)}],
    }
    shift = lambda x, y, z: (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1)
    inverses = writer.accessor("MAT4", [shift(0, 0, -0.5), shift(-0.25, -1, 0)])
    document = {
        "extensionsUsed": ["KHR_mesh_quantization"], "scenes": [{"nodes": [0, 1, 2, 3, 5, 8, 10]}],
        "nodes": [
            {"name": "default", "mesh": 0}, {"name": "aside", "mesh": 0, "weights": [0, 2], "translation": [0, 3, 0]},
            {"name": "plain", "mesh": 0, "weights": [0, 0], "translation": [0, 6, 0]},
            {"translation": [100, 0, 0], "scale": [-5, 1, 1], "children": [4]}, {"name": "bent", "mesh": 1, "skin": 0, "weights": [0.5]},
            {"scale": [2, 2, 2], "translation": [10, 0, 0], "children": [6]}, {"translation": [0, 0, 1], "children": [7]},
            {"translation": [0, 1, 0], "rotation": [0, 0, HALF, HALF], "scale": [1, 3, 0.5]},
            {"scale": [-1, 1, 1], "translation": [-10, 0, 0], "children": [9]}, {}, {"name": "mirrored", "mesh": 1, "skin": 1},
        ],
        "meshes": [{"primitives": [sheet], "weights": [0.5, 0]}, {"primitives": [ladder]}],
        "skins": [{"joints": [6, 7], "inverseBindMatrices": inverses}, {"joints": [9, 8], "skeleton": 8}],
        "materials": [{"emissiveFactor": [1, 1, 1]}],
    }
    save("poses.gltf", writer.into(document, writer.embedded()))


def instances():
    """A square shown three times at one node: moved, turned and scaled, once mirrored; rotations are integers."""
    writer = Writer()
    turns = writer.view(struct.pack("<12h", 0, 0, 0, 32767, 0, 0, 23170, 23170, 0, 0, 0, -32767))
    writer.accessors.append({"bufferView": turns, "componentType": 5122, "normalized": True, "count": 3, "type": "VEC4"})
    turns = len(writer.accessors) - 1
    attributes = {"TRANSLATION": writer.accessor("VEC3", [(0, 0, 0), (2, 0, 0), (5, 0, 1)]), "ROTATION": turns, "SCALE": writer.accessor("VEC3", [(1, 1, 1), (0.25, 0.5, 1), (-1, 0.5, 1)])}
    document = {
        "extensionsUsed": ["EXT_mesh_gpu_instancing"], "extensionsRequired": ["EXT_mesh_gpu_instancing"], "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "square", "mesh": 0, "translation": [0, 0, 3], "scale": [2, 1, 1], "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}],
        "meshes": [{"primitives": [square(writer, material=0)]}], "materials": [{"emissiveFactor": [1, 1, 1]}],
    }
    save("instances.gltf", writer.into(document, writer.embedded()))


def packed():
    """A square twice: in streams of meshoptimizer 1.0 (positions, octahedral normals, triangles) without the buffer that they replace, and in one of Draco 1.5."""
    writer = Writer()
    streams = ["a00000000133000000ffff000000010c000000ff000000000000000000000000000000000000000000000000000080bf000080bf00000000",
               "a0000000000000000000000000000000000000000000000000000000000000000036007f00", "e1f000007687566778a9866589689801690000"]
    streams = [bytes.fromhex(stream) for stream in streams]
    for stream, (offset, stride, count, mode, more) in zip(streams, [(0, 12, 4, "ATTRIBUTES", {}), (48, 4, 4, "ATTRIBUTES", {"filter": "OCTAHEDRAL"}), (64, 2, 6, "TRIANGLES", {})]):
        place = writer.views[writer.view(stream)]
        packed = {"buffer": 0, "byteOffset": place["byteOffset"], "byteLength": len(stream), "byteStride": stride, "count": count, "mode": mode, **more}
        writer.views[-1] = {"buffer": 1, "byteOffset": offset, "byteLength": stride * count, "extensions": {"EXT_meshopt_compression": packed}}
        if stride >= 4:
            writer.views[-1]["byteStride"] = stride
    square = writer.view(bytes.fromhex(
        "445241434f02020101000000040200020000011fff011101ff0000010009030000020101010003030130011003002882980000000000ff0f0000000080bf000080bf00000000000000400c"))
    bounds = {"min": [-1, -1, 0], "max": [1, 1, 0]}
    writer.accessors = [
        {"bufferView": 0, "componentType": F32, "count": 4, "type": "VEC3", **bounds}, {"bufferView": 1, "componentType": 5120, "normalized": True, "count": 4, "type": "VEC3"},
        {"bufferView": 2, "componentType": U16, "count": 6, "type": "SCALAR"},
        {"componentType": F32, "count": 4, "type": "VEC3", **bounds}, {"componentType": U16, "count": 6, "type": "SCALAR"},
    ]
    draco = {"KHR_draco_mesh_compression": {"bufferView": square, "attributes": {"POSITION": 0}}}
    used = ["KHR_mesh_quantization", "EXT_meshopt_compression", "KHR_draco_mesh_compression"]
    document = {
        "extensionsUsed": used, "extensionsRequired": used, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"name": "meshopt", "mesh": 0}, {"name": "draco", "mesh": 1, "translation": [3, 0, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]},
                   {"primitives": [{"attributes": {"POSITION": 3}, "indices": 4, "material": 0, "extensions": draco}]}],
        "materials": [{"emissiveFactor": [1, 1, 1]}],
    }
    document = writer.into(document, writer.embedded())
    document["buffers"].append({"byteLength": 76, "extensions": {"EXT_meshopt_compression": {"fallback": True}}})
    save("packed.gltf", document)


box()
lights()
materials()
textures()
meshes()
wraps()
nodes()
poses()
instances()
packed()
