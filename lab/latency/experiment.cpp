#include "lab/latency/experiment.h"

#include "apps/report/report.h"
#include "lab/tables.h"
#include "oracle/scene_truth.h"
#include "terrain/parallel.h"

namespace foreland::lab {

namespace {

std::string framesCsv(const CellFlight& flight) {
  CsvTable table;
  for (const FrameTerms& frame : flight.frames) {
    table.begin();
    table.cell("time_s", rounded(frame.time_s));
    table.cell("weight", rounded(frame.weight));
    table.cell("delay_ms", rounded(frame.delay_ms));
    for (size_t t = 0; t < kTerms; ++t) {
      const oracle::Deviation& d = frame.terms[t];
      const std::string term = name(static_cast<Term>(t));
      table.cell(term + "_max_px", rounded(d.max_px));
      table.cell(term + "_rms_px", rounded(d.rms_px));
      table.cell(term + "_max_m", rounded(d.max_m));
      table.cell(term + "_rms_m", rounded(d.rms_m));
    }
    table.cell("lod_motion_px", rounded(frame.lod_motion_px));
    table.cell("triangles", std::to_string(frame.triangles));
    table.cell("tolerance_px", rounded(frame.tolerance_px));
    table.end();
  }
  return table.text();
}

std::string keyframesCsv(const CellFlight& flight) {
  CsvTable table;
  for (const FlownKeyframe& k : flight.keyframes) {
    table.begin();
    table.cell("time_s", rounded(k.time_s));
    table.cell("bytes", std::to_string(k.bytes));
    table.cell("lateness_ms", rounded(k.lateness_ms));
    table.cell("compute_ms", rounded(k.compute_ms));
    k.work.fields([&](const std::string& field, uint64_t value) {
      table.cell(field == "bytes" ? "work_bytes" : field, std::to_string(value));  // a column has one meaning
    });
    table.end();
  }
  return table.text();
}

}  // namespace

CellTables tablesOf(const CellFlight& flight, double seconds) {
  return {apps::toJson(figuresOf(flight, seconds)),
          {{"frames.csv", framesCsv(flight)}, {"keyframes.csv", keyframesCsv(flight)}}};
}

Result<std::vector<CellTables>> flyGrid(const LatencyFlight& flight, const std::vector<LatencyCell>& cells,
                                        const nlohmann::ordered_json& asked, const KeptCells& kept, unsigned threads,
                                        const std::function<void(size_t done)>& on_progress) {
  const auto scene = std::shared_ptr<const terrain::Scene>(flight.world, &flight.world->hierarchy.scene());
  std::vector<std::unique_ptr<oracle::Oracle>> oracles(terrain::threadCount(threads));
  for (auto& oracle : oracles) oracle = std::make_unique<oracle::Oracle>(oracle::truthOf(scene));
  const auto compute = [&](size_t i, unsigned worker) -> Result<CellTables> {
    const CellFlight flown = flyCell(flight, cells[i], *oracles[worker]);
    if (!flown.status.ok()) return flown.status.error();
    return tablesOf(flown, flight.seconds);
  };
  const auto isKeepable = [&](size_t i) { return cells[i].predictor_command.empty() && cells[i].link_command.empty(); };
  const auto askedOf = [&](size_t i) {
    nlohmann::ordered_json all = asked;
    all.update(apps::toJson(cells[i]));
    return all;
  };
  return runCells({cells.size(), askedOf, compute, on_progress, isKeepable}, kept, threads);
}

Status checkBound(const std::vector<CellTables>& tables) {
  for (size_t i = 0; i < tables.size(); ++i)
    if (const auto violations = tables[i].row["bound_violations"].get<uint64_t>(); violations > 0)
      return Error{ErrorCode::kMalformed, "flight " + std::to_string(i) + ": in " + std::to_string(violations) +
                                              " frames the total error is above the sum of its terms, so they were "
                                              "not measured over the same samples; report this, with the command"};
  return {};
}

}  // namespace foreland::lab
