#include "bench/tables.h"

#include <array>
#include <charconv>
#include <fstream>
#include <system_error>

namespace foreland::bench {

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

Status writeFile(const std::filesystem::path& folder, const std::string& name, const std::string& text) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{ErrorCode::kIo, "cannot make the folder '" + folder.string() + "': " + error.message()};
  const std::filesystem::path path = folder / name;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (!file) return Error{ErrorCode::kIo, "cannot write '" + path.string() + "'"};
  return {};
}

Result<nlohmann::ordered_json> readJson(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, "cannot open '" + path.string() + "'"};
  auto json = nlohmann::ordered_json::parse(file, nullptr, false);
  if (json.is_discarded()) return Error{ErrorCode::kMalformed, "'" + path.string() + "' is no JSON document"};
  return json;
}

}  // namespace foreland::bench
