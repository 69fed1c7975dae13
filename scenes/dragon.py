#!/usr/bin/env python3
"""Stand scanned meshes in the Cornell box: dragon.py FOLDER NAME=FILE.ply.gz[*N|/N]...

Writes NAME.obj and NAME.toml for each into FOLDER, beside one cornell.mtl. The walls have the published measurements with
the light in a hole of the ceiling; the mesh is turned to the camera, made 4 units wide and stood on the floor's centre.
With *N each triangle is split into N * N, whose new corners are moved by a wave along x, y and z (a thousandth of a unit at
most), so that they do not lie in one plane. With /N all corners in one cell of a grid of N cells along x become one.
"""
import gzip
import math
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


def refine(positions, cells, count):
    """Each cell split into count * count; neighbours share the points on their common edge."""
    positions = [tuple(p) for p in positions]
    points = {}  # Numbers of the points on an edge, from its smaller end to its larger.

    def wave(p):
        x, y, z = p
        return (x + 3e-5 * math.sin(900 * y), y + 3e-5 * math.sin(900 * z), z + 3e-5 * math.sin(900 * x))

    def new_point(a, b, c, i, j):
        """The point a + (b - a) i / count + (c - a) j / count."""
        u, v = i / count, j / count
        pa, pb, pc = positions[a], positions[b], positions[c]
        positions.append(wave([pa[k] + (pb[k] - pa[k]) * u + (pc[k] - pa[k]) * v for k in range(3)]))
        return len(positions) - 1

    def edge(a, b):
        if a > b:
            return edge(b, a)[::-1]
        if (a, b) not in points:
            points[a, b] = [new_point(a, b, b, i, 0) for i in range(1, count)]
        return points[a, b]

    refined = []
    for a, b, c in cells:
        rows = [[a] + edge(a, b) + [b]]
        left, right = edge(a, c), edge(b, c)
        for j in range(1, count):
            inside = [new_point(a, b, c, i, j) for i in range(1, count - j)]
            rows.append([left[j - 1]] + inside + [right[j - 1]])
        rows.append([c])
        for lower, upper in zip(rows, rows[1:]):
            for i in range(len(upper)):
                refined.append((lower[i], lower[i + 1], upper[i]))
                if i + 1 < len(upper):
                    refined.append((lower[i + 1], upper[i + 1], upper[i]))
    return positions, refined


def coarsen(positions, cells, count):
    """The corners in each cell of a grid brought together in their mean; triangles that lose their area are left out."""
    low = [min(p[k] for p in positions) for k in range(3)]
    size = (max(p[0] for p in positions) - low[0]) / count
    members, number = {}, []
    for p in positions:
        place = tuple(int((p[k] - low[k]) / size) for k in range(3))
        number.append(members.setdefault(place, (len(members), []))[0])
        members[place][1].append(p)
    means = [tuple(sum(p[k] for p in ps) / len(ps) for k in range(3)) for _, ps in members.values()]
    moved = (tuple(number[i] for i in cell) for cell in cells)
    return means, list(dict.fromkeys(cell for cell in moved if len(set(cell)) == 3))


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
        path, _, split = path.partition("*")
        path, _, grid = path.partition(".gz/")
        positions, cells = read_ply(path + ".gz" if grid else path)
        if split:
            positions, cells = refine(positions, cells, int(split))
        if grid:
            positions, cells = coarsen(positions, cells, int(grid))
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
