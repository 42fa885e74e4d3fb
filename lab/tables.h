// Tables and documents that experiments leave in a folder. Numbers are written so that reading them gives the same
// doubles, and equal results are equal bytes. Main thread.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/report/report.h"
#include "base/result.h"

namespace foreland::lab {

// The shortest text that reads as this number.
std::string numberText(double value);

// A CSV table (RFC 4180, but lines end in \n) whose columns follow from the first row's fields (apps/report/report.h).
class CsvTable {
 public:
  template <class Figures>
  void add(const Figures& figures) {
    begin();
    figures.fields([this](const char* name, const auto& value) { this->cell(name, textOf(value)); });
    end();
  }
  // A row cell by cell: begin(), cell(), ..., end().
  void begin();
  void cell(const std::string& name, const std::string& text);
  void cell(const std::string& name, double value) { cell(name, numberText(value)); }
  void end();
  // A row of texts and numbers.
  void addRow(const nlohmann::ordered_json& row);
  const std::string& text() const { return text_; }

 private:
  static std::string textOf(const std::string& text) { return text; }
  static std::string textOf(double value) { return numberText(value); }
  static std::string textOf(uint64_t value) { return std::to_string(value); }

  std::string header_, row_, text_;
  bool has_header_ = false;
};

// As exact as plots need.
double rounded(double value);

// Makes the folder and writes the file, or names what the system refused. Whoever reads the file finds what was there
// before or all of the text, never a part of it.
Status writeFile(const std::filesystem::path& folder, const std::string& name, const std::string& text);

// Lists the ways of one flight in its report. With a folder, results.csv has a row for each, and results.json the
// report.
template <class Figures>
Status reportWays(const std::vector<Figures>& ways, const std::filesystem::path& folder,
                  nlohmann::ordered_json& report) {
  CsvTable table;
  report["ways"] = nlohmann::ordered_json::array();
  for (const Figures& way : ways) {
    table.add(way);
    report["ways"].push_back(apps::toJson(way));
  }
  if (folder.empty()) return {};
  if (Status s = writeFile(folder, "results.csv", table.text()); !s.ok()) return s;
  return writeFile(folder, "results.json", report.dump(1) + "\n");
}

// Reads a JSON document of an experiment; errors name the file.
Result<nlohmann::ordered_json> readJson(const std::filesystem::path& path);

}  // namespace foreland::lab
