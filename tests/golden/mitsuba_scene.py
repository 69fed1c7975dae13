"""An OBJ with its MTL as a Mitsuba 3 scene, by texray's material contract.

Comes in: the path of an OBJ whose MTL lies beside it, and a camera. Goes out: a dictionary for `mi.load_dict`.
Assumes a scene that texray accepts: nothing is checked here, texray's own loader owns the refusals.

The contract, first match wins:
  illum 3 or 5                        perfect two-sided mirror of reflectance Ks
  illum 4, 6, 7 with Ni != 1 or d < 1 smooth colourless glass of index Ni, air outside
  anything else                       two-sided Lambert surface of albedo Kd
and, independently, Ke > 0 emits the radiance Ke from the side from which the corners turn counter-clockwise.
Defaults: Kd 0.8, Ks 1, Ke 0, illum 2, Ni 1, d 1. The faces of a material are smooth where each corner has a normal.

Mitsuba's `max_depth` counts segments of a path, texray's `max_bounces` surface scatterings: max_depth = bounces + 1.
"""
import os
import tempfile

import numpy as np

VECTORS = {"Kd": (0.8,) * 3, "Ks": (1.0,) * 3, "Ke": (0.0,) * 3}
NUMBERS = {"illum": 2.0, "Ni": 1.0, "d": 1.0}


def read_mtl(path):
    """Materials of an MTL file: name -> {key: value}."""
    materials, current = {}, None
    with open(path, encoding="utf-8") as lines:
        for words in map(str.split, lines):
            if not words:
                continue
            if words[0] == "newmtl":
                current = materials.setdefault(words[1], {**VECTORS, **NUMBERS})
            elif words[0] in VECTORS:
                numbers = [float(word) for word in words[1:4]]
                current[words[0]] = tuple(numbers * 3 if len(numbers) == 1 else numbers)
            elif words[0] in NUMBERS:
                current[words[0]] = float(words[1])
    return materials


def read_obj(path):
    """Triangles by material: name -> (positions (n, 3, 3), normals (n, 3, 3) or None), and the materials."""
    positions, normals, materials, corners = [], [], {}, {}
    name = ""
    with open(path, encoding="utf-8") as lines:
        for words in map(str.split, lines):
            if not words:
                continue
            if words[0] == "v":
                positions.append([float(word) for word in words[1:4]])
            elif words[0] == "vn":
                normals.append([float(word) for word in words[1:4]])
            elif words[0] == "mtllib":
                materials.update(read_mtl(os.path.join(os.path.dirname(path), words[1])))
            elif words[0] == "usemtl":
                name = words[1]
            elif words[0] == "f":
                face = []
                for word in words[1:]:
                    fields = (word.split("/") + ["", ""])[:3]
                    position = index(fields[0], len(positions))
                    face.append((position, index(fields[2], len(normals)) if fields[2] else None))
                for i in range(1, len(face) - 1):
                    corners.setdefault(name, []).append((face[0], face[i], face[i + 1]))
    parts = {}
    for name, triangles in corners.items():
        where = np.array([[positions[p] for p, _ in triangle] for triangle in triangles])
        smooth = all(n is not None for triangle in triangles for _, n in triangle)
        parts[name] = (where, np.array([[normals[n] for _, n in t] for t in triangles]) if smooth else None)
    return parts, materials


def content_hash(obj):
    """64-bit FNV-1a hash of what an OBJ and its MTL files say, as `content_hash` in tests/harness/golden.rs."""
    value, libraries = 0xCBF29CE484222325, [obj]
    for number, path in enumerate(libraries):
        with open(path, encoding="utf-8") as lines:
            for words in map(str.split, lines):
                if not words or words[0].startswith("#"):
                    continue
                if number == 0 and words[0] == "mtllib":
                    libraries.append(os.path.join(os.path.dirname(obj), words[1]))
                for byte in (" ".join(words) + "\n").encode():
                    value = ((value ^ byte) * 0x100000001B3) % 2**64
    return f"{value:016x}"


def index(word, count):
    """An OBJ index, which counts from 1, or backwards from the last element where negative."""
    number = int(word)
    return number - 1 if number > 0 else count + number


def write_ply(path, positions, normals):
    """A binary PLY with three vertices of its own for each triangle."""
    columns, names = [positions.reshape(-1, 3)], "x y z"
    if normals is not None:
        columns.append(normals.reshape(-1, 3))
        names += " nx ny nz"
    count = len(positions)
    faces = np.zeros(count, dtype=[("corners", "u1"), ("index", "<i4", 3)])
    faces["corners"], faces["index"] = 3, np.arange(3 * count).reshape(-1, 3)
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {3 * count}"]
    header += [f"property float {name}" for name in names.split()]
    header += [f"element face {count}", "property list uchar int vertex_indices", "end_header", ""]
    with open(path, "wb") as file:
        file.write("\n".join(header).encode())
        file.write(np.hstack(columns).astype("<f4").tobytes())
        file.write(faces.tobytes())


def bsdf(material):
    """The Mitsuba BSDF of a material."""
    def rgb(value):
        return {"type": "rgb", "value": list(value)}
    if material["illum"] in (3, 5):
        mirror = {"type": "conductor", "material": "none", "specular_reflectance": rgb(material["Ks"])}
        return {"type": "twosided", "side": mirror}
    if material["illum"] in (4, 6, 7) and (material["Ni"] != 1.0 or material["d"] < 1.0):
        return {"type": "dielectric", "int_ior": material["Ni"], "ext_ior": 1.0}
    return {"type": "twosided", "side": {"type": "diffuse", "reflectance": rgb(material["Kd"])}}


def scene(mi, obj, camera, width, height, bounces):
    """The dictionary of the scene. The meshes travel through temporary files, read before this returns."""
    described = {
        "type": "scene",
        # No Russian roulette: a path of `bounces` scatterings never reaches this depth.
        "integrator": {"type": "path", "max_depth": bounces + 1, "rr_depth": 1_000_000},
        "sensor": {
            "type": "perspective", "fov_axis": "y", "fov": camera["vfov"], "near_clip": 1e-3, "far_clip": 1e4,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=camera["origin"], target=camera["target"], up=camera["up"]),
            "sampler": {"type": "independent"},
            "film": {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": "box"}},
        },
    }
    parts, materials = read_obj(obj)
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, (positions, normals)) in enumerate(sorted(parts.items())):
            material = materials.get(name, {**VECTORS, **NUMBERS})
            ply = os.path.join(folder, f"{number}.ply")
            write_ply(ply, positions, normals)
            shape = {"type": "ply", "filename": ply, "face_normals": normals is None, "bsdf": bsdf(material)}
            if max(material["Ke"]) > 0:
                radiance = {"type": "rgb", "value": list(material["Ke"])}
                shape["emitter"] = {"type": "area", "radiance": radiance}
            described[f"part{number}"] = mi.load_dict(shape)
    return mi.load_dict(described)


def render_seeds(mi, loaded, spp, seeds):
    """Mean over the seeds and variance of that mean, per pixel and channel, two-pass in f64."""
    images = np.stack([np.array(mi.render(loaded, spp=spp, seed=seed), dtype=np.float64) for seed in seeds])
    return images.mean(axis=0), images.var(axis=0, ddof=1) / len(images)


def add_arguments(parser):
    """The options that both scripts share: scene, camera, samples."""
    parser.add_argument("--obj", required=True, help="scene, its MTL beside it")
    parser.add_argument("--origin", nargs=3, type=float, default=[2.78, 2.73, -8.0])
    parser.add_argument("--target", nargs=3, type=float, default=[2.78, 2.73, 0.0])
    parser.add_argument("--up", nargs=3, type=float, default=[0.0, 1.0, 0.0])
    # The vertical field of view of a square picture that is as wide as an 800x600 one of 30 degrees:
    # 2 atan(4/3 tan 15 degrees).
    parser.add_argument("--vfov", type=float, default=39.3077, help="vertical field of view in degrees")
    parser.add_argument("--bounces", type=int, default=8, help="surface scatterings of a path")
    parser.add_argument("--spp", type=int, default=1024, help="samples a pixel and seed")
    parser.add_argument("--seeds", type=int, default=16, help="number of independent renders, at least 16")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="scalar_rgb where no LLVM can be had")


def camera_of(arguments):
    """The camera of the shared options."""
    return {key: getattr(arguments, key) for key in ("origin", "target", "up", "vfov")}
