#include "apps/report/report.h"

#include <algorithm>

namespace foreland::apps {

namespace {

using nlohmann::ordered_json;

void addLine(const std::string& name, const ordered_json& value, std::string& out) {
  constexpr size_t kColumn = 34;
  out += name + std::string(std::max(kColumn, name.size() + 2) - name.size(), ' ');
  out +=
      value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  out += "\n";
}

void addLines(const std::string& prefix, const ordered_json& report, std::string& out) {
  for (const auto& [key, value] : report.items()) {
    if (value.is_object())
      addLines(prefix + key + ".", value, out);
    else if (value.is_array() && !value.empty() && value.front().is_string())
      for (const ordered_json& entry : value) addLine(prefix + key, entry, out);
    else
      addLine(prefix + key, value, out);
  }
}

}  // namespace

std::string text(const ordered_json& report, ReportFormat format) {
  if (format == ReportFormat::kJson) return report.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
  std::string out;
  addLines("", report, out);
  return out;
}

}  // namespace foreland::apps
