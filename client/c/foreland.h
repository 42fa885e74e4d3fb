/*
 * Foreland's client for engines and scripts: terrain that a server streams, as meshes to draw and heights to ask for.
 *
 *   ForelandTerrain* terrain;
 *   if (foreland_open("wss://terrain.example/", NULL, &terrain) != FORELAND_OK) puts(foreland_last_error());
 *   for each picture:
 *     foreland_frame(terrain, foreland_now(), &pose, &frame);
 *     while (shown < frame.version && foreland_next_update(terrain, &update) == FORELAND_OK) shown = apply(&update);
 *     draw each vertex at mix(from, to, frame.weight)
 *   foreland_close(terrain);
 *
 * Effect. A thread of the library's own holds the connection, decodes, and makes meshes. No function waits for it but
 * foreland_wait(), and foreland_close(), which ends it. A connection that is lost is made anew, and resumes from what
 * is held; events tell of it.
 *
 * Units and frames. Metres, radians, milliseconds; doubles. Points are in the scene's axes: on a map x east, y north, z
 * up; in geographic scenes the same at the scene's origin, with the earth's curvature kept. Times are those of
 * foreland_now(), scene times milliseconds since 1970.
 *
 * Errors. Functions return a ForelandStatus. foreland_last_error() then is a sentence that says what is wrong and what
 * to do; where they return anything but FORELAND_OK nothing that they point to is written. Nothing throws, prints,
 * exits, or changes the host's signal handlers or locale.
 *
 * Memory. Nothing that the library allocated is to be freed by the host, nor the other way round. What the host passes
 * is copied. What the library points to stays until the call that the function names.
 *
 * Threads. A terrain is used by one thread at a time; its functions, those that are const in meaning included, take no
 * lock that would make more safe. Different terrains, foreland_now(), foreland_last_error() (of each thread its own)
 * and the functions without a terrain are free of that. foreland_close() may be called at any time between calls.
 *
 * Versions. Every struct begins with its size: set it to sizeof, and the rest to 0, which stands for the default
 * (FORELAND_INIT does both). A library that is newer reads and writes so many bytes and no more, so a host that was
 * compiled with an older header goes on working. FORELAND_ABI changes when that does not hold, and with it the name of
 * the shared library. All members have sizes that do not depend on the compiler.
 */
#ifndef FORELAND_H
#define FORELAND_H
/* NOLINTBEGIN(readability-identifier-naming): C's names */

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define FORELAND_API __attribute__((visibility("default")))
#else
#define FORELAND_API
#endif

#define FORELAND_ABI 0
/* A struct of this type with its size, and 0 for all else. */
#ifdef __cplusplus
#define FORELAND_INIT(Type) (foreland_detail::sized<Type>())
#else
#define FORELAND_INIT(Type) ((Type){.size = sizeof(Type)})
#endif

typedef struct ForelandTerrain ForelandTerrain;

/* What a function returns. */
typedef int32_t ForelandStatus;
enum {
  FORELAND_OK = 0,
  FORELAND_NOTHING = 1,     /* there is nothing now: no event, no update, no ground that is known; not an error */
  FORELAND_ARGUMENT = 2,    /* what was asked for makes no sense */
  FORELAND_NO_SCENE = 3,    /* no session has begun yet: wait for FORELAND_EVENT_SCENE */
  FORELAND_FAILED = 4,      /* the client has failed, as for want of memory: close the terrain, and open it again */
  FORELAND_UNSUPPORTED = 5, /* this processor, or this version of the library, cannot do that */
};

/* Where a default other than "no" is to be kept apart from "no". */
enum { FORELAND_DEFAULT = 0, FORELAND_ON = 1, FORELAND_OFF = 2 };

enum { FORELAND_PREDICT = 1, FORELAND_CURRENT = 2, FORELAND_DELAY = 3 };
enum {
  FORELAND_VELOCITY = 1,
  FORELAND_ACCELERATION = 2,
  FORELAND_HOLD = 3,
  FORELAND_PATH = 4,
  FORELAND_DOUBLE_EXPONENTIAL = 5,
  FORELAND_KALMAN = 6
};
enum { FORELAND_KEYFRAME = 1, FORELAND_GEOMORPH = 2, FORELAND_B_SPLINE_2 = 3, FORELAND_B_SPLINE_3 = 4 };

/* How a terrain is opened, and what of it is changed in flight (foreland_set_options). 0: the default, or as it is. */
typedef struct ForelandOptions {
  uint32_t size;
  uint32_t strategy;   /* FORELAND_PREDICT (default) draws for where the camera will be, ... */
  uint32_t predictor;  /* how the server foresees the camera; default FORELAND_VELOCITY, FORELAND_PATH once one is
                          announced */
  uint32_t blend;      /* how the mesh goes from keyframe to keyframe; default FORELAND_KEYFRAME */
  double tolerance_px; /* largest error on the screen, pixels; default 1 */
  double keyframe_ms;  /* between keyframes; default 200 */
  double longest_keyframe_ms; /* above keyframe_ms: the server chooses between the two */
  uint32_t occlusion;         /* leave out what ridges hide; default FORELAND_ON */
  uint32_t relief;            /* tiles of relief, by which heights near the camera are finer; default FORELAND_OFF */
  /* What follows counts when a terrain is opened. */
  uint32_t meshes;               /* FORELAND_OFF: for heights alone, with half of the work. Default FORELAND_ON */
  uint32_t memory_bytes;         /* for terrain that was flown over; default 16 MiB */
  uint32_t tile_bytes;           /* for coded tiles; default 64 MiB */
  uint32_t max_triangles;        /* of a mesh; where it would have more the tolerance is raised. Default: no limit */
  uint32_t max_bytes_per_second; /* that may come; likewise */
  uint32_t reserved;
  const char* token;   /* for a server that asks for one (`foreland token`) */
  const char* ca_file; /* certificates of authorities to trust, PEM; default: the system's */
} ForelandOptions;

/* What the camera sees: the vertical angle, 0.017 to 2.97 radians, and the picture, 1 to 16384 pixels a side. */
typedef struct ForelandLens {
  uint32_t size;
  uint32_t width_px, height_px;
  uint32_t reserved;
  double fov_y;
} ForelandLens;

/* A camera at `eye` that looks along its -z with y up; the rotation from its axes to the scene's, x, y, z, w, of
 * length 1. */
typedef struct ForelandPose {
  double eye[3];
  double orientation[4];
} ForelandPose;

/* A place on the earth, longitude and latitude in degrees; or on the map of a scene whose data are projected, easting
 * and northing in metres. `height` is above the data's zero surface. */
typedef struct ForelandMapPoint {
  double x, y, height;
} ForelandMapPoint;

/* What the scene is. What it points to stays until foreland_next_event or foreland_frame is called again. */
typedef struct ForelandScene {
  uint32_t size;
  uint32_t is_geographic;
  uint64_t id; /* another build has another one */
  const char* title;
  const char* crs;
  double low[3], high[3]; /* box about the data, in the scene's axes */
  double lowest, highest; /* ground, above the zero surface */
  uint32_t samples[2];    /* of the data, eastward and northward */
  double to_ecef[16];     /* geographic scenes: from the scene's axes to the earth's, by columns; else 0 */
  const double* epochs;   /* of a scene that changes in time */
  uint32_t epoch_count;
  uint32_t landmark_count;
  const double* landmarks; /* points of the ground that are known at once: x, y, z each */
  double max_moved;        /* by which ground moves at most from the first epoch to another */
  uint32_t has_relief, has_imagery;
  const char* relief_attribution; /* to be shown where the tiles are; "" if none is due */
  const char* imagery_attribution;
  uint32_t zero_surface; /* what heights count from: FORELAND_UNSTATED, ... */
  uint32_t reserved;
  const char* datum;       /* its name; "" if nobody says */
  const char* geoid;       /* whose undulations are known, for heights by the other surface; "": none's */
  double undulation_error; /* by which ForelandPlace may be off where it tells them; answers are exact */
} ForelandScene;
enum { FORELAND_UNSTATED = 0, FORELAND_ABOVE_ELLIPSOID = 1, FORELAND_ABOVE_SEA = 2 };

/* What to draw at an instant. */
typedef struct ForelandFrame {
  uint32_t size;
  uint32_t version;      /* of the mesh; 0: there is none yet */
  double weight;         /* where between its two ends the mesh is drawn, 0 to 1 */
  ForelandPose pose;     /* to draw from: as given, but for the strategy FORELAND_DELAY */
  double guaranteed_px;  /* what the error on the screen does not exceed; infinite: nothing is guaranteed */
  double shown_time;     /* whose view is shown */
  double end_time;       /* when the next mesh begins, unless it is late */
  double scene_time;     /* whose ground is shown, in scenes that change in time */
  uint32_t next_version; /* of the mesh to make ready; 0: none */
  uint32_t reserved;
} ForelandFrame;

/* What changes in an array of the mesh. Elements are of the type that its member says. */
typedef struct ForelandChannel {
  const void* data;       /* elements that change: those of the first range, then those of the second, ... */
  const uint32_t* ranges; /* pairs: the first element, and one past the last; ascending */
  uint32_t range_count;
  uint32_t count; /* elements of the whole array from now on, what is not told of staying as it was; 0: there is no such
                     array */
} ForelandChannel;

/* The mesh of the terrain, or that of all objects: vertices with two positions each, of which a frame draws
 *   mix(from, to, weight), and where there are bends  + weight (1 - weight) mix(from_bend, to_bend, weight). */
typedef struct ForelandPart {
  uint32_t is_whole;       /* it needs nothing of the version before */
  uint32_t triangle_count; /* to be drawn */
  ForelandChannel from_positions,
      to_positions; /* 4 floats: x, y, z from the origin; height above the zero surface (objects: 0) */
  ForelandChannel from_normals, to_normals; /* 4 int8: x, y, z of 127, and 0 */
  ForelandChannel from_moved, to_moved;     /* 1 float: upwards since the first epoch; where ground moves */
  ForelandChannel from_bends, to_bends;     /* 3 floats; with splines */
  ForelandChannel parameters;               /* 2 floats: position on the lattice; of objects, in the model's image */
  ForelandChannel triangles;                /* 3 uint32: vertices, counter-clockwise seen from above or outside */
} ForelandPart;

/* An object's triangles: so many indices of its part, from one on. */
typedef struct ForelandObjectPart {
  uint32_t first_index, index_count, model;
} ForelandObjectPart;

/* What changes in the mesh from one version to the next. What it points to stays until foreland_next_update is called
 * again. */
typedef struct ForelandUpdate {
  uint32_t size;
  uint32_t version;        /* follows that of the update before it */
  uint32_t oldest_version; /* that may still be shown */
  uint32_t object_part_count;
  const ForelandObjectPart* object_parts;
  double origin[3];     /* in the scene's axes; positions are relative to it */
  double to_time;       /* of the newer keyframe, */
  ForelandPose to_pose; /* and the pose that it was computed for */
  ForelandPart terrain, objects;
} ForelandUpdate;

/* A place of the scene in the coordinates of the data's owner. */
typedef struct ForelandPlace {
  uint32_t size;
  uint32_t reserved;
  ForelandMapPoint at;
  double ground;     /* height of the ground there, of what is held; NaN where it is not known */
  double slope;      /* of the ground, radians; NaN where it is not known */
  double up[3];      /* away from the zero surface, in the scene's axes */
  double lattice[2]; /* position on the lattice of the data's samples */
  double undulation; /* of the geoid above the ellipsoid: what a height above the sea lacks to one above the ellipsoid;
                        NaN where it is not known */
} ForelandPlace;

/* How lines of sight are asked for. */
typedef struct ForelandSightOptions {
  uint32_t size;
  uint32_t above_ground;   /* 1: heights of the places are above the ground; 0: above the zero surface */
  uint32_t has_refraction; /* 1: `refraction` counts; 0: it is 1/7, as in usual air */
  uint32_t has_scene_time; /* 1: `scene_time` counts; 0: it is the last epoch's */
  double refraction;       /* by which share of the earth's curvature light bends, 0 to 1 */
  double scene_time;
} ForelandSightOptions;

/* A line of sight, in the scene's axes. */
typedef struct ForelandSight {
  double from[3], to[3];
  double hit[3]; /* the first point that hides; NaN: none does */
  int32_t what;  /* number of the object that hides, or one of these */
  int32_t reserved;
} ForelandSight;
enum { FORELAND_HIDDEN_BY_GROUND = -1, FORELAND_SEEN = -2, FORELAND_UNKNOWN = -3 /* an end lies beyond the data */ };

/* What a viewshed is asked with. */
typedef struct ForelandViewshedQuestion {
  uint32_t size;
  uint32_t has_refraction, has_scene_time; /* as of ForelandSightOptions */
  uint32_t reserved;
  ForelandMapPoint from; /* of the eye; `height` above the ground, 0 for 1.7 */
  double target;         /* how high above the ground what is looked at is */
  double radius, cell;   /* width of a cell; at most 4,194,304 cells */
  double refraction, scene_time;
} ForelandViewshedQuestion;

/* Some cells of a viewshed. The middle of cell (i, j) is at first + (i, j) step on the lattice; row by row from the
 * south. */
typedef struct ForelandViewshed {
  double first[2], step[2];
  uint32_t columns, rows;
  uint32_t begin, count; /* the cells that are told: from this one on, so many */
  const uint8_t* cells;  /* 0 hidden, 1 seen, 2 beyond the radius or the data */
} ForelandViewshed;

/* What has happened. */
enum {
  FORELAND_EVENT_SCENE = 1, /* a session has begun: at first, and on every later connection */
  FORELAND_EVENT_GUARANTEE =
      2, /* what the error is guaranteed not to exceed has changed: `value`, pixels; infinite: nothing is */
  FORELAND_EVENT_STALL =
      3, /* there is no connection; it is tried again in `value` ms. `message` says why, or is empty */
  FORELAND_EVENT_MIGRATE = 4, /* the server hands its viewers over: the connection is made anew at once */
  FORELAND_EVENT_REFUSED =
      5, /* the server has ended the session; foreland_reconnect() tries again. `message` is what it says */
  FORELAND_EVENT_FAILED =
      6, /* the client has failed, and nothing comes any more: close the terrain, and open it again */
  FORELAND_EVENT_WARNING = 7,    /* something is amiss that ends nothing, such as a damaged tile */
  FORELAND_EVENT_HEIGHTS = 8,    /* the answer to `question`: `heights`, `count` of them */
  FORELAND_EVENT_SIGHTS = 9,     /* the answer to `question`: `sights`, `count` of them */
  FORELAND_EVENT_VIEWSHED = 10,  /* a part of the answer to `question`, the last one if `value` is 1 */
  FORELAND_EVENT_UNANSWERED = 11 /* there is no answer to `question`, and `message` says why */
};

/* An event; the members that its kind does not name are 0. What it points to stays until foreland_next_event is called
 * again. */
typedef struct ForelandEvent {
  uint32_t size;
  uint32_t kind;
  uint64_t question;
  double value;
  const char* message;   /* sentences, or "" */
  const double* heights; /* above the zero surface; NaN beyond the data */
  const ForelandSight* sights;
  const ForelandViewshed* viewshed;
  uint32_t count;
  uint32_t reserved;
  const double* undulations; /* with `heights`, as many, as of ForelandPlace; NULL where no geoid is known */
} ForelandEvent;

/* Counts of what has come and gone. */
typedef struct ForelandStats {
  uint32_t size;
  uint32_t is_connected; /* there is a connection with a session now */
  uint64_t bytes_down, bytes_up;
  uint64_t nodes_added, nodes_removed;
  uint32_t keyframes, late_keyframes;
  double last_lateness, worst_lateness; /* of keyframes; negative is early */
  uint64_t tiles_received, tile_bytes;  /* bytes of the tiles held */
} ForelandStats;

/* ---- the library ---- */

/* FORELAND_ABI of the library, which is to be that of this header; and its release, such as "0.2.0". */
FORELAND_API uint32_t foreland_abi(void);
FORELAND_API const char* foreland_version(void);

/* The time, milliseconds of a clock that goes on evenly, from the first call in the process on. */
FORELAND_API double foreland_now(void);

/* Why the last call in this thread that did not return FORELAND_OK did not: sentences, which stay until the next such
 * call. */
FORELAND_API const char* foreland_last_error(void);

/* ---- a terrain ---- */

/* Begins a session with a server, ws://HOST[:PORT][/PATH] or wss://; a path that ends in / is that of a page. Returns
 * at once: events tell what comes of it. `options` may be NULL. FORELAND_ARGUMENT: that is no address, or an option is
 * out of range. */
FORELAND_API ForelandStatus foreland_open(const char* server, const ForelandOptions* options, ForelandTerrain** out);

/* Ends the session and its thread, at any time; the terrain is gone. NULL is let pass. Takes some milliseconds, but as
 * long as the system does while it looks up a host's name. */
FORELAND_API void foreland_close(ForelandTerrain* terrain);

/* The next thing that has happened, oldest first. FORELAND_NOTHING: nothing has. */
FORELAND_API ForelandStatus foreland_next_event(ForelandTerrain* terrain, ForelandEvent* out);

/* Waits until there is an event or an update that has not been taken, at most so long. FORELAND_NOTHING: there is none.
 * For scripts. */
FORELAND_API ForelandStatus foreland_wait(ForelandTerrain* terrain, double milliseconds);

/* The scene. FORELAND_NO_SCENE before FORELAND_EVENT_SCENE. */
FORELAND_API ForelandStatus foreland_get_scene(ForelandTerrain* terrain, ForelandScene* out);
FORELAND_API ForelandStatus foreland_get_stats(ForelandTerrain* terrain, ForelandStats* out);

/* ---- what is wanted ---- */

/* Default 55 degrees, 1280 x 720. Call it after resizing, not for each step of it. */
FORELAND_API ForelandStatus foreland_set_lens(ForelandTerrain* terrain, const ForelandLens* lens);
/* Changes what is not 0, and leaves the rest. */
FORELAND_API ForelandStatus foreland_set_options(ForelandTerrain* terrain, const ForelandOptions* options);
/* From now on shows the ground of scene time `at`, which goes at `rate` scene seconds a second. */
FORELAND_API ForelandStatus foreland_set_scene_time(ForelandTerrain* terrain, double at, double rate);
/* For the next connection: a token that replaces one that expires; NULL: none. */
FORELAND_API ForelandStatus foreland_set_token(ForelandTerrain* terrain, const char* token);
/* Connects anew at once: after FORELAND_EVENT_REFUSED, or where waiting is too long. What is held is resumed from. */
FORELAND_API ForelandStatus foreland_reconnect(ForelandTerrain* terrain);
/* Whether anybody sees what is drawn (1, or 0). A terrain that nobody sees does not connect anew until it is seen. */
FORELAND_API ForelandStatus foreland_set_seen(ForelandTerrain* terrain, int32_t is_seen);

/* ---- a frame ---- */

/* What to draw at `now` with the camera at `pose`. Once for each picture, also while nothing is there yet: it is what
 * tells the server where the camera is. Times do not decrease. Takes some microseconds. */
FORELAND_API ForelandStatus foreland_frame(ForelandTerrain* terrain, double now, const ForelandPose* pose,
                                           ForelandFrame* out);
/* What changes in the mesh with the next version. FORELAND_NOTHING: no other one is there. To draw a frame, take
 * updates until its version. While eight have not been taken no more are made; the next one then holds all changes
 * since. */
FORELAND_API ForelandStatus foreland_next_update(ForelandTerrain* terrain, ForelandUpdate* out);
/* For a host that makes meshes ready ahead, in two sets of buffers: from now on a frame shows no version beyond
 * `ready`, and does not pass over `coming`, which is being made ready (0: none). Before the first call all that has
 * come is ready. */
FORELAND_API ForelandStatus foreland_set_ready(ForelandTerrain* terrain, uint32_t ready, uint32_t coming);
/* What was taken is lost: the newest mesh comes again, whole. No version is shown until it does. */
FORELAND_API ForelandStatus foreland_redraw(ForelandTerrain* terrain);
/* The camera of the next frame will not have moved there, but jumped. */
FORELAND_API ForelandStatus foreland_jump(ForelandTerrain* terrain);
/* Announces that the camera takes these poses, 2 to 100,000, in even steps of 1 to 60,000 ms from `start` on; the
 * server then knows and need not foresee. No pose ends that. */
FORELAND_API ForelandStatus foreland_announce_path(ForelandTerrain* terrain, const ForelandPose* poses, uint32_t count,
                                                   double start, double step);

/* ---- where things are; FORELAND_NO_SCENE before there is one ---- */

FORELAND_API ForelandStatus foreland_to_geodetic(ForelandTerrain* terrain, const double point[3], ForelandPlace* out);
FORELAND_API ForelandStatus foreland_to_scene(ForelandTerrain* terrain, const ForelandMapPoint* place, double out[3]);
/* Height of the ground that is held, above the zero surface, at once. FORELAND_NOTHING where none is known, as far from
 * the camera. */
FORELAND_API ForelandStatus foreland_height_now(ForelandTerrain* terrain, const ForelandMapPoint* place, double* out);
/* Where an eye comes to that moves from one point towards another, so far above the ground that is held. */
FORELAND_API ForelandStatus foreland_sweep(ForelandTerrain* terrain, const double from[3], const double to[3],
                                           double clearance, double out[3]);
/* Where a ray meets the ground that is held, `far` metres away at most. FORELAND_NOTHING: it does not. */
FORELAND_API ForelandStatus foreland_raycast(ForelandTerrain* terrain, const double origin[3],
                                             const double direction[3], double far, double out[3]);

/* ---- questions to the server; events bring the answers, by the number that is written to `question` ---- */

/* Exact heights of the ground, at full resolution, of at most 65,536 places. Asked again after a lost connection. */
FORELAND_API ForelandStatus foreland_heights(ForelandTerrain* terrain, const ForelandMapPoint* places, uint32_t count,
                                             uint64_t* question);
/* Whether the second place of each pair is seen from the first, over the ground and every object: at most 4,096 pairs.
 * `options` may be NULL. Unanswered where the connection is lost. */
FORELAND_API ForelandStatus foreland_visible(ForelandTerrain* terrain, const ForelandMapPoint* pairs,
                                             uint32_t pair_count, const ForelandSightOptions* options,
                                             uint64_t* question);
/* What of the ground is seen from a place, cell by cell. One at a time: another one ends the one before, unanswered. */
FORELAND_API ForelandStatus foreland_viewshed(ForelandTerrain* terrain, const ForelandViewshedQuestion* asked,
                                              uint64_t* question);
/* The answer is not wanted any more; no event tells of it. */
FORELAND_API ForelandStatus foreland_cancel(ForelandTerrain* terrain, uint64_t question);

#ifdef __cplusplus
}
namespace foreland_detail {
template <class T>
inline T sized() {
  T value = T();
  value.size = sizeof(T);
  return value;
}
}  // namespace foreland_detail
#endif

/* NOLINTEND(readability-identifier-naming) */
#endif
