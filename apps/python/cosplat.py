"""Head avatars of Gaussian splats: libcosplat.so from Python, by ctypes alone.

    import cosplat

    with cosplat.Avatar("avatar.glb", flame="flame2023.pkl") as avatar:
        avatar.set_parameters(expression=[1.0], jaw=(0.1, 0, 0))
        pixels = avatar.render(512, 512)          # bytearray: RGBA, straight alpha, top row first

What the functions do, their units and their threads are those of cosplat.h and docs/plugin.md; a
call that fails raises cosplat.Error with the library's own line. Pictures go into any writable
buffer (a bytearray, an array of numpy's) that is as large as they are.
"""

import ctypes as c
import os
from pathlib import Path

VERSION = (0, 2)  # of cosplat.h: the structures below are those of this version

JOINTS = ("root", "neck", "jaw", "left_eye", "right_eye")
DEVICE_AUTO, DEVICE_CPU, DEVICE_CUDA = range(3)
BUST_FOLLOWS, BUST_STILL = range(2)
RGBA8, BGRA8 = range(2)
STRAIGHT, PREMULTIPLIED, OPAQUE = range(3)
RANGE_SOFT, RANGE_FREE = range(2)
SMOOTHING_NONE, SMOOTHING_ONE_EURO = range(2)
FACE_REST, FACE_LIVE, FACE_DECAYING, FACE_RETURNING = range(4)


class _Structure(c.Structure):
    """All zero but for its size, which is how cosplat.h wants it."""

    def __init__(self, **fields):
        super().__init__(c.sizeof(type(self)), **fields)


class OpenOptions(_Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("device", c.c_uint32),
        ("flame_path", c.c_char_p),
        ("bust", c.c_uint32),
    ]


class Info(_Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("gaussian_count", c.c_uint32),
        ("triangle_count", c.c_uint32),
        ("expression_count", c.c_uint32),
        ("joint_count", c.c_uint32),
        ("box_min", c.c_float * 3),
        ("box_max", c.c_float * 3),
        ("background", c.c_float * 3),
        ("knows_filmed", c.c_uint32),
        ("filmed_yaw", c.c_float * 2),
        ("filmed_pitch", c.c_float * 2),
    ]


class Parameters(_Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("expression_count", c.c_uint32),
        ("expression", c.POINTER(c.c_float)),
        ("time_ns", c.c_int64),
        ("joints", c.c_float * 3 * len(JOINTS)),
        ("translation", c.c_float * 3),
    ]


class Policy(_Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("hold_s", c.c_float),
        ("decay_s", c.c_float),
        ("blend_in_s", c.c_float),
        ("range", c.c_uint32),
        ("smoothing", c.c_uint32),
        ("min_cutoff_hz", c.c_float),
        ("beta", c.c_float),
        ("loop", c.c_uint32),
        ("frames_per_second", c.c_float),
    ]


class Health(_Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("face", c.c_uint32),
        ("age_s", c.c_float),
        ("drive_ended", c.c_uint32),
        ("accepted", c.c_uint64),
        ("replaced", c.c_uint64),
        ("late", c.c_uint64),
        ("not_finite", c.c_uint64),
        ("out_of_range", c.c_uint64),
        ("wrong_size", c.c_uint64),
        ("softened", c.c_uint64),
        ("held", c.c_uint64),
        ("decayed", c.c_uint64),
        ("returned", c.c_uint64),
        ("drive_frames", c.c_uint64),
        ("drive_replaced", c.c_uint64),
        ("drive_reordered", c.c_uint64),
        ("drive_malformed", c.c_uint64),
        ("drive_oversize", c.c_uint64),
        ("drive_flooded", c.c_uint64),
        ("drive", c.c_char_p),
        ("drive_problem", c.c_char_p),
        ("drive_packets", c.c_uint64),
        ("drive_unusable", c.c_uint64),
        ("drive_notes", c.c_char_p),
        ("beyond_film", c.c_uint64),
    ]


class Camera(_Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("width", c.c_uint32),
        ("height", c.c_uint32),
        ("fx", c.c_float),
        ("fy", c.c_float),
        ("cx", c.c_float),
        ("cy", c.c_float),
        ("cam_from_world", c.c_float * 12),
    ]


class Picture(_Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("width", c.c_uint32),
        ("height", c.c_uint32),
        ("format", c.c_uint32),
        ("alpha", c.c_uint32),
        ("background", c.c_float * 3),
        ("pixels", c.c_void_p),
        ("stride", c.c_int64),
        ("depth", c.c_void_p),
        ("depth_stride", c.c_int64),
    ]


_Handle, _Uint, _Float, _Text, _Time = c.c_void_p, c.c_uint32, c.c_float, c.c_char_p, c.c_int64
_Vector = c.c_float * 3
STRUCTURES = (OpenOptions, Info, Parameters, Policy, Health, Camera, Picture)
# What they take; all of them but those of TEXTS return a status.
FUNCTIONS = {
    "open": (_Text, c.POINTER(OpenOptions), c.POINTER(_Handle)),
    "close": (_Handle,),
    "get_info": (_Handle, c.POINTER(Info)),
    "expression_name": (_Handle, _Uint, c.POINTER(_Text)),
    "joint_name": (_Handle, _Uint, c.POINTER(_Text)),
    "find_expression": (_Handle, _Text, c.POINTER(_Uint)),
    "find_joint": (_Handle, _Text, c.POINTER(_Uint)),
    "set_parameters": (_Handle, c.POINTER(Parameters)),
    "get_parameters": (_Handle, c.POINTER(Parameters)),
    "reset_parameters": (_Handle,),
    "set_expression": (_Handle, _Uint, _Float, _Time),
    "set_joint": (_Handle, _Uint, _Vector, _Time),
    "set_translation": (_Handle, _Vector, _Time),
    "advance": (_Handle, _Time),
    "set_drive": (_Handle, _Text),
    "set_policy": (_Handle, c.POINTER(Policy)),
    "get_health": (_Handle, c.POINTER(Health)),
    "set_camera": (_Handle, c.POINTER(Camera)),
    "get_camera": (_Handle, c.POINTER(Camera)),
    "orbit_camera": (_Handle, _Uint, _Uint, _Float, _Float, _Float, c.POINTER(Camera)),
    "render": (_Handle, c.POINTER(Picture)),
}
TEXTS = {"version_text": (), "status_text": (c.c_int32,), "last_error": (_Handle,)}


class Error(Exception):
    """What the library says was wrong; `status` is its COSPLAT_ERROR_..."""

    def __init__(self, status, text):
        super().__init__(text)
        self.status = status


def _load():
    """COSPLAT_LIBRARY; the library of the installation that this file is in; the system's."""
    name = "libcosplat.so.%d.%d" % VERSION
    beside = Path(__file__).resolve().parent.parent.parent / name
    loaded = c.CDLL(os.environ.get("COSPLAT_LIBRARY") or str(beside if beside.exists() else name))
    for function, arguments in (FUNCTIONS | TEXTS).items():
        bound = getattr(loaded, "cosplat_" + function)
        bound.argtypes = arguments
        bound.restype = c.c_char_p if function in TEXTS else c.c_int32
    loaded.cosplat_version.argtypes, loaded.cosplat_version.restype = (), c.c_uint32
    version = loaded.cosplat_version()
    if (version >> 16, version >> 8 & 255) != VERSION:
        text = loaded.cosplat_version_text().decode()
        raise ImportError("libcosplat %s is not the version of this module, %d.%d" % (text, *VERSION))
    return loaded


library = _load()  # its functions: library.cosplat_open and so on


def version():
    """Of the library that runs: "0.2.0"."""
    return library.cosplat_version_text().decode()


def _check(status, handle=None):
    if status:
        raise Error(status, library.cosplat_last_error(handle).decode())


def _path(path):
    return None if path is None else os.fsencode(path)


class Avatar:
    """An open avatar; `with` closes it."""

    def __init__(self, path, flame=None, device=DEVICE_AUTO, bust=BUST_FOLLOWS):
        self._handle = _Handle()
        options = OpenOptions(device=device, flame_path=_path(flame), bust=bust)
        _check(library.cosplat_open(_path(path), options, c.byref(self._handle)))
        self.rest = Parameters()  # what it is opened with
        self._call("get_parameters", self.rest)

    def close(self):
        library.cosplat_close(self._handle)
        self._handle = _Handle()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def __del__(self):
        if getattr(self, "_handle", None):
            self.close()

    def _call(self, function, *arguments):
        function = getattr(library, "cosplat_" + function)
        _check(function(self._handle, *arguments), self._handle)

    def info(self):
        info = Info()
        self._call("get_info", info)
        return info

    def expression_names(self):
        names, name = [], _Text()
        for number in range(self.info().expression_count):
            self._call("expression_name", number, c.byref(name))
            names.append(name.value.decode())
        return names

    def set_parameters(self, expression=(), translation=None, time_ns=0, **joints):
        """Joints by name (JOINTS), axis-angle; those that are not given stay at rest."""
        coefficients = (c.c_float * len(expression))(*expression)
        parameters = Parameters(
            expression_count=len(expression), expression=coefficients, time_ns=time_ns
        )
        parameters.joints, parameters.translation = self.rest.joints, self.rest.translation
        if translation is not None:
            parameters.translation = tuple(translation)
        for joint, turn in joints.items():
            parameters.joints[JOINTS.index(joint)] = tuple(turn)
        self._call("set_parameters", parameters)

    def reset_parameters(self):
        self._call("reset_parameters")

    def set_drive(self, drive):
        """As docs/live-input.md; None: none."""
        self._call("set_drive", _path(drive))

    def set_policy(self, **fields):
        self._call("set_policy", Policy(**fields))

    def advance(self, now_ns):
        self._call("advance", now_ns)

    def health(self):
        health = Health()
        self._call("get_health", health)
        return health

    def orbit_camera(self, width, height, azimuth=0.0, elevation=0.0, zoom=1.0):
        camera = Camera()
        self._call("orbit_camera", width, height, azimuth, elevation, zoom, camera)
        return camera

    def set_camera(self, camera):
        self._call("set_camera", camera)

    def render(
        self, width, height, pixels=None, format=RGBA8, alpha=STRAIGHT, background=(0, 0, 0)
    ):
        """Draws into `pixels`, or a new bytearray, and returns it."""
        size = 4 * width * height
        pixels = bytearray(size) if pixels is None else pixels
        memory = (c.c_char * size).from_buffer(pixels)  # refuses what is too small
        picture = Picture(
            width=width, height=height, format=format, alpha=alpha, background=tuple(background)
        )
        picture.pixels = c.addressof(memory)
        self._call("render", picture)
        return pixels
