// While an object of this class lives, GDAL's messages on this thread do not reach the terminal but are collected here,
// so that errors can quote them. Objects nest like GDAL's own handlers.
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

  // Called by GDAL's error handler.
  void add(bool is_error, std::string text);

 private:
  static std::string joined(const std::vector<std::string>& texts);

  std::vector<std::string> errors_, warnings_;
};

}  // namespace foreland::terrain
