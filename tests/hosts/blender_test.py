"""apps/python/blender_avatar.py inside Blender.

    blender -b --factory-startup --python-exit-code 1 --python blender_test.py -- AVATAR FLAME FOLDER
"""

import math
import os
import sys

import bpy
import numpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector

# PYTHONPATH does not reach Blender's Python without an option.
sys.path[:0] = os.environ["PYTHONPATH"].split(":")
import blender_avatar
import cosplat

AVATAR, FLAME, FOLDER = sys.argv[sys.argv.index("--") + 1 :]


def empty_scene():
    scene = bpy.context.scene
    for thing in list(scene.objects):
        bpy.data.objects.remove(thing)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.render.resolution_x, scene.render.resolution_y = 96, 72
    scene.render.resolution_percentage, scene.render.dither_intensity = 100, 0
    scene.render.image_settings.file_format = "PNG"
    scene.world.use_nodes, scene.world.color = False, (0, 0, 0)
    return scene


def rendered(scene, frame):
    """[height, width, 3] levels, the top row first."""
    scene.frame_set(frame)
    scene.render.filepath = os.path.join(FOLDER, "blender%d.png" % frame)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    width, height = image.size
    pixels = numpy.empty(4 * width * height, numpy.float32)
    image.pixels.foreach_get(pixels)
    return 255 * pixels.reshape(height, width, 4)[::-1, :, :3]


def a_file_that_is_not_there_leaves_no_trace(scene):
    before = len(scene.objects), len(bpy.data.images)
    try:
        blender_avatar.add_avatar(scene, "/nowhere/a.glb", FLAME)
        raise AssertionError("no error")
    except cosplat.Error as error:
        assert "/nowhere/a.glb" in str(error), error
    assert (len(scene.objects), len(bpy.data.images)) == before
    blender_avatar.file_loaded()


def the_render_shows_each_frame(scene, empty):
    for frame, jaw in ((1, 0.0), (9, 0.4)):
        empty["jaw"] = (jaw, 0.0, 0.0)
        empty.keyframe_insert('["jaw"]', frame=frame)
    seen = []
    for frame, jaw in ((1, 0.0), (5, 0.2), (9, 0.4)):
        shown = rendered(scene, frame)
        with cosplat.Avatar(AVATAR, flame=FLAME) as alone:
            alone.set_parameters(jaw=(jaw, 0, 0), expression=[0])
            depsgraph = bpy.context.evaluated_depsgraph_get()
            alone.set_camera(blender_avatar.camera_of(scene, empty, depsgraph, 96, 72))
            rgba = numpy.frombuffer(alone.render(96, 72), numpy.uint8).reshape(72, 96, 4)
        opaque = rgba[..., 3] == 255
        assert opaque.mean() > 0.05, opaque.mean()
        assert shown[rgba[..., 3] == 0].max() < 1  # the world is black
        error = numpy.abs(shown[opaque] - rgba[opaque][:, :3]).max()
        assert error < 1.5, (jaw, error)
        seen.append(shown)
    assert numpy.abs(seen[0] - seen[2]).max() > 20


def points_lie_where_blender_has_them(scene, empty):
    camera = scene.camera
    camera.matrix_world = (
        Matrix.Translation((0.3, -1.4, 0.2))
        @ Matrix.Rotation(0.2, 4, "Z")
        @ Matrix.Rotation(math.pi / 2 - 0.1, 4, "X")
        @ Matrix.Rotation(0.3, 4, "Z")
    )
    camera.data.lens, camera.data.shift_x, camera.data.shift_y = 70, 0.1, -0.2
    empty.matrix_world = (
        Matrix.Translation((0.1, 0.2, -0.1)) @ Matrix.Rotation(0.4, 4, "X") @ Matrix.Scale(1.5, 4)
    )
    for width, height, aspect in ((96, 72, 1), (72, 96, 1), (96, 72, 1.25)):
        scene.render.resolution_x, scene.render.resolution_y = width, height
        scene.render.pixel_aspect_x = aspect
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        ours = blender_avatar.camera_of(scene, empty, depsgraph, width, height)
        m = numpy.array(ours.cam_from_world).reshape(3, 4)
        for point in ((0, 0, 0), (0.1, -0.05, 0.08), (-0.07, 0.12, -0.03)):
            there = world_to_camera_view(
                scene, camera, empty.matrix_world @ blender_avatar.FROM_AVATAR @ Vector(point)
            )
            x, y, z = m[:, :3] @ point + m[:, 3]
            found = ours.fx * x / z + ours.cx, ours.fy * y / z + ours.cy
            wanted = width * there.x, height * (1 - there.y)
            assert numpy.allclose(found, wanted, atol=0.02), (width, aspect, point, found, wanted)


blender_avatar.register()
blender_avatar.unregister()
blender_avatar.register()
scene = empty_scene()
a_file_that_is_not_there_leaves_no_trace(scene)
empty = blender_avatar.add_avatar(scene, AVATAR, FLAME)
assert scene.camera and len(scene.camera.data.background_images) == 1
the_render_shows_each_frame(scene, empty)
points_lie_where_blender_has_them(scene, empty)
