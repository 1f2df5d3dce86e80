"""CoSplat avatars in Blender 3.0 to 5.x (tested with Debian's 3.4, 4.3 and 5.2).

    blender [FILE.blend] --python blender_avatar.py        then Add > CoSplat Avatar

An avatar is an empty whose custom properties can be animated: "jaw", "neck", "root", "left_eye" and
"right_eye" (axis-angle, radians) and "expression_0" on (coefficients). The scene's camera sees the
avatar where the empty stands, through an image of the render's size that follows each frame: it is
shown in front in the camera's view, and lies over what Blender renders (by the compositor). Colours
are as in training under the view transform "Standard", which is set where there was no compositing.

The avatar's front is Blender's front view, its metres are Blender's units; the empty may be scaled
uniformly. It casts no shadows and has no depth: it lies over all that Blender renders, a later
avatar over an earlier one. A hidden or deleted avatar is not shown. Needs cosplat.py beside it, and
to be run with each start of Blender, also where a file is only rendered.
"""

import os
import sys
import threading

import bpy
import numpy
from bpy.app.handlers import persistent
from mathutils import Matrix

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import cosplat  # noqa: E402

EXPRESSIONS = 10  # coefficients that can be animated
FROM_AVATAR = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))  # its y is up
CV = Matrix.Diagonal((1, -1, -1, 1))  # Blender's camera looks along -z, cosplat.h's along +z

# Bytes of sRGB as linear light (IEC 61966-2-1).
LINEAR = numpy.arange(256, dtype=numpy.float32) / 255
LINEAR = numpy.where(LINEAR <= 0.04045, LINEAR / 12.92, ((LINEAR + 0.055) / 1.055) ** 2.4)
LINEAR = LINEAR.astype(numpy.float32)

# A render runs in a thread of its own, and calls the same handlers.
lock = threading.Lock()
opened = {}  # (file, FLAME file) -> cosplat.Avatar
drawn = {}  # an image's name -> what it shows


def avatars(scene):
    return [o for o in scene.objects if "cosplat_avatar" in o]


def open_avatar(path, flame):
    key = bpy.path.abspath(path), bpy.path.abspath(flame)
    if key not in opened:
        opened[key] = cosplat.Avatar(key[0], flame=key[1] or None)
    return opened[key]


def size_of(render):
    percent = render.resolution_percentage
    sides = render.resolution_x * percent // 100, render.resolution_y * percent // 100
    return max(1, sides[0]), max(1, sides[1])


def camera_of(scene, empty, depsgraph, width, height):
    """The scene's camera as the avatar's, at this size."""
    camera, render = scene.camera.evaluated_get(depsgraph), scene.render
    if camera.data.type != "PERSP":
        raise ValueError("needs a perspective camera, not %s" % camera.data.type)
    if render.use_border and render.use_crop_to_border:
        raise ValueError("cannot be cropped to the render region")
    p = camera.calc_matrix_camera(
        depsgraph,
        x=width,
        y=height,
        scale_x=render.pixel_aspect_x,
        scale_y=render.pixel_aspect_y,
    )
    view = CV @ camera.matrix_world.normalized().inverted()
    from_avatar = view @ empty.matrix_world @ FROM_AVATAR
    scale = from_avatar.to_scale()[0]
    if not scale > 0:
        raise ValueError("has the scale %g" % scale)
    rows = [v for row in from_avatar.normalized()[:3] for v in row[:3]]
    to = [v / scale for v in from_avatar.to_translation()]
    out = cosplat.Camera(
        width=width,
        height=height,
        fx=p[0][0] * width / 2,
        fy=p[1][1] * height / 2,
        cx=(1 - p[0][2]) * width / 2,
        cy=(1 + p[1][2]) * height / 2,
    )
    out.cam_from_world = tuple(rows[0:3] + to[0:1] + rows[3:6] + to[1:2] + rows[6:9] + to[2:3])
    return out


def draw(scene, empty, depsgraph):
    """Brings the avatar's image to the current frame, if it shows something else."""
    width, height = size_of(scene.render)
    now, image = empty.evaluated_get(depsgraph), empty["cosplat_image"]
    camera = camera_of(scene, now, depsgraph, width, height)
    joints = {joint: tuple(now[joint]) for joint in cosplat.JOINTS}
    names = ["expression_%d" % k for k in range(EXPRESSIONS)]
    expression = [now[name] for name in names if name in now]
    shows = (bytes(camera), tuple(joints.values()), tuple(expression))
    if drawn.get(image.name) == shows and tuple(image.size) == (width, height):
        return
    avatar = open_avatar(empty["cosplat_avatar"], empty["cosplat_flame"])
    avatar.set_parameters(expression=expression, **joints)
    avatar.set_camera(camera)
    rgba = avatar.render(width, height, alpha=cosplat.STRAIGHT)
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    straight = numpy.frombuffer(rgba, numpy.uint8).reshape(height, width, 4)[::-1]  # its first is below
    pixels = numpy.empty((height, width, 4), numpy.float32)
    pixels[..., 3:] = straight[..., 3:] / numpy.float32(255)
    pixels[..., :3] = LINEAR[straight[..., :3]] * pixels[..., 3:]
    fill(image, pixels.ravel())
    drawn[image.name] = shows


def fill(image, pixels):
    image.pixels.foreach_set(pixels)
    image.update()


def clear(image):
    if drawn.get(image.name) != "nothing":
        fill(image, numpy.zeros(4 * image.size[0] * image.size[1], numpy.float32))
        drawn[image.name] = "nothing"


def new_image(name, scene):
    """Linear light, colours multiplied by alpha: from 4.2 on bytes are multiplied before they are
    linear."""
    image = bpy.data.images.new(name, *size_of(scene.render), alpha=True, float_buffer=True)
    image.alpha_mode, image.generated_color = "PREMUL", (0, 0, 0, 0)  # as it is loaded again
    image["cosplat"] = True
    return image


def needs_image(empty, shown):
    """Also of a copy of an avatar, which has its image until now, and of files of before."""
    image = empty["cosplat_image"]
    return image is None or image.name in shown or not image.is_float


def draw_all(scene, depsgraph=None):
    with lock:
        depsgraph = depsgraph or bpy.context.evaluated_depsgraph_get()
        shown = set()
        for empty in avatars(scene):
            try:
                if needs_image(empty, shown):
                    empty["cosplat_image"] = new_image(empty.name, scene)
                    compose(scene, empty["cosplat_image"])
                image = empty["cosplat_image"]
                if scene.camera is None or empty.hide_render:
                    continue
                show_in_camera(scene.camera.data, image)
                draw(scene, empty, depsgraph)
                shown.add(image.name)
            except Exception as error:  # of one avatar; the others are drawn, and the render goes on
                print("%s: %s" % (empty.name, error), file=sys.stderr)
        for image in bpy.data.images:
            if "cosplat" in image and image.name not in shown:
                clear(image)


def show_in_camera(camera, image):
    """In front of what the camera's view shows."""
    if any(shown.image == image for shown in camera.background_images):
        return
    camera.show_background_images = True
    shown = camera.background_images.new()
    shown.image, shown.display_depth, shown.alpha = image, "FRONT", 1


def compose(scene, image):
    """Lays the image over what the scene's compositor puts out."""
    tree, kind = compositor_of(scene)
    nodes, links = tree.nodes, tree.links
    out = next((n for n in nodes if n.bl_idname == kind), None) or nodes.new(kind)
    link = next((k for k in links if k.to_node == out and k.to_socket.name == "Image"), None)
    over, node = nodes.new("CompositorNodeAlphaOver"), nodes.new("CompositorNodeImage")
    node.image = image
    behind, front = ("Background", "Foreground") if "Background" in over.inputs else (1, 2)
    if hasattr(over, "use_premultiply"):
        over.use_premultiply = False
    if link:
        links.new(link.from_socket, over.inputs[behind])
    links.new(node.outputs["Image"], over.inputs[front])
    links.new(over.outputs["Image"], out.inputs["Image"])


def compositor_of(scene):
    """The tree of the scene's compositor, made if there is none, and what its last node is."""
    grouped = hasattr(scene, "compositing_node_group")  # from 5.0 on
    made = scene.compositing_node_group is None if grouped else not scene.use_nodes
    if made:
        scene.view_settings.view_transform = "Standard"
    if not grouped:
        scene.use_nodes = True
        return scene.node_tree, "CompositorNodeComposite"
    if made:
        tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        layers, out = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("NodeGroupOutput")
        tree.links.new(layers.outputs["Image"], out.inputs["Image"])
        scene.compositing_node_group = tree
    return scene.compositing_node_group, "NodeGroupOutput"


def add_avatar(scene, path, flame=""):
    """An empty that shows the avatar in the scene's camera; a camera is added if there is none."""
    avatar = open_avatar(path, flame)  # a file that cannot be opened leaves no trace
    empty = bpy.data.objects.new(os.path.splitext(os.path.basename(path))[0], None)
    empty["cosplat_avatar"], empty["cosplat_flame"] = path, flame
    for joint in cosplat.JOINTS:
        empty[joint] = (0.0, 0.0, 0.0)
    for k in range(min(EXPRESSIONS, avatar.info().expression_count)):
        empty["expression_%d" % k] = 0.0
    scene.collection.objects.link(empty)
    if scene.camera is None:
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        camera.location, camera.rotation_euler = (0, -1, 0), (1.5707963, 0, 0)
        scene.collection.objects.link(camera)
        scene.camera = camera
    empty["cosplat_image"] = new_image(empty.name, scene)
    compose(scene, empty["cosplat_image"])
    # Images must not change in the window while a render's thread changes them.
    scene.render.use_lock_interface = True
    bpy.context.view_layer.update()
    draw_all(scene)
    return empty


class OBJECT_OT_cosplat_avatar(bpy.types.Operator):
    """Add a CoSplat avatar in front of the scene's camera"""

    bl_idname = "object.cosplat_avatar_add"
    bl_label = "CoSplat Avatar"
    bl_options = {"REGISTER", "UNDO"}

    filepath: bpy.props.StringProperty(name="Avatar", subtype="FILE_PATH")
    filter_glob: bpy.props.StringProperty(default="*.glb", options={"HIDDEN"})
    flame: bpy.props.StringProperty(
        name="FLAME", description="The model that it was trained with, if the file lacks it"
    )

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            add_avatar(context.scene, self.filepath, self.flame)
        except (cosplat.Error, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def menu(self, context):
    self.layout.operator(OBJECT_OT_cosplat_avatar.bl_idname, icon="USER")


@persistent
def changed(scene, depsgraph=None):
    draw_all(scene, depsgraph)


@persistent
def loaded(*_):
    opened.clear()
    drawn.clear()
    draw_all(bpy.context.scene)


HANDLERS = (
    (bpy.app.handlers.frame_change_post, changed),
    (bpy.app.handlers.depsgraph_update_post, changed),
    (bpy.app.handlers.load_post, loaded),
)


def register():
    bpy.utils.register_class(OBJECT_OT_cosplat_avatar)
    bpy.types.VIEW3D_MT_add.append(menu)
    for handlers, handler in HANDLERS:
        handlers.append(handler)
    loaded()


def unregister():
    for handlers, handler in HANDLERS:
        handlers.remove(handler)
    bpy.types.VIEW3D_MT_add.remove(menu)
    bpy.utils.unregister_class(OBJECT_OT_cosplat_avatar)
    opened.clear()


if __name__ == "__main__":
    register()
