#include "terrain/model/gltf/json_fields.h"

#include <cmath>
#include <vector>

#include "terrain/model/model.h"

namespace foreland::terrain {

using nlohmann::json;

namespace {

const json kEmptyObject = json::object();

bool isWhole(const json& value, uint64_t most) {
  if (value.is_number_unsigned()) return value.get<uint64_t>() <= most;
  if (!value.is_number_float()) return false;  // a negative number
  const double number = value.get<double>();   // some exporters write 3.0
  return number >= 0 && number <= 9e15 && number == std::floor(number) && static_cast<uint64_t>(number) <= most;
}

uint64_t toWhole(const json& value) {
  return value.is_number_unsigned() ? value.get<uint64_t>() : static_cast<uint64_t>(value.get<double>());
}

}  // namespace

const json* JsonFields::find(const JsonObject& parent, const char* key) const {
  const auto found = parent.json->find(key);
  return found == parent.json->end() ? nullptr : &*found;
}

const json* JsonFields::arrayOf(const JsonObject& parent, const char* key) {
  const json* array = find(parent, key);
  if (array == nullptr || array->is_array()) return array;
  fail(parent.path + key, "is no array");
  return nullptr;
}

JsonObject JsonFields::object(const JsonObject& parent, const char* key) {
  const json* value = find(parent, key);
  if (value != nullptr && !value->is_object()) fail(parent.path + key, "is no object");
  return {value != nullptr && value->is_object() ? value : &kEmptyObject, parent.path + key + '.'};
}

uint64_t JsonFields::whole(const JsonObject& parent, const char* key, uint64_t most, uint64_t otherwise) {
  const json* value = find(parent, key);
  if (value == nullptr) return otherwise;
  if (isWhole(*value, most)) return toWhole(*value);
  fail(parent.path + key, "is no whole number from 0 to " + std::to_string(most));
  return 0;
}

uint64_t JsonFields::wholeThatMustBe(const JsonObject& parent, const char* key, uint64_t most) {
  if (!has(parent, key)) fail(parent.path + key, "is missing");
  return whole(parent, key, most, 0);
}

uint32_t JsonFields::index(const JsonObject& parent, const char* key, uint64_t count) {
  const json* value = find(parent, key);
  if (value == nullptr) return kNoIndex;
  if (count > 0 && isWhole(*value, count - 1)) return static_cast<uint32_t>(toWhole(*value));
  fail(parent.path + key, "names one of " + std::to_string(count) + " that does not exist");
  return kNoIndex;
}

double JsonFields::number(const JsonObject& parent, const char* key, double otherwise) {
  const json* value = find(parent, key);
  if (value == nullptr) return otherwise;
  if (value->is_number()) return value->get<double>();
  fail(parent.path + key, "is no number");
  return otherwise;
}

std::string JsonFields::text(const JsonObject& parent, const char* key) {
  const json* value = find(parent, key);
  if (value == nullptr) return {};
  if (value->is_string()) return value->get<std::string>();
  fail(parent.path + key, "is no text");
  return {};
}

bool JsonFields::flag(const JsonObject& parent, const char* key) {
  const json* value = find(parent, key);
  if (value == nullptr) return false;
  if (value->is_boolean()) return value->get<bool>();
  fail(parent.path + key, "is neither true nor false");
  return false;
}

bool JsonFields::numbers(const JsonObject& parent, const char* key, size_t count, double* numbers) {
  const json* array = arrayOf(parent, key);
  if (array == nullptr) return false;
  bool are_numbers = array->size() == count;
  for (size_t i = 0; i < count && are_numbers; ++i) {
    are_numbers = (*array)[i].is_number();
    if (are_numbers) numbers[i] = (*array)[i].get<double>();
  }
  if (!are_numbers) fail(parent.path + key, "does not have " + std::to_string(count) + " numbers");
  return are_numbers;
}

std::vector<uint32_t> JsonFields::indices(const JsonObject& parent, const char* key, uint64_t count) {
  std::vector<uint32_t> indices;
  const json* array = arrayOf(parent, key);
  if (array == nullptr) return indices;
  for (const json& value : *array) {
    if (count == 0 || !isWhole(value, count - 1)) {
      fail(parent.path + key, "names one of " + std::to_string(count) + " that does not exist");
      return {};
    }
    indices.push_back(static_cast<uint32_t>(toWhole(value)));
  }
  return indices;
}

}  // namespace foreland::terrain
