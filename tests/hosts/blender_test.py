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
    scene.world = None  # black; later versions' world is grey
    return scene


def levels_of(image):
    """[height, width, 4], the top row first."""
    width, height = image.size
    pixels = numpy.empty(4 * width * height, numpy.float32)
    image.pixels.foreach_get(pixels)
    return 255 * pixels.reshape(height, width, 4)[::-1]


def rendered(scene, first, last=None, step=1):
    """Frames as Blender writes them, as an animation: levels [height, width, 3] of each."""
    scene.frame_start, scene.frame_end, scene.frame_step = first, last or first, step
    scene.render.filepath = os.path.join(FOLDER, "blender")
    bpy.ops.render.render(animation=True)
    found = []
    for frame in range(first, (last or first) + 1, step):
        image = bpy.data.images.load(scene.render.frame_path(frame=frame))
        found.append(levels_of(image)[..., :3])
        bpy.data.images.remove(image)
    return found


def linear(levels):
    x = levels / 255
    return numpy.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def over_black(rgba):
    """Blender mixes in linear light."""
    x = linear(rgba[..., :3].astype(float)) * rgba[..., 3:] / 255
    return 255 * numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def a_file_that_is_not_there_leaves_no_trace(scene):
    before = len(bpy.data.objects), len(bpy.data.images)
    try:
        blender_avatar.add_avatar(scene, "/nowhere/a.glb", FLAME)
        raise AssertionError("no error")
    except cosplat.Error as error:
        assert "/nowhere/a.glb" in str(error), error
    assert (len(bpy.data.objects), len(bpy.data.images)) == before


def the_render_shows_each_frame(scene, empty):
    for frame, jaw in ((1, 0.0), (9, 0.4)):
        empty["jaw"] = (jaw, 0.0, 0.0)
        empty.keyframe_insert('["jaw"]', frame=frame)
    frames = rendered(scene, 1, 9, 4)
    for shown, jaw in zip(frames, (0.0, 0.2, 0.4)):
        with cosplat.Avatar(AVATAR, flame=FLAME) as alone:
            alone.set_parameters(jaw=(jaw, 0, 0), expression=[0])
            depsgraph = bpy.context.evaluated_depsgraph_get()
            alone.set_camera(blender_avatar.camera_of(scene, empty, depsgraph, 96, 72))
            rgba = numpy.frombuffer(alone.render(96, 72), numpy.uint8).reshape(72, 96, 4)
        assert (rgba[..., 3] == 255).mean() > 0.05
        error = numpy.abs(shown - over_black(rgba)).max()
        assert error < 1, (jaw, error)
    assert numpy.abs(frames[0] - frames[2]).max() > 20


def what_changes_is_drawn(scene, empty):
    def seen():
        bpy.context.view_layer.update()
        return levels_of(empty["cosplat_image"])

    scene.frame_set(1)
    first = seen()
    assert first[..., 3].max() == 255
    empty.location.x += 0.05
    assert numpy.abs(seen() - first).max() > 20
    empty.location.x -= 0.05
    empty.name = "renamed"
    assert numpy.abs(seen() - first).max() == 0
    other = bpy.data.objects.new("other", bpy.data.cameras.new("other"))
    scene.collection.objects.link(other)
    mine, scene.camera = scene.camera, other
    other.location, other.rotation_euler = (0, -2, 0), (1.5707963, 0, 0)
    seen()
    assert len(other.data.background_images) == 1
    scene.camera = mine
    copy = empty.copy()
    scene.collection.objects.link(copy)
    copy.location.x += 0.3
    seen()
    assert copy["cosplat_image"] != empty["cosplat_image"]
    image = copy["cosplat_image"]
    bpy.data.objects.remove(copy)
    assert numpy.abs(seen() - first).max() == 0
    assert levels_of(image).max() == 0  # nothing of what is gone stays
    empty.hide_render = True
    assert seen().max() == 0
    empty.hide_render = False
    mine.data.type = "ORTHO"
    assert seen().max() == 0
    mine.data.type = "PERSP"
    assert numpy.abs(seen() - first).max() == 0
    path = os.path.join(FOLDER, "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    again = bpy.data.objects["renamed"]["cosplat_image"]
    assert numpy.abs(levels_of(again) - first).max() == 0


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
what_changes_is_drawn(scene, empty)
points_lie_where_blender_has_them(bpy.context.scene, bpy.data.objects["renamed"])
