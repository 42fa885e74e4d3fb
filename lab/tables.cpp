#include "lab/tables.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <system_error>

namespace foreland::lab {

std::string numberText(double value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() ? std::string(text.data(), end) : std::string("nan");
}

void CsvTable::begin() { row_.clear(); }

void CsvTable::cell(const std::string& name, const std::string& text) {
  const bool must_quote = text.find_first_of(",\"\n") != std::string::npos;
  std::string quoted;
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  if (!has_header_) header_ += (header_.empty() ? "" : ",") + name;
  row_ += (row_.empty() ? "" : ",") + (must_quote ? '"' + quoted + '"' : text);
}

void CsvTable::end() {
  if (!has_header_) text_ += header_ + "\n";
  has_header_ = true;
  text_ += row_ + "\n";
}

void CsvTable::addRow(const nlohmann::ordered_json& row) {
  begin();
  for (const auto& [name, value] : row.items())
    cell(name, value.is_string()         ? value.get<std::string>()
               : value.is_number_float() ? numberText(value.get<double>())
                                         : value.dump());
  end();
}

double rounded(double value) { return std::round(value * 1e4) / 1e4; }

Status writeFile(const std::filesystem::path& folder, const std::string& name, const std::string& text) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{ErrorCode::kIo, "cannot make the folder '" + folder.string() + "': " + error.message()};
  const std::filesystem::path path = folder / name, part = folder / (name + ".part");
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (!file) return Error{ErrorCode::kIo, "cannot write '" + part.string() + "'"};
  std::filesystem::rename(part, path, error);
  if (error) return Error{ErrorCode::kIo, "cannot write '" + path.string() + "': " + error.message()};
  return {};
}

Result<nlohmann::ordered_json> readJson(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, "cannot open '" + path.string() + "'"};
  auto json = nlohmann::ordered_json::parse(file, nullptr, false);
  if (json.is_discarded()) return Error{ErrorCode::kMalformed, "'" + path.string() + "' is no JSON document"};
  return json;
}

}  // namespace foreland::lab
