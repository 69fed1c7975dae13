#!/usr/bin/env python3
"""Write the committed scenes' OBJ and MTL files: generate.py [BUNNY_INDEX_JS TEAPOT_JS]
Write a hall with N lanterns into fetched/lanterns-N.obj and .toml: generate.py lanterns=N

Python's standard library alone; the output is the same on every machine. Without arguments the bunny and teapot are
read back from bunny.obj and teapot.obj, so that `room` can be made without the npm packages they come from.
"""
import json
import math
import os
import random
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))

# Reflectances and radiance of the Cornell box as Mitsuba's `cornell_box()` lists them (linear Rec. 709).
WHITE = (0.885809, 0.698859, 0.666422)
RED = (0.570068, 0.0430135, 0.0443706)
GREEN = (0.105421, 0.37798, 0.076425)
LIGHT = (18.387, 13.9873, 6.75357)


class Obj:
    """An OBJ file in the making: positions, normals, statements."""

    def __init__(self, comment, mtl=None):
        self.head = ["# " + line for line in comment.strip().splitlines()]
        if mtl:
            self.head.append("mtllib " + mtl)
        self.positions, self.normals, self.lines = [], [], []

    def use(self, material):
        self.lines.append("usemtl " + material)

    def face(self, *corners):
        """A polygon whose corners turn counter-clockwise as seen from its front."""
        first = len(self.positions) + 1
        self.positions += corners
        self.lines.append("f " + " ".join(str(first + i) for i in range(len(corners))))

    def mesh(self, positions, cells, normals=None):
        first, first_normal = len(self.positions) + 1, len(self.normals) + 1
        self.positions += positions
        self.normals += normals or []
        corner = (lambda i: "%d//%d" % (first + i, first_normal + i)) if normals else (lambda i: str(first + i))
        self.lines += ["f " + " ".join(corner(i) for i in cell) for cell in cells]

    def save(self, name):
        with open(os.path.join(HERE, name), "w", newline="\n") as file:
            file.write("\n".join(self.head) + "\n")
            file.writelines("v %s %s %s\n" % tuple(map(decimal, p)) for p in self.positions)
            file.writelines("vn %s %s %s\n" % tuple(map(decimal, n)) for n in self.normals)
            file.write("\n".join(self.lines) + "\n")


def decimal(value):
    text = "%.6f" % value
    text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def save_mtl(name, comment, materials):
    with open(os.path.join(HERE, name), "w", newline="\n") as file:
        file.writelines("# %s\n" % line for line in comment.strip().splitlines())
        for material, statements in materials:
            file.write("\nnewmtl %s\n" % material)
            file.writelines("%s\n" % statement for statement in statements)


def colour(keyword, rgb):
    return "%s %s" % (keyword, " ".join("%g" % channel for channel in rgb))


# ---- The Cornell box: www.graphics.cornell.edu/online/box/data.html, in units of a hundredth ----------------------

def units(*points):
    return [tuple(round(c / 100, 6) for c in point) for point in points]


HEIGHT = 548.8
# The published light, 130 x 105, whose corners turn so that it shines down.
LIGHT_X, LIGHT_Z = (213, 343), (227, 332)
SHORT_TOP = [(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)]
TALL_TOP = [(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)]


def cornell_walls(obj, hole=True):
    (x0, x1), (z0, z1), h = LIGHT_X, LIGHT_Z, HEIGHT
    obj.use("white")
    obj.face(*units((552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)))
    outer = [(556, h, 0), (556, h, 559.2), (0, h, 559.2), (0, h, 0)]
    inner = [(x1, h, z0), (x1, h, z1), (x0, h, z1), (x0, h, z0)]
    if hole:
        for i in range(4):
            j = (i + 1) % 4
            obj.face(*units(outer[i], outer[j], inner[j], inner[i]))
    else:
        obj.face(*units(*outer))
    obj.face(*units((549.6, 0, 559.2), (0, 0, 559.2), (0, h, 559.2), (556, h, 559.2)))
    obj.use("green")
    obj.face(*units((0, 0, 559.2), (0, 0, 0), (0, h, 0), (0, h, 559.2)))
    obj.use("red")
    # The published corners of this wall do not lie in one plane: two triangles say which way it bends.
    a, b, c, d = units((552.8, 0, 0), (549.6, 0, 559.2), (556, h, 559.2), (556, h, 0))
    obj.mesh([a, b, c, d], [(0, 1, 2), (0, 2, 3)])
    obj.use("light")
    obj.face(*units(*inner))


def cornell_block(obj, top, material):
    """The block's published faces: its top, then its four sides; it has no floor."""
    obj.use(material)
    obj.face(*units(*top))
    for i in range(4):
        a, b = top[i], top[(i + 1) % 4]
        obj.face(*units((a[0], 0, a[2]), (b[0], 0, b[2]), b, a))


def icosphere(centre, radius, splits):
    """A geodesic sphere of 20 * 4^splits triangles, fronts outward."""
    t = (1 + 5 ** 0.5) / 2
    points = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t),
              (0, -1, -t), (0, 1, -t), (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    cells = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4),
             (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8),
             (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(splits):
        middle, finer = {}, []

        def between(a, b):
            key = (min(a, b), max(a, b))
            if key not in middle:
                middle[key] = len(points)
                points.append(tuple((p + q) / 2 for p, q in zip(points[a], points[b])))
            return middle[key]
        for a, b, c in cells:
            ab, bc, ca = between(a, b), between(b, c), between(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        cells = finer
    on_sphere = []
    for point in points:
        length = math.sqrt(sum(c * c for c in point))
        on_sphere.append(tuple(c + radius * p / length for c, p in zip(centre, point)))
    return on_sphere, cells


def cornell():
    data = "The Cornell box from its published measurements, in units of a hundredth."
    save_mtl("cornell-box.mtl", "Cornell box: reflectances as Mitsuba's cornell_box() lists them.", [
        ("white", [colour("Kd", WHITE)]), ("red", [colour("Kd", RED)]), ("green", [colour("Kd", GREEN)]),
        ("light", [colour("Kd", WHITE), colour("Ke", LIGHT)]),
        ("mirror", ["Kd 0 0 0", "Ks 0.95 0.95 0.95", "illum 5"]),
        ("glass", ["Kd 0 0 0", "Ks 1 1 1", "Ni 1.5", "d 0.05", "illum 7"])])
    for name, note, hole, tall in (
            ("cornell-box", "The light fills a hole in the ceiling.", True, "white"),
            ("cornell-coplanar", "The light lies in the plane of an unbroken ceiling.", False, "white"),
            ("cornell-mirror", "The tall block is a mirror.", True, "mirror")):
        obj = Obj(data + " " + note, "cornell-box.mtl")
        cornell_walls(obj, hole)
        cornell_block(obj, SHORT_TOP, "white")
        cornell_block(obj, TALL_TOP, tall)
        obj.save(name + ".obj")
    obj = Obj(data + " A glass ball stands for the short block.", "cornell-box.mtl")
    cornell_walls(obj)
    cornell_block(obj, TALL_TOP, "white")
    obj.use("glass")
    obj.mesh(*icosphere((1.86, 0.95, 1.69), 0.9, 4))
    obj.save("cornell-glass.obj")


# ---- Bunny and teapot -------------------------------------------------------------------------------------------

def read_package(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    part = lambda name: json.loads(re.search(r"exports\.%s\s*=\s*(\[\[.*?\]\])" % name, text, re.S).group(1))
    return [tuple(p) for p in part("positions")], [tuple(c) for c in part("cells")]


def read_obj(name):
    positions, cells = [], []
    with open(os.path.join(HERE, name), encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if words and words[0] == "v":
                positions.append(tuple(map(float, words[1:4])))
            elif words and words[0] == "f":
                cells.append(tuple(int(word.split("/")[0]) - 1 for word in words[1:]))
    return positions, cells


def smooth_normals(positions, cells):
    """Unit normals weighted by area, shared by all corners at the same place: the patches' seams do not show."""
    place = lambda p: tuple(round(c, 4) for c in p)
    sums = {place(p): [0.0, 0.0, 0.0] for p in positions}
    for cell in cells:
        a, b, c = (positions[i] for i in cell)
        u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        for i in cell:
            total = sums[place(positions[i])]
            for axis in range(3):
                total[axis] += normal[axis]
    normals = []
    for p in positions:
        total = sums[place(p)]
        length = math.sqrt(sum(c * c for c in total)) or 1.0
        normals.append(tuple(c / length for c in total))
    return normals


def models(sources):
    bunny = read_package(sources[0]) if sources else read_obj("bunny.obj")
    teapot = read_package(sources[1]) if sources else read_obj("teapot.obj")
    obj = Obj("Stanford bunny: model by the Stanford 3D Scanning Repository, by way of npm's bunny 1.0.1.\n"
              "3,674 triangles; closed: every edge is shared by exactly two.")
    obj.mesh(*bunny)
    obj.save("bunny.obj")
    obj = Obj("Utah teapot: model by Martin Newell, by way of npm's teapot 1.0.0. 992 triangles with smooth normals.")
    obj.mesh(*teapot, smooth_normals(*teapot))
    obj.save("teapot.obj")


# ---- Stages and rooms -------------------------------------------------------------------------------------------

def box(obj, low, high, inward=False):
    (x0, y0, z0), (x1, y1, z1) = low, high
    faces = [((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)), ((x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)),
             ((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)), ((x0, y1, z0), (x0, y1, z1), (x1, y1, z1), (x1, y1, z0)),
             ((x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0)), ((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1))]
    for face in faces:
        obj.face(*(face[::-1] if inward else face))


def stage():
    """A floor under a model and a light above it."""
    obj = Obj("A floor at y = 0 and a light that shines down on it.")
    obj.use("floor")
    obj.face((-40, 0, -40), (-40, 0, 40), (40, 0, 40), (40, 0, -40))
    obj.use("light")
    obj.face((-8, 30, -8), (8, 30, -8), (8, 30, 8), (-8, 30, 8))
    obj.save("stage.obj")


def furnace():
    obj = Obj("A closed cube whose fronts face inward, around the origin.")
    obj.use("wall")
    box(obj, (-1, -1, -1), (1, 1, 1), inward=True)
    obj.save("furnace.obj")


def room():
    obj = Obj("A closed room of 6 x 3 x 5 with a picture in its frame, a table, and a lamp that faces the back wall.")
    obj.use("wall")
    box(obj, (-3, 0, -2.5), (3, 3, 2.5), inward=True)
    obj.use("table")
    box(obj, (-1.4, 0.7, -1.6), (1.4, 0.8, -0.4))
    for x in (-1.3, 1.2):
        for z in (-1.5, -0.6):
            box(obj, (x, 0, z), (x + 0.1, 0.7, z + 0.1))
    obj.use("frame")
    for low, high in (((-0.9, 1.4, -2.5), (-0.8, 2.4, -2.42)), ((0.8, 1.4, -2.5), (0.9, 2.4, -2.42)),
                      ((-0.8, 1.4, -2.5), (0.8, 1.5, -2.42)), ((-0.8, 2.3, -2.5), (0.8, 2.4, -2.42))):
        box(obj, low, high)
    obj.use("picture")
    obj.face((-0.8, 1.5, -2.48), (0.8, 1.5, -2.48), (0.8, 2.3, -2.48), (-0.8, 2.3, -2.48))
    # The lamp stands in front of the table and shines towards the back wall: what lies behind it is lit by bounces alone.
    obj.use("lamp")
    obj.face((-0.6, 2.4, 0.6), (-0.6, 2.8, 0.2), (0.6, 2.8, 0.2), (0.6, 2.4, 0.6))
    obj.save("room.obj")


def lanterns(name, count, mtl="lanterns.mtl"):
    """Lanterns of four glowing triangles in the upper half of a hall; the more there are, the smaller they are."""
    obj = Obj("A hall of 6 x 3 x 6 with five blocks and %s lanterns of four triangles each." % format(count, ","), mtl)
    obj.use("wall")
    box(obj, (-3, 0, -3), (3, 3, 3), inward=True)
    obj.use("block")
    for x, z, height in ((-1.6, -1.4, 1.1), (1.4, -1.7, 0.8), (0.1, -0.2, 0.5), (-1.2, 1.1, 0.4), (1.7, 0.8, 0.9)):
        box(obj, (x - 0.35, 0, z - 0.35), (x + 0.35, height, z + 0.35))
    numbers = random.Random(1)
    between = lambda low, high: low + (high - low) * numbers.random()
    size = 0.06 * (50 / count) ** 0.5
    for _ in range(count):
        obj.use(numbers.choice(("amber", "rose", "ice")))
        x, y, z = between(-2.8, 2.8), between(1.5, 2.9), between(-2.8, 2.8)
        turn = between(0, 2 * math.pi)
        foot = [(x + size * math.cos(turn + k * 2 * math.pi / 3), y, z - size * math.sin(turn + k * 2 * math.pi / 3))
                for k in range(3)]
        obj.mesh(foot + [(x, y + 1.6 * size, z)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    obj.save(name + ".obj")


def more_lanterns(count):
    """As the committed hall, with another number of lanterns, in fetched/."""
    os.makedirs(os.path.join(HERE, "fetched"), exist_ok=True)
    lanterns("fetched/lanterns-%d" % count, count, "../lanterns.mtl")
    with open(os.path.join(HERE, "lanterns.toml"), encoding="utf-8") as file:
        text = file.read().replace('"lanterns.obj"', '"lanterns-%d.obj"' % count)
    with open(os.path.join(HERE, "fetched", "lanterns-%d.toml" % count), "w", newline="\n") as file:
        file.write(text)


if __name__ == "__main__":
    if len(sys.argv) == 2 and sys.argv[1].startswith("lanterns="):
        more_lanterns(int(sys.argv[1].partition("=")[2]))
        raise SystemExit
    if len(sys.argv) not in (1, 3):
        raise SystemExit(__doc__)
    cornell()
    models(sys.argv[1:])
    stage()
    furnace()
    room()
    save_mtl("lanterns.mtl", "The hall of lanterns.", [
        ("wall", ["Kd 0.6 0.58 0.55"]), ("block", ["Kd 0.45 0.4 0.38"]),
        ("amber", ["Kd 0 0 0", "Ke 60 30 8"]), ("rose", ["Kd 0 0 0", "Ke 40 12 20"]), ("ice", ["Kd 0 0 0", "Ke 6 14 24"])])
    lanterns("lanterns", 50)
