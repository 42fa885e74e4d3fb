// The cells of an experiment's grid: computed on several threads, kept in a folder as they are finished, and joined to
// tables. A cell that is kept is not computed again, so an experiment that was stopped resumes where it was. Files are
// renamed into their places when they are whole. Main thread, but for what is said otherwise.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"

namespace foreland::lab {

// What a cell comes to. Equal cells have equal tables.
struct CellTables {
  nlohmann::ordered_json row;  // of results.csv: texts and numbers
  // The cell's rows of other tables: the file's name, and CSV with a header.
  std::vector<std::pair<std::string, std::string>> rows = {};
};

// Finished cells in a folder, found by what was asked of them. Any thread.
class KeptCells {
 public:
  KeptCells() = default;  // keeps nothing and finds nothing
  explicit KeptCells(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // Nothing if the cell is not there, or its file is damaged, or is of another cell.
  std::optional<CellTables> find(const nlohmann::ordered_json& asked) const;
  Status keep(const nlohmann::ordered_json& asked, const CellTables& tables) const;

 private:
  std::filesystem::path pathOf(const nlohmann::ordered_json& asked) const;

  std::filesystem::path folder_;
};

// The cell if it is kept; otherwise what `compute` gives, which then is kept.
Result<CellTables> keptOr(const KeptCells& kept, const nlohmann::ordered_json& asked,
                          const std::function<Result<CellTables>()>& compute);

struct CellWork {
  size_t count = 0;
  std::function<nlohmann::ordered_json(size_t cell)> asked;                 // everything that the tables depend on
  std::function<Result<CellTables>(size_t cell, unsigned worker)> compute;  // called on any thread
  std::function<void(size_t done)> on_progress = [](size_t) {};             // on the calling thread
  // Whether the cell may be kept: not if its tables depend on more than what is asked.
  std::function<bool(size_t cell)> is_keepable = [](size_t) { return true; };
};
// All cells, in order. An Error if one cannot be computed or kept.
Result<std::vector<CellTables>> runCells(const CellWork& work, const KeptCells& kept, unsigned threads);

// How the cells' number is called in tables, and their rows in results.json.
struct CellNames {
  const char *one, *all;
};
// Writes results.csv (a row for each cell), each of the other tables, where the first column is the cell's number, and
// results.json: what `about` says, and the rows.
Status writeCells(const std::filesystem::path& folder, const nlohmann::ordered_json& about, const CellNames& names,
                  const std::vector<CellTables>& cells);

}  // namespace foreland::lab
