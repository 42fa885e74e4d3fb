#include "lab/cells.h"

#include <atomic>
#include <cstdio>
#include <map>

#include "base/fnv1a.h"
#include "lab/tables.h"
#include "terrain/parallel.h"

namespace foreland::lab {

namespace {

using Json = nlohmann::ordered_json;

// For a file's name alone: what was asked stands in the file, too, and is compared.
uint64_t hashOf(const std::string& text) {
  Fnv1a hash;
  hash.add(text);
  return hash.value();
}

// The rows of one table, with the cell's number before each; the header if they are the first.
std::string numbered(const std::string& csv, const char* name, size_t cell, bool has_header) {
  std::string text;
  for (size_t begin = 0, line = 0; begin < csv.size(); ++line) {
    const size_t end = csv.find('\n', begin) + 1;
    if (line > 0 || has_header)
      text += (line == 0 ? name : std::to_string(cell)) + ("," + csv.substr(begin, end - begin));
    begin = end;
  }
  return text;
}

std::string resultsCsv(const std::vector<CellTables>& cells) {
  CsvTable table;
  for (const CellTables& cell : cells) table.addRow(cell.row);
  return table.text();
}

}  // namespace

std::filesystem::path KeptCells::pathOf(const Json& asked) const {
  char name[32];
  std::snprintf(name, sizeof name, "%016llx.json", static_cast<unsigned long long>(hashOf(asked.dump())));
  return folder_ / name;
}

std::optional<CellTables> KeptCells::find(const Json& asked) const {
  if (folder_.empty()) return std::nullopt;
  const auto json = readJson(pathOf(asked));
  if (!json || !json->is_object() || json->value("asked", Json()) != asked) return std::nullopt;
  CellTables tables{.row = json->value("row", Json())};
  const Json rows = json->value("rows", Json());
  if (!tables.row.is_object() || !rows.is_object()) return std::nullopt;
  for (const auto& [name, csv] : rows.items()) {
    const std::string text = csv.is_string() ? csv.get<std::string>() : "?";
    if (!text.empty() && text.back() != '\n') return std::nullopt;
    tables.rows.emplace_back(name, text);
  }
  return tables;
}

Status KeptCells::keep(const Json& asked, const CellTables& tables) const {
  if (folder_.empty()) return {};
  Json rows = Json::object();
  for (const auto& [name, csv] : tables.rows) rows[name] = csv;
  const Json json{{"asked", asked}, {"row", tables.row}, {"rows", rows}};
  return writeFile(folder_, pathOf(asked).filename().string(), json.dump());
}

Result<CellTables> keptOr(const KeptCells& kept, const Json& asked,
                          const std::function<Result<CellTables>()>& compute) {
  if (auto found = kept.find(asked)) return std::move(*found);
  auto tables = compute();
  if (!tables) return tables;
  if (Status s = kept.keep(asked, *tables); !s.ok()) return s.error();
  return tables;
}

Result<std::vector<CellTables>> runCells(const CellWork& work, const KeptCells& kept, unsigned threads) {
  std::vector<CellTables> cells(work.count);
  std::vector<Status> kept_well(work.count);
  std::atomic<bool> failed = false;
  const KeptCells nowhere;
  const auto run = [&](uint64_t i, unsigned worker) {
    const KeptCells& folder = work.is_keepable(i) ? kept : nowhere;
    auto cell = keptOr(folder, work.asked(i), [&] { return work.compute(i, worker); });
    if (!cell) {
      kept_well[i] = cell.error();
      failed = true;
      return;
    }
    cells[i] = std::move(*cell);
  };
  terrain::parallelFor(work.count, threads, run, [&](uint64_t done) {
    work.on_progress(done);
    return !failed;
  });
  for (const Status& status : kept_well)
    if (!status.ok()) return status.error();
  return cells;
}

Status writeCells(const std::filesystem::path& folder, const Json& about, const CellNames& names,
                  const std::vector<CellTables>& cells) {
  std::map<std::string, std::string> tables;
  Json json = about;
  json[names.all] = Json::array();
  for (size_t i = 0; i < cells.size(); ++i) {
    json[names.all].push_back(cells[i].row);
    for (const auto& [name, csv] : cells[i].rows) tables[name] += numbered(csv, names.one, i, tables[name].empty());
  }
  tables["results.csv"] = resultsCsv(cells);
  for (const auto& [name, text] : tables)
    if (Status s = writeFile(folder, name, text); !s.ok()) return s;
  return writeFile(folder, "results.json", json.dump(1) + "\n");
}

}  // namespace foreland::lab
