// The report of `foreland remesh`: how far the surface is from the model. Main thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "proto/topology/atlas_layout.h"
#include "terrain/remesh/original/original.h"
#include "terrain/surface/inner_solids.h"
#include "terrain/surface/surface.h"

namespace foreland::apps {

struct PoseReport {
  std::string date;
  double hausdorff = 0;  // as RemeshReport's
};

struct RemeshReport {
  uint64_t original_vertices = 0, original_triangles = 0;
  uint64_t base_vertices = 0, base_triangles = 0, full_triangles = 0;
  int levels = 0;
  double diagonal = 0;  // of the original's box, in its units
  // The largest distance of a point of one surface from the other, as a share of the diagonal. The true distance is at
  // most `tolerance` larger.
  double to_original = 0, to_surface = 0, tolerance = 0;
  // Triangles that face away from the original: as repaired, and with the orientation that its file gives each face.
  uint64_t flipped = 0, flipped_as_given = 0;
  uint64_t welded = 0, turned = 0;  // vertices merged; faces whose orientation changed
  terrain::Repairs repairs;
  std::vector<std::string> notes;  // printed elsewhere, but for JSON
  double step = 0;
  std::vector<PoseReport> poses;
  proto::AtlasLayout atlas;
  terrain::InnerSolids solids;
  std::string why_no_solids;  // if there are none
  double largest_error = 0;   // of what is drawn at any level, in the model's units
  double seconds = 0;

  double hausdorff() const { return to_original > to_surface ? to_original : to_surface; }
};

// What was done to the model before it was remeshed; one note for each kind of change.
std::vector<std::string> repairNotes(const terrain::Original& original);

// Compares the surface, with its rounded positions, with the model as given: faces without area, which the original
// lacks, count as lines. The caller fills in atlas, notes, poses,
// solids and seconds.
RemeshReport judgeRemesh(const terrain::Model& model, const terrain::Original& original,
                         const terrain::TrueSurface& surface, unsigned threads);

// One sentence, for the notes in the surface's file.
std::string sentence(const RemeshReport& report);
void printReport(const RemeshReport& report, const std::filesystem::path& output, uint64_t id, bool as_json);

}  // namespace foreland::apps
