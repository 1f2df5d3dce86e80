/* CoSplat's C interface: opens head avatars, poses them and draws them into the caller's memory.
 *
 * cosplat_open -> cosplat_set_parameters, cosplat_set_camera -> cosplat_render -> pixels. It is all
 * that libcosplat.so shows. C99; docs/plugin.md has the life of a frame and an example.
 *
 * Errors. Every function returns a status and none throws or ends the program, whatever it is
 * given; a function that fails changes nothing. cosplat_last_error says in words what was wrong.
 *
 * Threads. One thread at a time uses a handle: a call that finds it in use returns
 * COSPLAT_ERROR_BUSY at once. Handles are independent, so that any number of threads may each use
 * its own, whoever opened it. Pictures have the same bits whatever else is drawn meanwhile.
 *
 * Axes. The world is that of the data that the avatar was trained on: right-handed, metres; FLAME's
 * own is y up, the face towards +z, +x to the subject's left. A camera looks along +z, x to the
 * right, y down (OpenCV).
 *
 * Versions. A structure begins with its own size, which the caller sets, so that later versions can
 * add fields at its end; a field that is zero means what its absence does. */
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

/* Semantic version. While the major number is 0, a new minor number may break what was built for
 * the one before; the library's soname has both. */
#define COSPLAT_VERSION_MAJOR 0
#define COSPLAT_VERSION_MINOR 2
#define COSPLAT_VERSION_PATCH 0
#define COSPLAT_MAKE_VERSION(major, minor, patch) \
  (((uint32_t)(major) << 16) | ((uint32_t)(minor) << 8) | (uint32_t)(patch))
#define COSPLAT_VERSION \
  COSPLAT_MAKE_VERSION(COSPLAT_VERSION_MAJOR, COSPLAT_VERSION_MINOR, COSPLAT_VERSION_PATCH)

/* Of the library that runs, to compare with COSPLAT_VERSION. */
COSPLAT_API uint32_t cosplat_version(void);
COSPLAT_API const char* cosplat_version_text(void); /* "0.2.0" */

typedef int32_t cosplat_status;
enum {
  COSPLAT_OK = 0,
  COSPLAT_ERROR_ARGUMENT = 1,   /* null, a size, a choice or a number out of its range */
  COSPLAT_ERROR_HANDLE = 2,     /* not an avatar that is open */
  COSPLAT_ERROR_BUSY = 3,       /* another thread is using the handle */
  COSPLAT_ERROR_NOT_FOUND = 4,  /* no expression or joint of that name or number */
  COSPLAT_ERROR_NOT_FINITE = 5, /* a NaN or an infinity */
  COSPLAT_ERROR_LATE = 6,       /* older than the parameters that are set */
  COSPLAT_ERROR_FILE = 7,       /* cannot be read, or is not an avatar */
  COSPLAT_ERROR_FLAME = 8,      /* the FLAME model is needed, cannot be read or is another one */
  COSPLAT_ERROR_DEVICE = 9,     /* not in this library, or none answers */
  COSPLAT_ERROR_MEMORY = 10,    /* there is not enough */
  COSPLAT_ERROR_INTERNAL = 11,  /* a fault of the library's own; please report it */
  COSPLAT_ERROR_DRIVE = 12      /* cannot be opened: no such file or address, or a bad one */
};
COSPLAT_API const char* cosplat_status_text(cosplat_status status); /* "not found" */

/* An open avatar. A handle that was closed, or never opened, is refused and does no harm. */
typedef struct cosplat_avatar cosplat_avatar;

/* One line of UTF-8: what was wrong with the last call with this handle that failed, "" if none
 * did. Stays until the next call with the handle. With NULL: with the last call of this thread that
 * failed, whatever its handle; for cosplat_open, COSPLAT_ERROR_HANDLE and COSPLAT_ERROR_BUSY. */
COSPLAT_API const char* cosplat_last_error(cosplat_avatar* avatar);

/* --- Opening ---------------------------------------------------------------------------------- */

/* AUTO: the library's choice; in this version always the CPU. CUDA: an NVIDIA GPU, where the
 * library was built with it. */
enum { COSPLAT_DEVICE_AUTO = 0, COSPLAT_DEVICE_CPU = 1, COSPLAT_DEVICE_CUDA = 2 };

typedef struct cosplat_open_options {
  uint32_t struct_size; /* sizeof(cosplat_open_options) */
  uint32_t device;      /* COSPLAT_DEVICE_... */
  /* The FLAME model (.pkl or .npz) that the avatar was trained with: avatar files do not hold its
   * joints. Without it, COSPLAT_ERROR_FLAME, and the text names the model. */
  const char* flame_path;
} cosplat_open_options;

/* avatar_path: a .glb by `cosplat train-avatar`. Paths are UTF-8. *avatar is NULL on failure. A new
 * avatar is at rest: no expression, no joint but the root turned, the head where it sat in
 * training. */
COSPLAT_API cosplat_status cosplat_open(const char* avatar_path,
                                        const cosplat_open_options* options,
                                        cosplat_avatar** avatar);

/* NULL is closed already. If another thread is using the handle, its call is finished first and
 * later ones are refused. */
COSPLAT_API cosplat_status cosplat_close(cosplat_avatar* avatar);

/* --- What it is ------------------------------------------------------------------------------- */

typedef struct cosplat_info {
  uint32_t struct_size; /* sizeof(cosplat_info); the rest is written */
  uint32_t gaussian_count;
  uint32_t triangle_count; /* of the mesh that carries them */
  uint32_t expression_count;
  uint32_t joint_count;
  float box_min[3], box_max[3]; /* metres: the Gaussians' centres at rest, world */
  float background[3];          /* sRGB from 0 to 1: that of its evaluation */
} cosplat_info;

COSPLAT_API cosplat_status cosplat_get_info(cosplat_avatar* avatar, cosplat_info* info);

/* Joints by number; the names are those of the constants, in lower case and without the prefix. */
enum {
  COSPLAT_JOINT_ROOT = 0, /* turns all of the head and neck: the global pose */
  COSPLAT_JOINT_NECK = 1,
  COSPLAT_JOINT_JAW = 2,
  COSPLAT_JOINT_LEFT_EYE = 3, /* the subject's left */
  COSPLAT_JOINT_RIGHT_EYE = 4,
  COSPLAT_JOINT_COUNT = 5
};

/* FLAME's expressions have no names of their own: "expression_0", "expression_1", ... Names stay
 * until the avatar is closed. */
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

/* One moment of a face. Numbers must be finite and within COSPLAT_LARGEST_PARAMETER of zero. */
#define COSPLAT_LARGEST_PARAMETER 100
typedef struct cosplat_parameters {
  uint32_t struct_size; /* sizeof(cosplat_parameters) */
  /* Coefficients given: missing ones are zero, those that the model lacks are left out. */
  uint32_t expression_count;
  const float* expression; /* may be NULL if there are none */
  /* When it was so, by any clock of the caller's that does not run backwards. Parameters that are
   * older than those set are refused (COSPLAT_ERROR_LATE); equal times are not. */
  int64_t time_ns;
  float joints[COSPLAT_JOINT_COUNT][3]; /* axis-angle, radians */
  float translation[3];                 /* metres, after all turning */
} cosplat_parameters;

/* All of it or, on failure, nothing: what was set before stays. */
COSPLAT_API cosplat_status cosplat_set_parameters(cosplat_avatar* avatar,
                                                  const cosplat_parameters* parameters);
/* What is set. `expression` stays until the next call with the handle, to which it may be given. */
COSPLAT_API cosplat_status cosplat_get_parameters(cosplat_avatar* avatar,
                                                  cosplat_parameters* parameters);
/* Back to rest, as after cosplat_open; any time is new again. A drive stays. */
COSPLAT_API cosplat_status cosplat_reset_parameters(cosplat_avatar* avatar);

/* One at a time; numbers by cosplat_find_... */
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

/* A host that never advances draws what it sets. For one that does, cosplat_render draws the face
 * at `now_ns`, by the clock of the parameters' times: bad frames are refused, the last good one is
 * held, then the face eases to rest, and back when frames come again. Parameters that are set show
 * from the next cosplat_advance on. COSPLAT_ERROR_LATE if `now_ns` is earlier than before. */
COSPLAT_API cosplat_status cosplat_advance(cosplat_avatar* avatar, int64_t now_ns);

/* Where frames come from besides cosplat_set_...: cosplat_advance takes the newest. A recording
 * (.npz or the folder of a tracked video), "stdin:", "udp://HOST:PORT" or
 * "vmc://HOST:PORT?matrix=FILE" (docs/live-input.md). NULL: none. A recording begins at the next
 * cosplat_advance. On failure (COSPLAT_ERROR_DRIVE) the drive before stays. */
COSPLAT_API cosplat_status cosplat_set_drive(cosplat_avatar* avatar, const char* drive);

/* Soft: faces that training never saw are brought back to those that it did. */
enum { COSPLAT_RANGE_SOFT = 0, COSPLAT_RANGE_FREE = 1 };
enum { COSPLAT_SMOOTHING_NONE = 0, COSPLAT_SMOOTHING_ONE_EURO = 1 };

/* Fields that are zero mean what stands behind them; so does a policy that was never set. */
typedef struct cosplat_policy {
  uint32_t struct_size;    /* sizeof(cosplat_policy) */
  float hold_s;            /* 0.25: the last good frame stays so long */
  float decay_s;           /* 1: then the face goes to rest within this */
  float blend_in_s;        /* 0.2: and comes back within this; from 1e-6 to 1e6, as those above */
  uint32_t range;          /* COSPLAT_RANGE_... */
  uint32_t smoothing;      /* COSPLAT_SMOOTHING_...: costs a delay, docs/plugin.md */
  float min_cutoff_hz;     /* 2: of the one-euro filter at rest */
  float beta;              /* 1: Hz more per unit of speed (a coefficient, 0.1 rad, 0.02 m per s) */
  uint32_t loop;           /* 1: recordings begin again at their end; of drives set afterwards */
  float frames_per_second; /* of recordings, likewise: their own, or 25 */
} cosplat_policy;
COSPLAT_API cosplat_status cosplat_set_policy(cosplat_avatar* avatar, const cosplat_policy* policy);

enum {
  COSPLAT_FACE_REST = 0,     /* no frame came, or none for long */
  COSPLAT_FACE_LIVE = 1,     /* the last good frame, at most hold_s old */
  COSPLAT_FACE_DECAYING = 2, /* on its way to rest */
  COSPLAT_FACE_RETURNING = 3 /* and back */
};

/* Counts are since cosplat_open; the drive's since cosplat_set_drive. */
typedef struct cosplat_health {
  uint32_t struct_size; /* sizeof(cosplat_health); the rest is written */
  uint32_t face;        /* COSPLAT_FACE_... after the last cosplat_advance */
  float age_s;          /* then, since a new frame was shown; -1 if none was */
  uint32_t drive_ended; /* 1: nothing will come any more */
  uint64_t accepted;    /* frames shown */
  uint64_t replaced;    /* good, but a newer one came before the next cosplat_advance */
  uint64_t late, not_finite, out_of_range, wrong_size; /* refused */
  uint64_t softened;       /* frames shown that were partly out of the soft range */
  uint64_t held;           /* calls of cosplat_advance with no new frame, the last one held */
  uint64_t decayed;        /* likewise, the face on its way to rest or there */
  uint64_t returned;       /* how often frames came (again) to a face at rest or on its way */
  uint64_t drive_frames;   /* that the drive gave */
  uint64_t drive_replaced; /* good, but a newer one came before the next cosplat_advance */
  uint64_t drive_reordered, drive_malformed, drive_oversize, drive_flooded; /* that it dropped */
  const char* drive;         /* for people, "" if there is none; both stay until the next call */
  const char* drive_problem; /* one line about what it dropped last, "" if nothing */
} cosplat_health;
COSPLAT_API cosplat_status cosplat_get_health(cosplat_avatar* avatar, cosplat_health* health);

/* --- Camera ----------------------------------------------------------------------------------- */

/* A pinhole. Pixel centres lie at +0.5: the top-left pixel covers [0, 1) x [0, 1). */
#define COSPLAT_LARGEST_SIDE 16384
typedef struct cosplat_camera {
  uint32_t struct_size;     /* sizeof(cosplat_camera) */
  uint32_t width, height;   /* px; at most COSPLAT_LARGEST_SIDE and 2^26 in all */
  float fx, fy;             /* px, > 0 */
  float cx, cy;             /* px from the left and top edges */
  float cam_from_world[12]; /* [R | t], 3x4, row by row; R a rotation to within 0.001 */
} cosplat_camera;

COSPLAT_API cosplat_status cosplat_set_camera(cosplat_avatar* avatar, const cosplat_camera* camera);
/* The one that is set; COSPLAT_ERROR_NOT_FOUND if none is. */
COSPLAT_API cosplat_status cosplat_get_camera(cosplat_avatar* avatar, cosplat_camera* camera);

/* Writes a camera that looks at the resting head: from the front at azimuth 0 and elevation 0, from
 * the subject's left at azimuth pi/2, from above at positive elevation (radians, at most 1000 and
 * 1.5 either way). At zoom 1 the head fills seven tenths of the shorter side; zoom, from 0.01 to
 * 100, multiplies the focal length. Does not set it. */
COSPLAT_API cosplat_status cosplat_orbit_camera(cosplat_avatar* avatar,
                                                uint32_t width,
                                                uint32_t height,
                                                float azimuth,
                                                float elevation,
                                                float zoom,
                                                cosplat_camera* camera);

/* --- Picture ---------------------------------------------------------------------------------- */

enum { COSPLAT_FORMAT_RGBA8 = 0, COSPLAT_FORMAT_BGRA8 = 1 }; /* bytes in this order */

/* Colours are sRGB, not linear, and alpha is coverage: blend the bytes as they are. */
enum {
  COSPLAT_ALPHA_STRAIGHT = 0,      /* colour not multiplied by alpha: PNG, GStreamer */
  COSPLAT_ALPHA_PREMULTIPLIED = 1, /* colour <= alpha: OBS, most compositors */
  COSPLAT_ALPHA_OPAQUE = 2         /* over `background`, alpha 255 */
};

/* Memory of the caller's. */
typedef struct cosplat_picture {
  uint32_t struct_size;   /* sizeof(cosplat_picture) */
  uint32_t width, height; /* px; the camera's */
  uint32_t format;        /* COSPLAT_FORMAT_... */
  uint32_t alpha;         /* COSPLAT_ALPHA_... */
  float background[3];    /* sRGB from 0 to 1; for COSPLAT_ALPHA_OPAQUE alone */
  void* pixels;           /* first byte of the top row */
  /* Bytes from a row to the one below: 0 is 4 * width; negative for pictures that lie bottom-up,
   * whose top row is the last in memory. */
  int64_t stride;
  /* Optional: metres along the camera's z, infinity where nothing is. The mean over what is seen in
   * the pixel, weighted as its colour is. About doubles the time of drawing. */
  float* depth;
  int64_t depth_stride; /* bytes, a multiple of 4; 0 is 4 * width */
} cosplat_picture;

/* Draws the avatar as its parameters are. Without a camera set, through cosplat_orbit_camera(0, 0,
 * 1) of the picture's size. Writes nothing between the rows, and nothing at all on failure. What
 * did not change since the last call is not done again; memory is asked for only where a picture
 * needs more than any before it. */
COSPLAT_API cosplat_status cosplat_render(cosplat_avatar* avatar, const cosplat_picture* picture);

#ifdef __cplusplus
}
#endif
#endif /* COSPLAT_H_ */
