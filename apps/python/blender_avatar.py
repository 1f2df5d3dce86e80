"""CoSplat avatars in Blender (3.0 or newer; made and tested with Debian's 3.4).

    blender --python blender_avatar.py                 then Add > CoSplat Avatar

An avatar is an empty whose custom properties can be animated: "jaw", "neck", "root", "left_eye" and
"right_eye" (axis-angle, radians) and "expression" (the first coefficients). The scene's camera sees
the avatar where the empty stands: an image "NAME.image" of the render's size follows each frame, is
shown in front in the camera's view, and lies over what Blender renders (by the compositor). Colours
are as in training under the view transform "Standard", which is set where there was no compositing.

The avatar's front is Blender's front view, its metres are Blender's units. The empty may be scaled
uniformly. It casts no shadows, and lies over all that Blender renders: it has no depth there.
"""

import os
import sys

import bpy
import numpy
from bpy.app.handlers import persistent
from mathutils import Matrix

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import cosplat  # noqa: E402

bl_info = {
    "name": "CoSplat avatars",
    "blender": (3, 0, 0),
    "category": "Object",
    "description": "Head avatars of Gaussian splats in front of the scene's camera",
}

EXPRESSIONS = 10  # coefficients that can be animated
FROM_AVATAR = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))  # its y is up
CV = Matrix.Diagonal((1, -1, -1, 1))  # Blender's camera looks along -z, cosplat.h's along +z

opened = {}  # (file, FLAME file) -> cosplat.Avatar


def avatars(scene):
    return [o for o in scene.objects if "cosplat_avatar" in o]


def open_avatar(empty):
    key = tuple(bpy.path.abspath(empty[k]) for k in ("cosplat_avatar", "cosplat_flame"))
    if key not in opened:
        opened[key] = cosplat.Avatar(key[0], flame=key[1] or None)
    return opened[key]


def camera_of(scene, empty, depsgraph, width, height):
    """The scene's camera as the avatar's, at this size."""
    camera = scene.camera.evaluated_get(depsgraph)
    pixel_x, pixel_y = scene.render.pixel_aspect_x, scene.render.pixel_aspect_y
    p = camera.calc_matrix_camera(
        depsgraph, x=width, y=height, scale_x=pixel_x, scale_y=pixel_y
    )
    view = CV @ camera.matrix_world.normalized().inverted()
    from_avatar = view @ empty.matrix_world @ FROM_AVATAR
    scale = from_avatar.to_scale()[0]
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
    """Brings the avatar's image to the current frame."""
    width, height = (
        max(1, side * scene.render.resolution_percentage // 100)
        for side in (scene.render.resolution_x, scene.render.resolution_y)
    )
    avatar, now = open_avatar(empty), empty.evaluated_get(depsgraph)
    joints = {joint: tuple(now[joint]) for joint in cosplat.JOINTS}
    avatar.set_parameters(expression=list(now["expression"]), **joints)
    avatar.set_camera(camera_of(scene, now, depsgraph, width, height))
    rgba = avatar.render(width, height, alpha=cosplat.STRAIGHT)
    image = image_of(empty, width, height)
    rows = numpy.frombuffer(rgba, numpy.uint8).reshape(height, -1)[::-1]  # Blender's first is below
    image.pixels.foreach_set((rows.astype(numpy.float32) / 255).ravel())
    image.update()
    return image


def image_of(empty, width, height):
    name = empty.name + ".image"
    image = bpy.data.images.get(name)
    if image is None:
        image = bpy.data.images.new(name, width, height, alpha=True)
        image.alpha_mode = "STRAIGHT"
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    return image


def draw_all(scene, depsgraph=None):
    if scene.camera is None:
        return
    depsgraph = depsgraph or bpy.context.evaluated_depsgraph_get()
    for empty in avatars(scene):
        try:
            draw(scene, empty, depsgraph)
        except (cosplat.Error, OSError) as error:
            print("%s: %s" % (empty.name, error), file=sys.stderr)


@persistent
def frame_changed(scene, depsgraph=None):
    draw_all(scene, depsgraph)


@persistent
def file_loaded(*_):
    opened.clear()


def show_in_camera(camera, image):
    """In front of what the camera's view shows."""
    camera.show_background_images = True
    shown = camera.background_images.new()
    shown.image, shown.display_depth, shown.alpha = image, "FRONT", 1


def compose(scene, image):
    """Lays the image over what the scene's compositor puts out."""
    first = not scene.use_nodes
    scene.use_nodes = True
    tree = scene.node_tree
    out = next(n for n in tree.nodes if n.bl_idname == "CompositorNodeComposite")
    link = next((k for k in tree.links if k.to_node == out and k.to_socket.name == "Image"), None)
    over, node = tree.nodes.new("CompositorNodeAlphaOver"), tree.nodes.new("CompositorNodeImage")
    node.image = image
    over.use_premultiply = False
    if link:
        tree.links.new(link.from_socket, over.inputs[1])
    tree.links.new(node.outputs["Image"], over.inputs[2])
    tree.links.new(over.outputs["Image"], out.inputs["Image"])
    if first:
        scene.view_settings.view_transform = "Standard"


def add_avatar(scene, path, flame=""):
    """An empty that shows the avatar in the scene's camera; a camera is added if there is none."""
    empty = bpy.data.objects.new(os.path.splitext(os.path.basename(path))[0], None)
    empty["cosplat_avatar"], empty["cosplat_flame"] = path, flame
    open_avatar(empty)  # before anything is added: a file that cannot be opened leaves no trace
    for joint in cosplat.JOINTS:
        empty[joint] = (0.0, 0.0, 0.0)
    count = min(EXPRESSIONS, open_avatar(empty).info().expression_count)
    empty["expression"] = (0.0,) * max(1, count)
    scene.collection.objects.link(empty)
    if scene.camera is None:
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        camera.location, camera.rotation_euler = (0, -1, 0), (1.5707963, 0, 0)
        scene.collection.objects.link(camera)
        scene.camera = camera
    bpy.context.view_layer.update()
    image = draw(scene, empty, bpy.context.evaluated_depsgraph_get())
    show_in_camera(scene.camera.data, image)
    compose(scene, image)
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


HANDLERS = (
    (bpy.app.handlers.frame_change_post, frame_changed),
    (bpy.app.handlers.render_init, frame_changed),
    (bpy.app.handlers.load_post, file_loaded),
)


def register():
    bpy.utils.register_class(OBJECT_OT_cosplat_avatar)
    bpy.types.VIEW3D_MT_add.append(menu)
    for handlers, handler in HANDLERS:
        handlers.append(handler)


def unregister():
    for handlers, handler in HANDLERS:
        handlers.remove(handler)
    bpy.types.VIEW3D_MT_add.remove(menu)
    bpy.utils.unregister_class(OBJECT_OT_cosplat_avatar)
    file_loaded()


if __name__ == "__main__":
    register()
