/* CoSplat's C interface: opens head avatars, poses them and renders them into the caller's memory.
 *
 * cosplat_open -> cosplat_set_parameters, cosplat_set_camera -> cosplat_render -> pixels. These
 * functions are all that libcosplat.so exports. C99; docs/plugin.md describes the life of a frame
 * and has an example.
 *
 * Errors. Functions return a status. None throws an exception or ends the program, whatever its
 * arguments, and one that fails changes nothing. cosplat_last_error describes the failure.
 *
 * Threads. One thread at a time may use a handle; a call that finds it in use returns
 * COSPLAT_ERROR_BUSY at once. Handles are independent: any number of threads may each use their
 * own, whichever thread opened it. Images are bit-identical whatever else is rendered meanwhile.
 *
 * Coordinates. The world is that of the avatar's training data: right-handed, in metres. FLAME's
 * own has y up, the face towards +z and +x to the subject's left. A camera looks along +z, with x
 * to the right and y down (OpenCV).
 *
 * Versions. Every structure begins with its own size, which the caller sets, so that later versions
 * can add fields at its end. A field that is zero behaves as if it were absent. */
#ifndef COSPLAT_H_
#define COSPLAT_H_

#include <stdint.h>

#if defined(__GNUC__)
#define COSPLAT_API __attribute__((visibility("default")))
#else
#define COSPLAT_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Semantic version. While the major number is 0, a new minor number may break programs that were
 * built for the previous one; the library's soname contains both. */
#define COSPLAT_VERSION_MAJOR 0
#define COSPLAT_VERSION_MINOR 2
#define COSPLAT_VERSION_PATCH 0
#define COSPLAT_MAKE_VERSION(major, minor, patch) \
  (((uint32_t)(major) << 16) | ((uint32_t)(minor) << 8) | (uint32_t)(patch))
#define COSPLAT_VERSION \
  COSPLAT_MAKE_VERSION(COSPLAT_VERSION_MAJOR, COSPLAT_VERSION_MINOR, COSPLAT_VERSION_PATCH)

/* The version of the loaded library, to compare with COSPLAT_VERSION; and as text. */
COSPLAT_API uint32_t cosplat_version(void);
COSPLAT_API const char* cosplat_version_text(void); /* "0.2.0" */

typedef int32_t cosplat_status;
enum {
  COSPLAT_OK = 0,
  COSPLAT_ERROR_ARGUMENT = 1,   /* NULL, or a size, enumerated value or number out of range */
  COSPLAT_ERROR_HANDLE = 2,     /* not an open avatar */
  COSPLAT_ERROR_BUSY = 3,       /* another thread is using the handle */
  COSPLAT_ERROR_NOT_FOUND = 4,  /* no expression or joint of that name or index; no camera set */
  COSPLAT_ERROR_NOT_FINITE = 5, /* a NaN or an infinity */
  COSPLAT_ERROR_LATE = 6,       /* older than the current parameters, or than the avatar's time */
  COSPLAT_ERROR_FILE = 7,       /* the file cannot be read, or is not an avatar */
  COSPLAT_ERROR_FLAME = 8,      /* the FLAME model is missing, unreadable or not the avatar's */
  COSPLAT_ERROR_DEVICE = 9,     /* the library was built without the device, or there is none */
  COSPLAT_ERROR_MEMORY = 10,    /* out of memory */
  COSPLAT_ERROR_INTERNAL = 11,  /* a bug in the library; please report it */
  COSPLAT_ERROR_DRIVE = 12      /* the drive cannot be opened: not found, or invalid */
};
/* A short description, such as "not found"; never NULL. */
COSPLAT_API const char* cosplat_status_text(cosplat_status status);

/* An open avatar. Handles are never dereferenced: a closed or invalid one is refused safely. */
typedef struct cosplat_avatar cosplat_avatar;

/* One line of UTF-8 that describes the last call with this handle that failed, "" if none did;
 * never NULL. Valid until the next call with the handle. With NULL it describes the last failed
 * call of the calling thread, whatever its handle: use this after cosplat_open and for
 * COSPLAT_ERROR_HANDLE and COSPLAT_ERROR_BUSY. */
COSPLAT_API const char* cosplat_last_error(cosplat_avatar* avatar);

/* --- Opening ---------------------------------------------------------------------------------- */

/* AUTO lets the library choose; in this version it always chooses the CPU. CUDA is an NVIDIA GPU,
 * if the library was built with CUDA. */
enum { COSPLAT_DEVICE_AUTO = 0, COSPLAT_DEVICE_CPU = 1, COSPLAT_DEVICE_CUDA = 2 };

/* FOLLOWS: shoulders follow the head as they did in training. STILL: they stay where they were on
 * average. Avatars without a bust, or from before it learned to follow, look the same with both. */
enum { COSPLAT_BUST_FOLLOWS = 0, COSPLAT_BUST_STILL = 1 };

typedef struct cosplat_open_options {
  uint32_t struct_size; /* sizeof(cosplat_open_options) */
  uint32_t device;      /* COSPLAT_DEVICE_... */
  /* The FLAME model (.pkl or .npz) that the avatar was trained with. NULL: the one in the avatar's
   * file, which has it if the model's licence allows that; FLAME's does not. Then cosplat_open
   * returns COSPLAT_ERROR_FLAME, and the error text names the model. */
  const char* flame_path;
  uint32_t bust; /* COSPLAT_BUST_... */
} cosplat_open_options;

/* Opens an avatar. avatar_path: a .glb written by `cosplat train-avatar`. Paths are UTF-8. On
 * failure *avatar is NULL. A new avatar is at rest: zero expression, no joint rotated except the
 * root, and the head where it was in training. */
COSPLAT_API cosplat_status cosplat_open(const char* avatar_path,
                                        const cosplat_open_options* options,
                                        cosplat_avatar** avatar);

/* Closes an avatar; NULL is allowed and does nothing. A call that another thread is making with the
 * handle still completes, later ones are refused. */
COSPLAT_API cosplat_status cosplat_close(cosplat_avatar* avatar);

/* --- Properties ------------------------------------------------------------------------------- */

typedef struct cosplat_info {
  uint32_t struct_size; /* sizeof(cosplat_info); all other fields are output */
  uint32_t gaussian_count;
  uint32_t triangle_count; /* of the mesh that the Gaussians are embedded on */
  uint32_t expression_count;
  uint32_t joint_count;
  float box_min[3], box_max[3]; /* metres, world: bounds of the Gaussians' centres at rest */
  float background[3];          /* sRGB from 0 to 1: background on which it was evaluated */
  /* From where the head was filmed, radians, least and most: yaw to its left, pitch upwards. More
   * than 12 degrees beyond them a picture is a guess. Has sense only if knows_filmed is 1, which it
   * is not for heads of other trainers. */
  uint32_t knows_filmed;
  float filmed_yaw[2], filmed_pitch[2];
} cosplat_info;

/* Writes the avatar's properties, which do not change while it is open. */
COSPLAT_API cosplat_status cosplat_get_info(cosplat_avatar* avatar, cosplat_info* info);

/* Indices of the joints. Their names are those of the constants, in lower case and without the
 * prefix: "root", "neck", "jaw", "left_eye", "right_eye". */
enum {
  COSPLAT_JOINT_ROOT = 0, /* rotates the whole head and neck: the global pose */
  COSPLAT_JOINT_NECK = 1,
  COSPLAT_JOINT_JAW = 2,
  COSPLAT_JOINT_LEFT_EYE = 3, /* the subject's left */
  COSPLAT_JOINT_RIGHT_EYE = 4,
  COSPLAT_JOINT_COUNT = 5
};

/* Convert between indices and names. FLAME's expression coefficients have no names of their own and
 * are called "expression_0", "expression_1", ... Returned names are valid until the avatar is
 * closed. An unknown index or name is COSPLAT_ERROR_NOT_FOUND. */
COSPLAT_API cosplat_status cosplat_expression_name(cosplat_avatar* avatar,
                                                   uint32_t expression,
                                                   const char** name);
COSPLAT_API cosplat_status cosplat_joint_name(cosplat_avatar* avatar,
                                              uint32_t joint,
                                              const char** name);
COSPLAT_API cosplat_status cosplat_find_expression(cosplat_avatar* avatar,
                                                   const char* name,
                                                   uint32_t* expression);
COSPLAT_API cosplat_status cosplat_find_joint(cosplat_avatar* avatar,
                                              const char* name,
                                              uint32_t* joint);

/* --- Parameters ------------------------------------------------------------------------------- */

/* FLAME parameters of a face at one time. Numbers must be finite and at most
 * COSPLAT_LARGEST_PARAMETER in magnitude. */
#define COSPLAT_LARGEST_PARAMETER 100
typedef struct cosplat_parameters {
  uint32_t struct_size; /* sizeof(cosplat_parameters) */
  /* Number of coefficients in `expression`, at most 65536. Missing ones count as zero; those that
   * the model does not have are ignored. */
  uint32_t expression_count;
  const float* expression; /* may be NULL if expression_count is 0 */
  /* Timestamp, from any clock of the caller that does not run backwards. Parameters that are older
   * than the current ones are refused (COSPLAT_ERROR_LATE); equal times are accepted. */
  int64_t time_ns;
  float joints[COSPLAT_JOINT_COUNT][3]; /* axis-angle, radians */
  float translation[3];                 /* metres, applied after all rotations */
} cosplat_parameters;

/* Sets all parameters or, on failure, none: the previous ones stay in effect. */
COSPLAT_API cosplat_status cosplat_set_parameters(cosplat_avatar* avatar,
                                                  const cosplat_parameters* parameters);
/* Writes the current parameters. `expression` points to the library's memory, is valid until the
 * next call with the handle, and may be passed to that call. `time_ns` is INT64_MIN before any
 * parameters were set. */
COSPLAT_API cosplat_status cosplat_get_parameters(cosplat_avatar* avatar,
                                                  cosplat_parameters* parameters);
/* Returns to rest, as after cosplat_open. Parameters and cosplat_advance may have any time again,
 * and until the next cosplat_advance the set parameters are rendered. A drive is kept. */
COSPLAT_API cosplat_status cosplat_reset_parameters(cosplat_avatar* avatar);

/* Set a single parameter and leave the others unchanged. Indices are those of cosplat_find_...;
 * limits and timestamps are as in cosplat_parameters. */
COSPLAT_API cosplat_status cosplat_set_expression(cosplat_avatar* avatar,
                                                  uint32_t expression,
                                                  float value,
                                                  int64_t time_ns);
COSPLAT_API cosplat_status cosplat_set_joint(cosplat_avatar* avatar,
                                             uint32_t joint,
                                             const float axis_angle[3],
                                             int64_t time_ns);
COSPLAT_API cosplat_status cosplat_set_translation(cosplat_avatar* avatar,
                                                   const float translation[3],
                                                   int64_t time_ns);

/* --- Live ------------------------------------------------------------------------------------- */

/* Advances the avatar's time to `now_ns`, from the clock of the parameters' timestamps. From the
 * first call on, cosplat_render shows the face at the time of the last call: bad frames are
 * refused; without new ones the last good frame is held, then the face eases to rest, and back when
 * frames arrive again. Parameters set by the host show from the next cosplat_advance on.
 * COSPLAT_ERROR_LATE if `now_ns` is earlier than in the previous call. A host that never calls this
 * renders the parameters that it sets. */
COSPLAT_API cosplat_status cosplat_advance(cosplat_avatar* avatar, int64_t now_ns);

/* Sets a drive, a source of frames besides cosplat_set_..., whose newest frame cosplat_advance
 * takes: a recording (.npz or the folder of a tracked video), "webcam:", "audio:" (by the program
 * cosplat in PATH), "stdin:", "udp://HOST:PORT", "vmc://HOST:PORT" or an app on a phone
 * (docs/live-input.md). NULL removes the drive. A recording starts at the next cosplat_advance. On
 * failure (COSPLAT_ERROR_DRIVE) the previous drive is kept. */
COSPLAT_API cosplat_status cosplat_set_drive(cosplat_avatar* avatar, const char* drive);

/* SOFT: expressions and joint angles beyond the range seen in training are compressed towards it.
 * FREE: they are used unchanged. */
enum { COSPLAT_RANGE_SOFT = 0, COSPLAT_RANGE_FREE = 1 };
enum { COSPLAT_SMOOTHING_NONE = 0, COSPLAT_SMOOTHING_ONE_EURO = 1 };

/* How a live face reacts to bad, late and missing frames. Zero means the default, which is the
 * number that a field's comment begins with; so does a policy that was never set. */
typedef struct cosplat_policy {
  uint32_t struct_size;    /* sizeof(cosplat_policy) */
  float hold_s;            /* 0.25: time for which the last good frame is held */
  float decay_s;           /* 1: duration of the transition to rest after that */
  float blend_in_s;        /* 0.2: duration of the transition back; all three from 1e-6 to 1e6 */
  uint32_t range;          /* COSPLAT_RANGE_... */
  uint32_t smoothing;      /* COSPLAT_SMOOTHING_...: adds a delay, see docs/plugin.md */
  float min_cutoff_hz;     /* 2: cutoff of the one-euro filter at rest */
  float beta;              /* 1: Hz per unit of speed (1 coefficient, 0.1 rad, 0.02 m per s) */
  uint32_t loop;           /* whether recordings repeat: 0 or 1; for drives set afterwards */
  float frames_per_second; /* of recordings; default: their own, or 25; for drives set afterwards */
} cosplat_policy;
/* Replaces the policy and restarts smoothing. */
COSPLAT_API cosplat_status cosplat_set_policy(cosplat_avatar* avatar, const cosplat_policy* policy);

enum {
  COSPLAT_FACE_REST = 0,     /* no frame arrived yet, or none for so long that it decayed */
  COSPLAT_FACE_LIVE = 1,     /* shows the last good frame, at most hold_s old */
  COSPLAT_FACE_DECAYING = 2, /* easing to rest */
  COSPLAT_FACE_RETURNING = 3 /* easing back to new frames */
};

/* Counts since cosplat_open; those of the drive since cosplat_set_drive. */
typedef struct cosplat_health {
  uint32_t struct_size; /* sizeof(cosplat_health); all other fields are output */
  uint32_t face;        /* COSPLAT_FACE_... after the last cosplat_advance */
  float age_s;          /* at that time, since the last new frame was shown; -1 if none was */
  uint32_t drive_ended; /* 1: the drive will produce no more frames */
  uint64_t accepted;    /* frames shown */
  uint64_t replaced;    /* good frames superseded by a newer one before the next cosplat_advance */
  uint64_t late, not_finite, out_of_range, wrong_size; /* refused */
  uint64_t softened;       /* frames shown of which some part was outside the soft range */
  uint64_t held;           /* calls of cosplat_advance without a new frame that held the last one */
  uint64_t decayed;        /* likewise, but with the face easing to rest or at rest */
  uint64_t returned;       /* how often frames arrived at a face that was at rest or easing to it */
  uint64_t drive_frames;   /* frames delivered by the drive */
  uint64_t drive_replaced; /* good, but superseded by a newer one before the next cosplat_advance */
  uint64_t drive_reordered, drive_malformed, drive_oversize, drive_flooded; /* dropped packets */
  const char* drive; /* description, "" without a drive; texts are valid until the next call */
  const char* drive_problem; /* one line about the last dropped packet, "" if there was none */
  uint64_t drive_packets;  /* that arrived, whatever was in them: 0 if nothing sends to the port */
  uint64_t drive_unusable; /* of them well-formed, but without anything that moves the face */
  /* One line: what arrived and was not used, by name and count, and whether two senders take turns;
   * "" if there is nothing to say. */
  const char* drive_notes;
  uint64_t beyond_film; /* pictures of the head from where it was not filmed: guesses */
} cosplat_health;
/* Writes the state of the face and all counts. */
COSPLAT_API cosplat_status cosplat_get_health(cosplat_avatar* avatar, cosplat_health* health);

/* --- Camera ----------------------------------------------------------------------------------- */

/* A pinhole camera. Pixel centres lie at +0.5: the top-left pixel covers [0, 1) x [0, 1). */
#define COSPLAT_LARGEST_SIDE 16384
typedef struct cosplat_camera {
  uint32_t struct_size;     /* sizeof(cosplat_camera) */
  uint32_t width, height;   /* px; at most COSPLAT_LARGEST_SIDE each and 2^26 pixels in all */
  float fx, fy;             /* px, > 0 */
  float cx, cy;             /* px from the left and top edges */
  float cam_from_world[12]; /* [R | t], 3x4, row-major; R must be a rotation to within 0.001 */
} cosplat_camera;

/* Checks and stores a camera, which stays in effect until another one is set. */
COSPLAT_API cosplat_status cosplat_set_camera(cosplat_avatar* avatar, const cosplat_camera* camera);
/* Writes the current camera; COSPLAT_ERROR_NOT_FOUND if none was set. */
COSPLAT_API cosplat_status cosplat_get_camera(cosplat_avatar* avatar, cosplat_camera* camera);

/* Writes a camera that looks at the resting head, but does not set it. The view is from the front
 * at azimuth 0 and elevation 0, from the subject's left at azimuth pi/2 and from above at positive
 * elevation; both are in radians, azimuth from -1000 to 1000 and elevation from -1.5 to 1.5. At
 * zoom 1 the head fills seven tenths of the shorter side; zoom, from 0.01 to 100, multiplies the
 * focal length. */
COSPLAT_API cosplat_status cosplat_orbit_camera(cosplat_avatar* avatar,
                                                uint32_t width,
                                                uint32_t height,
                                                float azimuth,
                                                float elevation,
                                                float zoom,
                                                cosplat_camera* camera);

/* --- Rendering -------------------------------------------------------------------------------- */

enum { COSPLAT_FORMAT_RGBA8 = 0, COSPLAT_FORMAT_BGRA8 = 1 }; /* order of the bytes */

/* Colours are sRGB, not linear, and alpha is coverage: blend the bytes without linearising them. */
enum {
  COSPLAT_ALPHA_STRAIGHT = 0,      /* colour not multiplied by alpha: PNG, GStreamer */
  COSPLAT_ALPHA_PREMULTIPLIED = 1, /* colour <= alpha: OBS, most compositors */
  COSPLAT_ALPHA_OPAQUE = 2         /* over `background`, alpha 255 */
};

/* An image to render into; its memory is owned by the caller. */
typedef struct cosplat_picture {
  uint32_t struct_size;   /* sizeof(cosplat_picture) */
  uint32_t width, height; /* px; must equal those of the camera if one is set */
  uint32_t format;        /* COSPLAT_FORMAT_... */
  uint32_t alpha;         /* COSPLAT_ALPHA_... */
  float background[3];    /* sRGB from 0 to 1; used with COSPLAT_ALPHA_OPAQUE only */
  void* pixels;           /* first byte of the top row */
  /* Bytes from one row to the row below it. 0 means 4 * width; negative for bottom-up images, whose
   * top row is the last in memory. */
  int64_t stride;
  /* Optional, otherwise NULL: depth in metres along the camera's z axis, infinity where nothing is
   * seen. The mean over the Gaussians seen in the pixel, with the weights of its colour. Roughly
   * doubles the rendering time. */
  float* depth;
  int64_t depth_stride; /* bytes, a multiple of 4; 0 means 4 * width */
} cosplat_picture;

/* Renders the avatar with its current parameters or, once cosplat_advance was called, the face as
 * of its last call. Without a camera, uses that of cosplat_orbit_camera with azimuth 0, elevation 0
 * and zoom 1 at the image's size. Writes nothing between rows, and nothing at all on failure.
 * Results that have not changed since the last call are reused; memory is allocated only when an
 * image needs more than all images before it. */
COSPLAT_API cosplat_status cosplat_render(cosplat_avatar* avatar, const cosplat_picture* picture);

#ifdef __cplusplus
}
#endif
#endif /* COSPLAT_H_ */
