// How a report reads. A struct of figures lists its fields once, beside them,
//
//   template <class Visit> void fields(const Visit& visit) const { visit("nodes", nodes); ... }
//
// and JSON and the lines for people follow from that. A field may be such a struct itself. Any thread.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace foreland::apps {

template <class Figures>
nlohmann::ordered_json toJson(const Figures& figures) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  figures.fields([&json](const char* name, const auto& value) {
    if constexpr (requires { value.fields([](const char*, const auto&) {}); })
      json[name] = toJson(value);
    else
      json[name] = value;
  });
  return json;
}

enum class ReportFormat : uint8_t { kText, kJson };

// As one JSON object, or a line for each figure: its name (those of nested reports joined by points) and its value.
std::string text(const nlohmann::ordered_json& report, ReportFormat format);

}  // namespace foreland::apps
