// The layout of the records in records.h as text, so that the page's readers are generated
// (client/js/make_records.mjs) instead of copied by hand. A record that is changed without its table below does not
// compile.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <type_traits>

#include "client/wasm/records.h"

namespace foreland::client {

struct RecordField {
  const char* name;
  const char* type;  // f64, f32, u32, or the name of a record
  size_t offset, size, count;
};

struct RecordLayout {
  const char* name;
  size_t size;
  std::span<const RecordField> fields;

  // Whether the fields follow one another and fill the record.
  constexpr bool isComplete() const {
    size_t end = 0;
    for (const RecordField& field : fields) {
      if (field.offset != end) return false;
      end += field.size;
    }
    return end == size;
  }
};

template <class T>
constexpr const char* recordTypeName() {
  if constexpr (std::is_same_v<T, double>) return "f64";
  if constexpr (std::is_same_v<T, float>) return "f32";
  if constexpr (std::is_same_v<T, uint32_t>) return "u32";
  if constexpr (std::is_same_v<T, PoseRecord>) return "PoseRecord";
}

#define FORELAND_FIELD(Record, field)                                                                         \
  RecordField {                                                                                               \
#field, recordTypeName < std::remove_extent_t < decltype(Record::field)>>(), offsetof(Record, field),     \
        sizeof(Record::field), sizeof(Record::field) / sizeof(std::remove_extent_t <decltype(Record::field)>) \
  }

inline constexpr RecordField kRequestFields[] = {
    FORELAND_FIELD(RequestRecord, fov_rad),       FORELAND_FIELD(RequestRecord, tau_px),
    FORELAND_FIELD(RequestRecord, keyframe_ms),   FORELAND_FIELD(RequestRecord, longest_keyframe_ms),
    FORELAND_FIELD(RequestRecord, eye_radius_m),  FORELAND_FIELD(RequestRecord, width_px),
    FORELAND_FIELD(RequestRecord, height_px),     FORELAND_FIELD(RequestRecord, strategy),
    FORELAND_FIELD(RequestRecord, predictor),     FORELAND_FIELD(RequestRecord, occlusion),
    FORELAND_FIELD(RequestRecord, memory_bytes),  FORELAND_FIELD(RequestRecord, relief),
    FORELAND_FIELD(RequestRecord, imagery),       FORELAND_FIELD(RequestRecord, tile_bytes),
    FORELAND_FIELD(RequestRecord, max_triangles), FORELAND_FIELD(RequestRecord, max_bytes_per_second),
    FORELAND_FIELD(RequestRecord, unused),
};
inline constexpr RecordField kPoseFields[] = {FORELAND_FIELD(PoseRecord, eye), FORELAND_FIELD(PoseRecord, orientation)};
inline constexpr RecordField kFrameFields[] = {
    FORELAND_FIELD(FrameRecord, pose),
    FORELAND_FIELD(FrameRecord, origin),
    FORELAND_FIELD(FrameRecord, shown_time_ms),
    FORELAND_FIELD(FrameRecord, from_time_ms),
    FORELAND_FIELD(FrameRecord, to_time_ms),
    FORELAND_FIELD(FrameRecord, scene_time_ms),
    FORELAND_FIELD(FrameRecord, to_pose),
    FORELAND_FIELD(FrameRecord, weight),
    FORELAND_FIELD(FrameRecord, mesh_version),
    FORELAND_FIELD(FrameRecord, vertex_count),
    FORELAND_FIELD(FrameRecord, index_count),
    FORELAND_FIELD(FrameRecord, from_positions),
    FORELAND_FIELD(FrameRecord, to_positions),
    FORELAND_FIELD(FrameRecord, from_normals),
    FORELAND_FIELD(FrameRecord, to_normals),
    FORELAND_FIELD(FrameRecord, indices),
    FORELAND_FIELD(FrameRecord, to_region_radius_m),
    FORELAND_FIELD(FrameRecord, to_region_angle_rad),
    FORELAND_FIELD(FrameRecord, to_nodes),
    FORELAND_FIELD(FrameRecord, tau_px),
    FORELAND_FIELD(FrameRecord, object_vertex_count),
    FORELAND_FIELD(FrameRecord, object_index_count),
    FORELAND_FIELD(FrameRecord, object_from_positions),
    FORELAND_FIELD(FrameRecord, object_to_positions),
    FORELAND_FIELD(FrameRecord, object_from_normals),
    FORELAND_FIELD(FrameRecord, object_to_normals),
    FORELAND_FIELD(FrameRecord, object_texture_coordinates),
    FORELAND_FIELD(FrameRecord, object_indices),
    FORELAND_FIELD(FrameRecord, object_parts),
    FORELAND_FIELD(FrameRecord, object_part_count),
    FORELAND_FIELD(FrameRecord, oldest_version),
    FORELAND_FIELD(FrameRecord, lattice_positions),
    FORELAND_FIELD(FrameRecord, from_moved),
    FORELAND_FIELD(FrameRecord, to_moved),
    FORELAND_FIELD(FrameRecord, from_bends),
    FORELAND_FIELD(FrameRecord, to_bends),
    FORELAND_FIELD(FrameRecord, unused),
};
inline constexpr RecordField kScreenFields[] = {
    FORELAND_FIELD(ScreenRecord, pose),          FORELAND_FIELD(ScreenRecord, shown_time_ms),
    FORELAND_FIELD(ScreenRecord, scene_time_ms), FORELAND_FIELD(ScreenRecord, to_time_ms),
    FORELAND_FIELD(ScreenRecord, to_pose),       FORELAND_FIELD(ScreenRecord, end_ms),
    FORELAND_FIELD(ScreenRecord, weight),        FORELAND_FIELD(ScreenRecord, mesh_version),
    FORELAND_FIELD(ScreenRecord, tau_px),        FORELAND_FIELD(ScreenRecord, next_version),
};
inline constexpr RecordField kChangesFields[] = {
    FORELAND_FIELD(ChangesRecord, base_version),
    FORELAND_FIELD(ChangesRecord, from_positions),
    FORELAND_FIELD(ChangesRecord, from_position_ranges),
    FORELAND_FIELD(ChangesRecord, to_positions),
    FORELAND_FIELD(ChangesRecord, to_position_ranges),
    FORELAND_FIELD(ChangesRecord, from_normals),
    FORELAND_FIELD(ChangesRecord, from_normal_ranges),
    FORELAND_FIELD(ChangesRecord, to_normals),
    FORELAND_FIELD(ChangesRecord, to_normal_ranges),
    FORELAND_FIELD(ChangesRecord, texture_coordinates),
    FORELAND_FIELD(ChangesRecord, texture_coordinate_ranges),
    FORELAND_FIELD(ChangesRecord, triangles),
    FORELAND_FIELD(ChangesRecord, triangle_ranges),
    FORELAND_FIELD(ChangesRecord, bends),
    FORELAND_FIELD(ChangesRecord, bend_ranges),
};
inline constexpr RecordField kWelcomeFields[] = {
    FORELAND_FIELD(WelcomeRecord, low),          FORELAND_FIELD(WelcomeRecord, high),
    FORELAND_FIELD(WelcomeRecord, lowest_m),     FORELAND_FIELD(WelcomeRecord, highest_m),
    FORELAND_FIELD(WelcomeRecord, tau_px),       FORELAND_FIELD(WelcomeRecord, keyframe_ms),
    FORELAND_FIELD(WelcomeRecord, max_moved_m),  FORELAND_FIELD(WelcomeRecord, undulation_error_m),
    FORELAND_FIELD(WelcomeRecord, title),        FORELAND_FIELD(WelcomeRecord, title_size),
    FORELAND_FIELD(WelcomeRecord, crs),          FORELAND_FIELD(WelcomeRecord, crs_size),
    FORELAND_FIELD(WelcomeRecord, frame_kind),   FORELAND_FIELD(WelcomeRecord, samples_x),
    FORELAND_FIELD(WelcomeRecord, samples_y),    FORELAND_FIELD(WelcomeRecord, landmark_count),
    FORELAND_FIELD(WelcomeRecord, landmarks),    FORELAND_FIELD(WelcomeRecord, epoch_count),
    FORELAND_FIELD(WelcomeRecord, epochs),       FORELAND_FIELD(WelcomeRecord, model_count),
    FORELAND_FIELD(WelcomeRecord, model_sides),  FORELAND_FIELD(WelcomeRecord, scene_id),
    FORELAND_FIELD(WelcomeRecord, zero_surface), FORELAND_FIELD(WelcomeRecord, datum),
    FORELAND_FIELD(WelcomeRecord, datum_size),   FORELAND_FIELD(WelcomeRecord, geoid),
    FORELAND_FIELD(WelcomeRecord, geoid_size),
};
inline constexpr RecordField kPlaceFields[] = {
    FORELAND_FIELD(MapPositionRecord, height_m),     FORELAND_FIELD(MapPositionRecord, ground_m),
    FORELAND_FIELD(MapPositionRecord, up),           FORELAND_FIELD(MapPositionRecord, across),
    FORELAND_FIELD(MapPositionRecord, lattice),      FORELAND_FIELD(MapPositionRecord, slope_rad),
    FORELAND_FIELD(MapPositionRecord, undulation_m),
};
inline constexpr RecordField kTilesFields[] = {
    FORELAND_FIELD(TilesRecord, scene),      FORELAND_FIELD(TilesRecord, shown),
    FORELAND_FIELD(TilesRecord, page_table), FORELAND_FIELD(TilesRecord, page_count),
    FORELAND_FIELD(TilesRecord, arrivals),   FORELAND_FIELD(TilesRecord, arrival_count),
    FORELAND_FIELD(TilesRecord, dropped),    FORELAND_FIELD(TilesRecord, dropped_count),
};
inline constexpr RecordField kImageFields[] = {
    FORELAND_FIELD(ImageRecord, key),
    FORELAND_FIELD(ImageRecord, coded),
    FORELAND_FIELD(ImageRecord, size),
};
inline constexpr RecordField kLayerFields[] = {
    FORELAND_FIELD(LayerRecord, origin),      FORELAND_FIELD(LayerRecord, texel),
    FORELAND_FIELD(LayerRecord, size),        FORELAND_FIELD(LayerRecord, levels),
    FORELAND_FIELD(LayerRecord, attribution), FORELAND_FIELD(LayerRecord, attribution_size),
    FORELAND_FIELD(LayerRecord, unused),      FORELAND_FIELD(LayerRecord, low_m),
    FORELAND_FIELD(LayerRecord, code_m),
};
inline constexpr RecordField kSlopeFrameFields[] = {
    FORELAND_FIELD(SlopeFrameRecord, gradient_x),
    FORELAND_FIELD(SlopeFrameRecord, gradient_y),
    FORELAND_FIELD(SlopeFrameRecord, latitude),
    FORELAND_FIELD(SlopeFrameRecord, longitude),
    FORELAND_FIELD(SlopeFrameRecord, latitude_step),
    FORELAND_FIELD(SlopeFrameRecord, longitude_step),
    FORELAND_FIELD(SlopeFrameRecord, origin_latitude),
    FORELAND_FIELD(SlopeFrameRecord, semi_major_m),
    FORELAND_FIELD(SlopeFrameRecord, eccentricity_squared),
    FORELAND_FIELD(SlopeFrameRecord, frame_kind),
    FORELAND_FIELD(SlopeFrameRecord, unused),
};
inline constexpr RecordField kStatisticsFields[] = {
    FORELAND_FIELD(StatisticsRecord, bytes_down),
    FORELAND_FIELD(StatisticsRecord, bytes_up),
    FORELAND_FIELD(StatisticsRecord, last_lateness_ms),
    FORELAND_FIELD(StatisticsRecord, worst_lateness_ms),
    FORELAND_FIELD(StatisticsRecord, nodes_added),
    FORELAND_FIELD(StatisticsRecord, nodes_removed),
    FORELAND_FIELD(StatisticsRecord, tile_bytes),
    FORELAND_FIELD(StatisticsRecord, tiles_received),
    FORELAND_FIELD(StatisticsRecord, relief_texel_px),
    FORELAND_FIELD(StatisticsRecord, imagery_texel_px),
    FORELAND_FIELD(StatisticsRecord, keyframes),
    FORELAND_FIELD(StatisticsRecord, late_keyframes),
    FORELAND_FIELD(StatisticsRecord, tiles),
    FORELAND_FIELD(StatisticsRecord, damaged_tiles),
};
inline constexpr RecordField kGroundFields[] = {
    FORELAND_FIELD(GroundRecord, id),
    FORELAND_FIELD(GroundRecord, count),
    FORELAND_FIELD(GroundRecord, heights_m),
    FORELAND_FIELD(GroundRecord, undulations_m),
};
inline constexpr RecordField kTextFields[] = {FORELAND_FIELD(TextRecord, text), FORELAND_FIELD(TextRecord, size)};

#undef FORELAND_FIELD

inline constexpr RecordLayout kRecordLayouts[] = {
    {"RequestRecord", sizeof(RequestRecord), kRequestFields},
    {"PoseRecord", sizeof(PoseRecord), kPoseFields},
    {"FrameRecord", sizeof(FrameRecord), kFrameFields},
    {"ScreenRecord", sizeof(ScreenRecord), kScreenFields},
    {"ChangesRecord", sizeof(ChangesRecord), kChangesFields},
    {"WelcomeRecord", sizeof(WelcomeRecord), kWelcomeFields},
    {"MapPositionRecord", sizeof(MapPositionRecord), kPlaceFields},
    {"TilesRecord", sizeof(TilesRecord), kTilesFields},
    {"ImageRecord", sizeof(ImageRecord), kImageFields},
    {"LayerRecord", sizeof(LayerRecord), kLayerFields},
    {"SlopeFrameRecord", sizeof(SlopeFrameRecord), kSlopeFrameFields},
    {"StatisticsRecord", sizeof(StatisticsRecord), kStatisticsFields},
    {"GroundRecord", sizeof(GroundRecord), kGroundFields},
    {"TextRecord", sizeof(TextRecord), kTextFields},
};

constexpr bool areComplete(std::span<const RecordLayout> layouts) {
  for (const RecordLayout& layout : layouts)
    if (!layout.isComplete()) return false;
  return true;
}
static_assert(areComplete(kRecordLayouts), "a field of a record is missing in its table, or out of order");

// A line `record NAME SIZE` for each record, followed by a line `NAME TYPE OFFSET COUNT` for each of its fields.
inline std::string recordLayoutText() {
  std::string text;
  for (const RecordLayout& layout : kRecordLayouts) {
    text += "record " + std::string(layout.name) + " " + std::to_string(layout.size) + "\n";
    for (const RecordField& f : layout.fields)
      text +=
          std::string(f.name) + " " + f.type + " " + std::to_string(f.offset) + " " + std::to_string(f.count) + "\n";
  }
  return text;
}

}  // namespace foreland::client
