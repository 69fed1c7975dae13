#!/usr/bin/env python3
"""Stand scanned meshes in the Cornell box: dragon.py FOLDER NAME=FILE.ply.gz...

Writes NAME.obj and NAME.toml for each into FOLDER, beside one cornell.mtl. The walls have the published measurements with
the light in a hole of the ceiling; the mesh is turned to the camera, made 4 units wide and stood on the floor's centre.
"""
import gzip
import os
import sys

from generate import Obj, RED, GREEN, WHITE, LIGHT, colour, cornell_walls, save_mtl

TOML = """# {title} in the Cornell box. Shows: the cost of many triangles.

[camera]
origin = [2.78, 2.73, -8.0]
target = [2.78, 2.73, 0.0]
up = [0.0, 1.0, 0.0]
vfov = 30.0

[film]
width = 800
height = 600

[render]
spp = 64
max_bounces = 8

[[mesh]]
file = "{name}.obj"
"""


def read_ply(path):
    with gzip.open(path, "rt") as file:
        vertices = faces = 0
        for line in file:
            words = line.split()
            if words[:2] == ["element", "vertex"]:
                vertices = int(words[2])
            elif words[:2] == ["element", "face"]:
                faces = int(words[2])
            elif words[0] == "format" and words[1] != "ascii":
                raise SystemExit(path + ": only ASCII PLY is read")
            elif words[0] == "end_header":
                break
        positions = [tuple(map(float, file.readline().split()[:3])) for _ in range(vertices)]
        return positions, [tuple(map(int, file.readline().split()[1:4])) for _ in range(faces)]


def place(positions, width=4.0):
    """Half a turn about y, a width along x, and the floor's centre below."""
    low = [min(p[axis] for p in positions) for axis in range(3)]
    high = [max(p[axis] for p in positions) for axis in range(3)]
    scale = width / (high[0] - low[0])
    x0, z0 = (low[0] + high[0]) / 2, (low[2] + high[2]) / 2
    return [(2.78 - (x - x0) * scale, (y - low[1]) * scale + 0.001, 2.6 - (z - z0) * scale) for x, y, z in positions]


def main(folder, sources):
    folder = os.path.abspath(folder)
    os.makedirs(folder, exist_ok=True)
    save_mtl(os.path.join(folder, "cornell.mtl"), "The Cornell box's materials and the mesh's.", [
        ("white", [colour("Kd", WHITE)]), ("red", [colour("Kd", RED)]), ("green", [colour("Kd", GREEN)]),
        ("light", [colour("Kd", WHITE), colour("Ke", LIGHT)]), ("mesh", ["Kd 0.7 0.55 0.3"])])
    for source in sources:
        name, path = source.split("=", 1)
        positions, cells = read_ply(path)
        title = "The Stanford dragon ({:,} triangles)".format(len(cells))
        obj = Obj(title + " in the Cornell box. Model: Stanford 3D Scanning Repository.", "cornell.mtl")
        cornell_walls(obj)
        obj.use("mesh")
        obj.mesh(place(positions), cells)
        obj.save(os.path.join(folder, name + ".obj"))
        with open(os.path.join(folder, name + ".toml"), "w", newline="\n") as file:
            file.write(TOML.format(title=title, name=name))
        print(name, len(cells), "triangles of the mesh")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        raise SystemExit(__doc__)
    main(sys.argv[1], sys.argv[2:])
