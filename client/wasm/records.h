// What the page reads from the module's memory, and a request, which it writes there: plain records, little-endian.
// Pointers are offsets into the module's memory. record_layout.h lists the fields, and the page's readers and writers
// are generated from that list.
#pragma once

#include <cstdint>
#include <type_traits>

namespace foreland::client {

using Address = uint32_t;

// proto::ViewRequest.
struct RequestRecord {
  double fov_rad;  // vertical
  double tau_px;
  double keyframe_ms;
  double longest_keyframe_ms;
  double eye_radius_m;
  uint32_t width_px;
  uint32_t height_px;
  uint32_t strategy;   // proto::Strategy
  uint32_t predictor;  // proto::Predictor
  uint32_t occlusion;
  uint32_t memory_bytes;
  uint32_t relief;
  uint32_t imagery;
  uint32_t tile_bytes;
  uint32_t max_triangles;
  uint32_t max_bytes_per_second;
  uint32_t unused;  // keeps the size a multiple of 8
};

struct PoseRecord {
  double eye[3];          // scene frame, metres
  double orientation[4];  // x, y, z, w
};

// What to draw: FrameView and its KeyframeMesh. The arrays are valid until the next call into the module.
struct FrameRecord {
  PoseRecord pose;
  double origin[3];      // scene frame, metres; positions are relative to it
  double shown_time_ms;  // the client's clock
  double from_time_ms;
  double to_time_ms;
  double scene_time_ms;  // whose ground is shown, since 1970, in scenes with epochs
  PoseRecord to_pose;    // the pose that the newer section was computed for
  float weight;
  uint32_t mesh_version;  // 0: no mesh yet
  uint32_t vertex_count;
  uint32_t index_count;
  Address from_positions;  // float x, y, z, height
  Address to_positions;
  Address from_normals;  // int8 x, y, z, 0
  Address to_normals;
  Address indices;            // uint32
  float to_region_radius_m;   // of the newer keyframe: its section keeps the tolerance for eyes this near to its pose,
  float to_region_angle_rad;  // turned by no more than this
  uint32_t to_nodes;
  float tau_px;  // tolerance of the newer keyframe
  // The same arrays of the objects, whose positions have no height.
  uint32_t object_vertex_count;
  uint32_t object_index_count;
  Address object_from_positions;
  Address object_to_positions;
  Address object_from_normals;
  Address object_to_normals;
  Address object_texture_coordinates;  // float u, v in the model's image, from its upper left corner
  Address object_indices;
  Address object_parts;  // uint32 first index, number of indices, model
  uint32_t object_part_count;
  uint32_t oldest_version;    // of meshes that may still be shown
  Address lattice_positions;  // float x, y of the terrain's vertices
  Address from_moved;         // float, metres upwards since the first epoch; 0: the ground does not move
  Address to_moved;
  Address from_bends;  // float x, y, z of the terrain's vertices; 0: they move straight
  Address to_bends;
  uint32_t unused;  // keeps the size a multiple of 8
};

// What the drawing thread draws in a frame (screen.cpp).
struct ScreenRecord {
  PoseRecord pose;
  double shown_time_ms;  // the client's clock
  double scene_time_ms;
  double to_time_ms;   // of the newer keyframe that is shown
  PoseRecord to_pose;  // that it was computed for
  double end_ms;       // when the next mesh begins, unless it is late
  float weight;
  uint32_t mesh_version;  // 0: no mesh yet
  float tau_px;
  uint32_t next_version;  // of the mesh to make ready; 0: none
};

// What has changed in the arrays of the terrain's or the objects' mesh. Ranges are pairs of uint32: the first element,
// and one past the last.
struct ChangesRecord {
  uint32_t base_version;  // what an array of this mesh_version lacks; 0: all of it
  Address from_positions;
  uint32_t from_position_ranges;
  Address to_positions;
  uint32_t to_position_ranges;
  Address from_normals;
  uint32_t from_normal_ranges;
  Address to_normals;
  uint32_t to_normal_ranges;
  Address texture_coordinates;  // of objects
  uint32_t texture_coordinate_ranges;
  Address triangles;
  uint32_t triangle_ranges;
  Address bends;  // both, of the terrain
  uint32_t bend_ranges;
};

struct WelcomeRecord {
  double low[3];  // box around the data, scene frame, metres
  double high[3];
  double lowest_m;  // heights above the zero surface
  double highest_m;
  double tau_px;
  double keyframe_ms;
  double max_moved_m;         // by which the ground moves at most from the first epoch to another
  double undulation_error_m;  // by which heights above the other surface may be off (MapPositionRecord)
  Address title;              // UTF-8
  uint32_t title_size;
  Address crs;
  uint32_t crs_size;
  uint32_t frame_kind;  // proto::FrameKind
  uint32_t samples_x;
  uint32_t samples_y;
  uint32_t landmark_count;  // base vertices inside the data
  Address landmarks;        // double x, y, z, in the scene frame
  uint32_t epoch_count;     // of a scene that changes in time
  Address epochs;           // double milliseconds since 1970, ascending
  uint32_t model_count;     // of objects
  Address model_sides;      // uint32: texels a base edge of each model's image; 0: it has none
  uint32_t scene_id[2];     // the lower half first
  uint32_t zero_surface;    // proto::ZeroSurface
  Address datum;            // its name, UTF-8
  uint32_t datum_size;
  Address geoid;  // whose undulations are known, UTF-8; of no size if none are
  uint32_t geoid_size;
};

// Where a point of the scene is, in the coordinates of the data's owner.
struct MapPositionRecord {
  double height_m;   // above the zero surface
  double ground_m;   // height of the ground below, above the zero surface; NaN: unknown, or beyond the data
  double up[3];      // away from the zero surface
  double across[2];  // geographic: latitude and longitude, degrees; planar: northing and easting of the map, metres
  double lattice[2];
  double slope_rad;     // of the ground below; NaN: unknown
  double undulation_m;  // of the geoid above the ellipsoid; NaN: unknown
};

// What of the tiles of a content is drawn with the newest mesh.
struct TilesRecord {
  uint32_t scene;       // counts the scenes that were entered: another one has other tiles
  uint32_t shown;       // tiles
  Address page_table;   // uint16, as Residency::pageTable
  uint32_t page_count;  // four numbers each
  // uint32, five for each tile to be uploaded before the mesh is shown: its key in two halves, the lower one first; its
  // texture layer; its parent's, or kNoLayer; and whether only its shadows have changed.
  Address arrivals;
  uint32_t arrival_count;
  Address dropped;  // uint32, two for each tile whose content is of no use any more: its key
  uint32_t dropped_count;
};
inline constexpr uint32_t kNoLayer = 0xffffffff;

// An image to decode.
struct ImageRecord {
  uint32_t key[2];
  Address coded;
  uint32_t size;
};

// How a layer of tiles lies on the lattice.
struct LayerRecord {
  double origin[2];  // lattice position of the corner of the first texel
  double texel;      // sample intervals
  uint32_t size[2];  // texels of the finest level
  uint32_t levels;
  Address attribution;  // UTF-8
  uint32_t attribution_size;
  uint32_t unused;  // keeps the size a multiple of 8
  double low_m;     // relief: the height of code 0 of its ground texels (client/imagery/shadows.h)
  double code_m;    // and from code to code
};

// What makes a normal, in the scene's axes, of slopes along the lattice's axes.
struct SlopeFrameRecord {
  // Planar: what a rise of a metre a sample interval along x, and along y, adds to the gradient.
  double gradient_x[2];
  double gradient_y[2];
  // Geographic, radians and metres: of lattice (0, 0), longitudes from the scene origin's meridian. Globe: the
  // ellipsoid alone.
  double latitude;
  double longitude;
  double latitude_step;  // per sample interval
  double longitude_step;
  double origin_latitude;
  double semi_major_m;
  double eccentricity_squared;
  uint32_t frame_kind;  // proto::FrameKind
  uint32_t unused;      // keeps the size a multiple of 8
};

struct StatisticsRecord {
  double bytes_down;
  double bytes_up;
  double last_lateness_ms;  // negative is early
  double worst_lateness_ms;
  double nodes_added;
  double nodes_removed;
  double tile_bytes;  // of the tiles held
  double tiles_received;
  double relief_texel_px;  // of the mesh taken last, Drape::texelPx()
  double imagery_texel_px;
  uint32_t keyframes;
  uint32_t late_keyframes;
  uint32_t tiles;          // held
  uint32_t damaged_tiles;  // of relief, in this scene; images are decoded by the page
};

// The server's reply to foreland_request_ground.
struct GroundRecord {
  uint32_t id;
  uint32_t count;
  Address heights_m;      // float; NaN beyond the data
  Address undulations_m;  // likewise, as many; 0 if none are known
};

struct TextRecord {
  Address text;  // UTF-8
  uint32_t size;
};

static_assert(std::is_trivially_copyable_v<FrameRecord> && std::is_trivially_copyable_v<WelcomeRecord>);

}  // namespace foreland::client
