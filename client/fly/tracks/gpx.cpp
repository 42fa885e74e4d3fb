// GPX 1.0 and 1.1, whatever the namespace prefix. A file that is not well-formed XML is an Error that names the line; a
// point that is not what it should be is skipped, with a note that names its line. Time and memory are linear in the
// file's size.
#include <optional>
#include <string_view>

#include "client/fly/tracks/point_text.h"
#include "client/fly/tracks/track.h"
#include "client/fly/tracks/track_builder.h"
#include "client/fly/tracks/xml_text.h"

namespace foreland::client {

namespace {

// Adds all elements with one name to a builder, in document order. pugixml walks without recursion, so depth is no
// danger.
class PointReader final : public pugi::xml_tree_walker {
 public:
  PointReader(std::string_view text, std::string_view point_tag, TrackBuilder& builder)
      : lines_(text), point_tag_(point_tag), builder_(builder) {}

  bool for_each(pugi::xml_node& node) override {
    if (localName(node) == point_tag_) add(node);
    return !builder_.isFull();
  }
  size_t points() const { return points_; }

 private:
  void add(const pugi::xml_node& node) {
    ++points_;
    const size_t line = lines_.at(node.offset_debug());
    const auto latitude = decimal(node.attribute("lat").value()), longitude = decimal(node.attribute("lon").value());
    if (!latitude || !longitude) return builder_.skip(line, "point without latitude and longitude");
    if (trimmed(childText(node, "fix")) == "none") return builder_.skip(line, "marked as having no fix (<fix>none)");
    RawFix fix{.latitude_deg = *latitude, .longitude_deg = *longitude};
    for (const pugi::xml_node& child : node.children()) {
      const std::string_view name = localName(child);
      if (trimmed(child.child_value()).empty()) continue;  // as if it were not there
      if (name == "ele" && !(fix.height_m = decimal(child.child_value())))
        return builder_.skip(line, "height is not a number");
      if (name == "time" && !(fix.time_s = timeOf(child.child_value())))
        return builder_.skip(line, "time is not a date and time");
    }
    builder_.add(line, fix);
  }

  static std::string_view childText(const pugi::xml_node& node, std::string_view name) {
    return node.find_child([&](const pugi::xml_node& child) { return localName(child) == name; }).child_value();
  }

  LineCounter lines_;
  std::string_view point_tag_;
  TrackBuilder& builder_;
  size_t points_ = 0;
};

}  // namespace

Result<Track> parseGpx(std::string_view text, const std::string& name) {
  pugi::xml_document document;
  if (Status status = loadXml(text, name, document); !status.ok()) return status.error();
  TrackBuilder builder(name);
  size_t points = 0;
  for (const char* tag : {"trkpt", "rtept", "wpt"}) {
    PointReader reader(text, tag, builder);
    document.traverse(reader);
    points = reader.points();
    if (points > 0 && tag == std::string_view("wpt"))
      builder.note("has no track and no route; its " + std::to_string(points) +
                   " waypoints are flown in the order of the file");
    if (points > 0) break;
  }
  const std::string root = rootName(document);
  return std::move(builder).finish(root == "gpx" || points > 0 ? "a GPX" : "a GPX or KML, not <" + root + ">, as");
}

}  // namespace foreland::client
