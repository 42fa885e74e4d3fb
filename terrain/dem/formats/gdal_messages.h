// Keeps GDAL's messages of this thread off the terminal while it lives, and collects them for ours. Stack-like, as
// GDAL's own handlers.
#pragma once

#include <string>
#include <vector>

namespace foreland::terrain {

class GdalMessages {
 public:
  GdalMessages();
  ~GdalMessages();
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;

  bool hasErrors() const { return !errors_.empty(); }
  // Distinct messages, the first few, joined; empty if none.
  std::string errors() const { return joined(errors_); }
  std::string all() const;

  // For the C callback.
  void add(bool is_error, std::string text);

 private:
  static std::string joined(const std::vector<std::string>& texts);

  std::vector<std::string> errors_, warnings_;
};

}  // namespace foreland::terrain
