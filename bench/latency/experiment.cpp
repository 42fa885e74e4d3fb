#include "bench/latency/experiment.h"

#include "bench/oracle/scene_truth.h"
#include "bench/report.h"
#include "bench/tables.h"
#include "terrain/parallel.h"

namespace foreland::bench {

namespace {

// Files from which plots are drawn need no more than this.
constexpr double kRounding = 1e4;

double rounded(double value) { return std::round(value * kRounding) / kRounding; }

std::string framesCsv(const LatencyResult& result) {
  CsvTable table;
  for (size_t i = 0; i < result.flights.size(); ++i)
    for (const FrameTerms& frame : result.flights[i].frames) {
      table.begin();
      table.cell("cell", std::to_string(i));
      table.cell("time_s", rounded(frame.time_s));
      table.cell("weight", rounded(frame.weight));
      table.cell("delay_ms", rounded(frame.delay_ms));
      for (size_t t = 0; t < kTerms; ++t) {
        const Deviation& d = frame.terms[t];
        const std::string term = name(static_cast<Term>(t));
        table.cell(term + "_max_px", rounded(d.max_px));
        table.cell(term + "_rms_px", rounded(d.rms_px));
        table.cell(term + "_max_m", rounded(d.max_m));
        table.cell(term + "_rms_m", rounded(d.rms_m));
      }
      table.cell("lod_motion_px", rounded(frame.lod_motion_px));
      table.cell("triangles", std::to_string(frame.triangles));
      table.cell("outside", frame.is_outside ? "1" : "0");
      table.end();
    }
  return table.text();
}

std::string keyframesCsv(const LatencyResult& result) {
  CsvTable table;
  for (size_t i = 0; i < result.flights.size(); ++i)
    for (const FlownKeyframe& k : result.flights[i].keyframes) {
      table.begin();
      table.cell("cell", std::to_string(i));
      table.cell("time_s", rounded(k.time_s));
      table.cell("bytes", std::to_string(k.bytes));
      table.cell("lateness_ms", rounded(k.lateness_ms));
      table.cell("compute_ms", rounded(k.compute_ms));
      k.work.fields([&](const char* field, uint64_t value) { table.cell(field, std::to_string(value)); });
      table.end();
    }
  return table.text();
}

}  // namespace

LatencyResult flyGrid(const LatencyFlight& flight, const std::vector<LatencyCell>& cells, unsigned threads,
                      const std::function<void(size_t done)>& on_progress) {
  const auto scene = std::shared_ptr<const terrain::Scene>(flight.world, &flight.world->hierarchy.scene());
  std::vector<std::unique_ptr<Oracle>> oracles;
  for (unsigned i = 0; i < terrain::threadCount(threads); ++i)
    oracles.push_back(std::make_unique<Oracle>(truthOf(scene)));
  LatencyResult result;
  result.cells.resize(cells.size());
  result.flights.resize(cells.size());
  terrain::parallelFor(
      cells.size(), threads,
      [&](uint64_t i, unsigned worker) {
        result.flights[i] = flyCell(flight, cells[i], *oracles[worker]);
        result.cells[i] = figuresOf(result.flights[i], flight.seconds);
      },
      [&](uint64_t done) {
        on_progress(done);
        return true;
      });
  return result;
}

Status writeLatency(const std::filesystem::path& folder, const nlohmann::ordered_json& about,
                    const LatencyResult& result) {
  CsvTable table;
  nlohmann::ordered_json json = about;
  json["cells"] = nlohmann::ordered_json::array();
  for (const CellFigures& cell : result.cells) {
    table.add(cell);
    json["cells"].push_back(toJson(cell));
  }
  if (Status s = writeFile(folder, "results.csv", table.text()); !s.ok()) return s;
  if (Status s = writeFile(folder, "frames.csv", framesCsv(result)); !s.ok()) return s;
  if (Status s = writeFile(folder, "keyframes.csv", keyframesCsv(result)); !s.ok()) return s;
  return writeFile(folder, "results.json", json.dump(1) + "\n");
}

}  // namespace foreland::bench
