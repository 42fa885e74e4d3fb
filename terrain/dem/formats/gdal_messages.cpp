#include "terrain/dem/formats/gdal_messages.h"

#include <cpl_error.h>

#include <algorithm>

namespace foreland::terrain {

namespace {

constexpr size_t kKeep = 3;

void CPL_STDCALL collect(CPLErr severity, CPLErrorNum, const char* text) {
  if (severity < CE_Warning) return;
  static_cast<GdalMessages*>(CPLGetErrorHandlerUserData())->add(severity >= CE_Failure, text);
}

}  // namespace

GdalMessages::GdalMessages() { CPLPushErrorHandlerEx(collect, this); }

GdalMessages::~GdalMessages() { CPLPopErrorHandler(); }

void GdalMessages::add(bool is_error, std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  auto& list = is_error ? errors_ : warnings_;
  if (list.size() < kKeep && std::find(list.begin(), list.end(), text) == list.end()) list.push_back(std::move(text));
}

std::string GdalMessages::joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : "; ") + text;
  return all;
}

std::string GdalMessages::all() const {
  std::vector<std::string> both = errors_;
  both.insert(both.end(), warnings_.begin(), warnings_.end());
  return joined(both);
}

}  // namespace foreland::terrain
