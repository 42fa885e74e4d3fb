// Reads typed values out of JSON that may hold anything. The first value that is not what it must be is remembered with
// its path; from then on the values do not count, so a reader looks at status() once, at the end. One owner.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "base/result.h"

namespace foreland::terrain {

// An object of the file and its path there, as in accessors[3].sparse. Absent members are empty objects.
struct JsonObject {
  const nlohmann::json* json;
  std::string path;
};

class JsonFields {
 public:
  const Status& status() const { return status_; }
  void fail(const std::string& path, const std::string& what) {
    if (status_.ok()) status_ = Error{ErrorCode::kMalformed, path + " " + what + "; export the model again"};
  }

  static bool has(const JsonObject& object, const char* key) { return object.json->contains(key); }
  JsonObject object(const JsonObject& parent, const char* key);

  // Calls visit(object, index) for the objects of an array, none if it is absent.
  template <class Visit>
  void forObjects(const JsonObject& parent, const char* key, const Visit& visit) {
    const nlohmann::json* array = arrayOf(parent, key);
    if (array == nullptr) return;
    for (size_t i = 0; i < array->size() && status_.ok(); ++i) {
      const JsonObject element{&(*array)[i], parent.path + key + '[' + std::to_string(i) + ']'};
      if (!element.json->is_object())
        fail(element.path, "is no object");
      else
        visit(JsonObject{element.json, element.path + '.'}, static_cast<uint32_t>(i));
    }
  }

  // A whole number from 0 to `most`; `otherwise` if it is absent.
  uint64_t whole(const JsonObject& parent, const char* key, uint64_t most, uint64_t otherwise);
  uint64_t wholeThatMustBe(const JsonObject& parent, const char* key, uint64_t most);
  // An index below `count`, or kNoIndex if it is absent.
  uint32_t index(const JsonObject& parent, const char* key, uint64_t count);
  double number(const JsonObject& parent, const char* key, double otherwise);
  std::string text(const JsonObject& parent, const char* key);
  bool flag(const JsonObject& parent, const char* key);
  // Fills `numbers` if there is such an array, of that many numbers.
  bool numbers(const JsonObject& parent, const char* key, size_t count, double* numbers);
  // Indices below `count`.
  std::vector<uint32_t> indices(const JsonObject& parent, const char* key, uint64_t count);

 private:
  const nlohmann::json* find(const JsonObject& parent, const char* key) const;
  const nlohmann::json* arrayOf(const JsonObject& parent, const char* key);

  Status status_;
};

}  // namespace foreland::terrain
