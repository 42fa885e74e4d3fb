#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "terrain/objects/placed_objects.h"

namespace foreland::terrain {

namespace {

Error wrong(const std::string& text, const std::string& what) {
  return {ErrorCode::kInvalidArgument,
          "--object " + text + ": " + what +
              "; give MODEL.fls@LAT,LON[,height[,heading[,scale]]] (planar scenes: map x, y in metres), or "
              "MODEL.fls@here[,...] for a model in the map's coordinates"};
}

}  // namespace

Result<ObjectRequest> parseObject(const std::string& text) {
  const size_t at = text.rfind('@');
  if (at == std::string::npos || at == 0) return wrong(text, "there is no place");
  std::vector<double> numbers;
  std::string_view places = std::string_view(text).substr(at + 1);
  constexpr std::string_view kHere = "here";
  const bool is_here = places == kHere || places.starts_with("here,");
  const bool has_numbers = !is_here || places != kHere;
  if (is_here) {
    numbers = {0, 0};
    places.remove_prefix(std::min(places.size(), kHere.size() + 1));
  }
  for (size_t begin = 0; has_numbers && begin <= places.size();) {
    const size_t end = std::min(places.find(',', begin), places.size());
    const std::string_view field = places.substr(begin, end - begin);
    double value = 0;
    const auto read = std::from_chars(field.data(), field.data() + field.size(), value);
    if (read.ec != std::errc() || read.ptr != field.data() + field.size() || !std::isfinite(value))
      return wrong(text, "'" + std::string(field) + "' is no number");
    numbers.push_back(value);
    begin = end + 1;
  }
  if (numbers.size() < 2 || numbers.size() > 5)
    return wrong(text, std::to_string(numbers.size()) + " numbers after the @");
  numbers.resize(5, std::nan(""));
  const auto numberOr = [&](size_t i, double otherwise) { return std::isnan(numbers[i]) ? otherwise : numbers[i]; };
  ObjectRequest request{text.substr(0, at), {numbers[0], numbers[1]}, numberOr(2, 0),
                        numberOr(3, 0),     numberOr(4, 1),           is_here};
  if (!(request.scale >= 1e-6 && request.scale <= 1e6)) return wrong(text, "a scale must be 1e-6 to 1e6");
  return request;
}

}  // namespace foreland::terrain
