"""A made scene for choosing settings: bricks with studs, holes and thin parts, few highlights, noise of a renderer.

    blender -b --factory-startup -noaudio --python-exit-code 1 --python bricks.py -- OUT [SIZE [TRAIN [TEST]]]

Writes OUT in the layout of NeRF's synthetic scenes (transforms_*.json and RGBA images of SIZE x SIZE px; 800, 100 and
25 views if not given) by Blender's Cycles, in some 25 s each on one core. Lengths are Blender's metres, z is up.
"""
import json
import math
import os
import random
import sys

import bpy
from mathutils import Matrix, Vector

arguments = sys.argv[sys.argv.index("--") + 1 :]
out = os.path.abspath(arguments[0])
size, n_train, n_test = (int(a) for a in (arguments[1:] + ["800", "100", "25"][len(arguments) - 1 :]))
random.seed(0)

UNIT, PLATE, HIGH = 0.1, 0.04, 0.12  # a stud's pitch, a plate's and a brick's height
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def material(name, rgb, roughness=0.35, metallic=0.0):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    shader = m.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*rgb, 1)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Metallic"].default_value = metallic
    return m


YELLOW = material("yellow", (0.8, 0.45, 0.02))
GREY = material("grey", (0.2, 0.21, 0.22))
LIGHT = material("light", (0.5, 0.5, 0.48))
BLACK = material("black", (0.015, 0.015, 0.018), 0.5)
RED = material("red", (0.55, 0.02, 0.02))
TAN = material("tan", (0.55, 0.42, 0.24))
STEEL = material("steel", (0.7, 0.7, 0.72), 0.2, 1.0)


class Mesh:
    """Collects polygons of one material."""

    def __init__(self, m):
        self.m, self.v, self.f = m, [], []

    def add(self, vertices, faces, at=Matrix()):
        base = len(self.v)
        self.v += [tuple(at @ Vector(p)) for p in vertices]
        self.f += [tuple(base + i for i in face) for face in faces]

    def finish(self):
        mesh = bpy.data.meshes.new(self.m.name)
        mesh.from_pydata(self.v, [], self.f)
        mesh.materials.append(self.m)
        scene.collection.objects.link(bpy.data.objects.new(self.m.name, mesh))


meshes = {m.name: Mesh(m) for m in (YELLOW, GREY, LIGHT, BLACK, RED, TAN, STEEL)}


def box(m, low, high, at=Matrix()):
    (a, b, c), (d, e, f) = low, high
    meshes[m.name].add([(a, b, c), (d, b, c), (d, e, c), (a, e, c), (a, b, f), (d, b, f), (d, e, f), (a, e, f)],
                       [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)], at)


def tube(m, start, end, radius, inner=0.0, at=Matrix(), sides=20):
    start, end = Vector(start), Vector(end)
    turn = (end - start).to_track_quat("Z", "Y").to_matrix().to_4x4()
    length = (end - start).length
    ring = [(math.cos(2 * math.pi * i / sides), math.sin(2 * math.pi * i / sides)) for i in range(sides)]
    v = [(radius * x, radius * y, z) for z in (0, length) for x, y in ring]
    n, faces = sides, [(i, (i + 1) % sides, sides + (i + 1) % sides, sides + i) for i in range(sides)]
    if inner:
        v += [(inner * x, inner * y, z) for z in (0, length) for x, y in ring]
        faces += [(2 * n + i, 3 * n + i, 3 * n + (i + 1) % n, 2 * n + (i + 1) % n) for i in range(n)]
        faces += [(i, 2 * n + i, 2 * n + (i + 1) % n, (i + 1) % n) for i in range(n)]
        faces += [(n + i, n + (i + 1) % n, 3 * n + (i + 1) % n, 3 * n + i) for i in range(n)]
    else:
        faces += [tuple(reversed(range(n))), tuple(range(n, 2 * n))]
    meshes[m.name].add(v, faces, at @ Matrix.Translation(start) @ turn)


def brick(m, x, y, z, w, d, height=HIGH, at=Matrix(), studs=True):
    gap = 0.0015
    box(m, (x + gap, y + gap, z), (x + w * UNIT - gap, y + d * UNIT - gap, z + height - gap), at)
    for i in range(w if studs else 0):
        for j in range(d):
            p = (x + (i + 0.5) * UNIT, y + (j + 0.5) * UNIT, z + height - gap)
            tube(m, p, (p[0], p[1], p[2] + 0.022), 0.031, at=at)


def beam(m, start, end, width=0.08):
    """A beam with a round hole at each unit, from axis to axis, its holes along y."""
    start, end = Vector(start), Vector(end)
    count = max(1, round((end - start).length / UNIT))
    along = (end - start).normalized()
    for i in range(count + 1):
        c = start + (end - start) * (i / count)
        tube(m, c - Vector((0, width / 2, 0)), c + Vector((0, width / 2, 0)), 0.05, 0.03)
        if i < count:
            across = along.cross(Vector((0, 1, 0)))
            for s in (-1, 1):
                a = c + across * 0.042 * s
                b = a + (end - start) / count
                turn = Matrix.Translation((a + b) / 2) @ (b - a).to_track_quat("X", "Z").to_matrix().to_4x4()
                box(m, (-(b - a).length / 2, -width / 2, -0.008), ((b - a).length / 2, width / 2, 0.008), turn)


# The plate it stands on.
for i in range(4):
    for j in range(3):
        brick([TAN, TAN, LIGHT][random.randrange(3)], -1.2 + 0.6 * i, -0.9 + 0.6 * j, -0.55, 6, 6, PLATE)
# Tracks: links around a stadium, wheels with spokes' holes inside.
for side in (-0.5, 0.3):
    links, half, r = 44, 0.55, 0.17
    around = 4 * half + 2 * math.pi * r
    for k in range(links):
        s = around * k / links
        if s < 2 * half:
            x, z, a = -half + s, r, 0
        elif s < 2 * half + math.pi * r:
            a = (s - 2 * half) / r
            x, z, a = half + r * math.sin(a), r * math.cos(a), a
        elif s < 4 * half + math.pi * r:
            x, z, a = half - (s - 2 * half - math.pi * r), -r, math.pi
        else:
            a = (s - 4 * half - math.pi * r) / r
            x, z, a = -half - r * math.sin(a), -r * math.cos(a), math.pi + a
        at = Matrix.Translation((x, side + 0.1, z - 0.31)) @ Matrix.Rotation(a, 4, "Y")
        box(BLACK, (-0.03, -0.12, -0.012), (0.03, 0.12, 0.012), at)
        box(GREY, (-0.012, -0.12, 0.012), (0.012, 0.12, 0.028), at)
    for x in (-0.55, -0.18, 0.18, 0.55):
        tube(LIGHT, (x, side + 0.02, -0.31), (x, side + 0.18, -0.31), 0.13, 0.1)
        tube(STEEL, (x, side + 0.01, -0.31), (x, side + 0.19, -0.31), 0.025)
        for k in range(5):
            a = 2 * math.pi * k / 5
            tube(LIGHT, (x, side + 0.1, -0.31), (x + 0.11 * math.cos(a), side + 0.1, -0.31 + 0.11 * math.sin(a)), 0.012)
# Body, cabin of posts, engine with a grille.
for k, (x, y, w, d) in enumerate([(-0.6, -0.3, 12, 6), (-0.6, -0.3, 12, 6), (-0.6, -0.2, 6, 4), (-0.6, -0.2, 6, 4)]):
    brick([GREY, YELLOW, YELLOW, BLACK][k], x, y, -0.13 + k * HIGH, w, d)
for x in (0.05, 0.45):
    for y in (-0.27, 0.23):
        tube(BLACK, (x, y, 0.1), (x, y, 0.62), 0.018)
brick(YELLOW, 0.0, -0.3, 0.62, 5, 6, PLATE)
brick(RED, 0.1, -0.1, 0.11, 2, 2)
tube(GREY, (0.33, 0, 0.1), (0.4, 0, 0.35), 0.012)
tube(BLACK, (0.37, 0, 0.34), (0.42, 0, 0.36), 0.08, 0.065)
for k in range(9):
    box(GREY, (-0.62, -0.19 + k * 0.043, 0.12), (-0.6, -0.17 + k * 0.043, 0.33))
tube(STEEL, (-0.45, 0.12, 0.35), (-0.45, 0.12, 0.7), 0.03, 0.022)
for x in (0.02, 0.48):
    tube(RED if x < 0.3 else YELLOW, (x, 0, 0.66), (x, 0, 0.72), 0.035)
# Arms of beams with holes, pistons, a shovel with teeth.
for y in (-0.36, 0.36):
    beam(YELLOW, (0.5, y, 0.05), (0.95, y, 0.45))
    beam(LIGHT, (0.95, y, 0.45), (1.25, y, 0.0))
    tube(STEEL, (0.55, y, 0.25), (0.85, y, 0.42), 0.014)
    tube(GREY, (0.45, y, 0.18), (0.65, y, 0.31), 0.025)
for k in range(9):
    a = -0.5 + 2.2 * k / 8
    place = (1.2 + 0.2 * math.cos(a + 2.2), 0, -0.25 + 0.2 * math.sin(a + 2.2))
    at = Matrix.Translation(place) @ Matrix.Rotation(-a - 2.2, 4, "Y")
    box(RED, (-0.006, -0.45, -0.03), (0.006, 0.45, 0.03), at)
for k in range(8):
    box(LIGHT, (1.3, -0.42 + k * 0.115, -0.42), (1.44, -0.38 + k * 0.115, -0.405))
# Thin parts: a ladder, a net on the load, hoses, an antenna.
for y in (0.33, 0.45):
    tube(LIGHT, (-0.75, y, -0.4), (-0.55, y, 0.4), 0.01)
for k in range(8):
    t = (k + 0.5) / 8
    p = (-0.75 + 0.2 * t, -0.4 + 0.8 * t)
    tube(LIGHT, (p[0], 0.33, p[1]), (p[0], 0.45, p[1]), 0.008)
for k in range(11):
    t = k / 10
    tube(BLACK, (-1.1 + 0.4 * t, -0.45, -0.45), (-1.1 + 0.4 * t, -0.05, -0.05), 0.005)
    tube(BLACK, (-1.1, -0.45 + 0.4 * t, -0.45 + 0.4 * t), (-0.7, -0.45 + 0.4 * t, -0.45 + 0.4 * t), 0.005)
tube(STEEL, (-0.1, -0.25, 0.2), (-0.16, -0.28, 1.0), 0.006)
for y, m in ((-0.2, BLACK), (-0.15, RED)):
    last = None
    for k in range(25):
        t = k / 24
        p = (0.1 + 0.9 * t, y - 0.15 * math.sin(math.pi * t), 0.2 + 0.45 * math.sin(math.pi * t) + 0.2 * t)
        if last:
            tube(m, last, p, 0.014, sides=10)
        last = p
# Loose bricks.
for k in range(14):
    at = Matrix.Translation((random.uniform(-1.1, 0.9), random.choice((-1, 1)) * random.uniform(0.6, 0.8), -0.51)) \
        @ Matrix.Rotation(random.uniform(0, 6.28), 4, "Z")
    brick(random.choice((YELLOW, RED, LIGHT, GREY, BLACK)), -0.1, -0.05, 0, random.choice((1, 2, 3)), 1, at=at)
for m in meshes.values():
    m.finish()

# Light: a sky and one large lamp.
world = bpy.data.worlds.new("world")
world.use_nodes = True
world.node_tree.nodes["Background"].inputs[0].default_value = (0.9, 0.95, 1.0, 1)
world.node_tree.nodes["Background"].inputs[1].default_value = 0.6
scene.world = world
lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "AREA"))
lamp.data.energy, lamp.data.size = 260, 2.0
lamp.location = (2.5, -2.0, 4.0)
lamp.rotation_euler = (Vector((0, 0, 0)) - lamp.location).to_track_quat("-Z", "Y").to_euler()
scene.collection.objects.link(lamp)

camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
scene.camera = camera
camera.data.angle = 0.6911112070083618  # NeRF's
scene.render.engine = "CYCLES"
scene.cycles.samples = 32
scene.cycles.use_denoising = False  # as NeRF's scenes: noise is part of the task
scene.cycles.max_bounces = 4
scene.render.film_transparent = True
scene.render.resolution_x = scene.render.resolution_y = size
scene.render.image_settings.color_mode = "RGBA"
scene.view_settings.view_transform = "Standard"
scene.render.use_persistent_data = True

for split, count in (("train", n_train), ("test", n_test)):
    frames = []
    for k in range(count):
        if split == "train":  # the upper half of a sphere, as NeRF's
            up, around = random.random(), random.uniform(0, 2 * math.pi)
        else:
            up, around = 0.5 + 0.35 * math.sin(6 * math.pi * k / count), 2 * math.pi * k / count
        flat = math.sqrt(1 - up * up)
        camera.location = Vector((flat * math.cos(around), flat * math.sin(around), up)) * 4.0311
        camera.rotation_euler = (-camera.location).to_track_quat("-Z", "Y").to_euler()
        bpy.context.view_layer.update()
        name = f"{split}/r_{k}"
        scene.render.filepath = f"{out}/{name}.png"
        scene.cycles.seed = k
        bpy.ops.render.render(write_still=True)
        frames.append({"file_path": "./" + name, "transform_matrix": [list(row) for row in camera.matrix_world]})
    with open(f"{out}/transforms_{split}.json", "w") as f:
        json.dump({"camera_angle_x": camera.data.angle, "frames": frames}, f, indent=1)
