#include "client/fly/recording.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "client/fly/options_json.h"

namespace foreland::client {

namespace {

// The file: kRecordingLine; the options as JSON; then what came in, each as its kind (1 byte), time (8 bytes,
// microseconds), size (4 bytes) and bytes; all numbers little-endian. The last one is kEnd.
// client/js/src/worker/recording.ts writes the same, of flights that are steered.
enum RecordKind : uint8_t {
  kOptions = 'o',
  kFrame = 'f',
  kMessage = 'm',
  kReconnect = 'r',
  kSteered = 's',  // eye: x, y, z; orientation: x, y, z, w; as doubles
  kChoice = 'c',   // as JSON
  kJump = 'j',     // the camera that follows was jumped to
  kEnd = 'e'
};
constexpr size_t kPoseBytes = 7 * sizeof(double), kEndBytes = 24;
constexpr double kFarthest_m = 1e9;
constexpr size_t kHeadBytes = 13;
constexpr size_t kMaxOptionsBytes = 512u << 20;  // a track of Track::kMaxFixes fits
constexpr int64_t kMaxTime_us = int64_t{1} << 60;

Error invalid(const std::string& what) { return {ErrorCode::kMalformed, what}; }

uint64_t readNumber(ByteSpan bytes) {
  uint64_t value = 0;
  for (size_t i = 0; i < bytes.size(); ++i) value |= uint64_t{bytes[i]} << (8 * i);
  return value;
}

template <size_t kSize>
std::array<char, kSize> littleEndian(uint64_t value) {
  std::array<char, kSize> bytes;
  for (size_t i = 0; i < kSize; ++i) bytes[i] = static_cast<char>(value >> (8 * i) & 255);
  return bytes;
}

std::array<double, 7> numbersOf(const proto::Pose& pose) {
  const auto& [eye, q] = pose;
  return {eye.x, eye.y, eye.z, q.x, q.y, q.z, q.w};
}

// nullopt if it is none that a camera can have.
std::optional<proto::Pose> poseFrom(ByteSpan bytes) {
  std::array<double, 7> n{};
  for (size_t i = 0; i < n.size(); ++i) n[i] = std::bit_cast<double>(readNumber(bytes.subspan(8 * i, 8)));
  const proto::Pose pose{{n[0], n[1], n[2]}, glm::dquat(n[6], n[3], n[4], n[5])};
  const double far_m = std::max({std::fabs(n[0]), std::fabs(n[1]), std::fabs(n[2])});
  if (!(far_m <= kFarthest_m) || !std::isfinite(n[0] + n[1] + n[2])) return std::nullopt;
  if (!(std::fabs(glm::length(pose.orientation) - 1) < 1e-3)) return std::nullopt;
  return pose;
}

FlightDigest::Value digestFrom(ByteSpan bytes) {
  return {readNumber(bytes.first(8)), readNumber(bytes.subspan(8, 8)), readNumber(bytes.subspan(16, 8))};
}

// What one record of the file says; the rest of the file follows it.
struct Record {
  uint8_t kind = 0;
  Time time;
  ByteSpan bytes;
};

// nullopt where the file ends before the record does.
std::optional<Record> takeRecord(ByteSpan& file) {
  if (file.size() < kHeadBytes) return std::nullopt;
  const size_t size = readNumber(file.subspan(9, 4));
  if (file.size() - kHeadBytes < size) return std::nullopt;
  const Record record{file[0], {static_cast<int64_t>(readNumber(file.subspan(1, 8)))}, file.subspan(kHeadBytes, size)};
  file = file.subspan(kHeadBytes + size);
  return record;
}

Status check(const Record& record, Time last) {
  if (std::string_view("fmrscje").find(static_cast<char>(record.kind)) == std::string_view::npos)
    return invalid("a record of a kind that this version does not know");
  if (record.time < last || record.time.us > kMaxTime_us) return invalid("times that go back");
  if (record.kind == kMessage || record.kind == kChoice) return {};
  const size_t size = record.kind == kEnd ? kEndBytes : record.kind == kSteered ? kPoseBytes : 0;
  if (record.bytes.size() != size) return invalid("a record of the wrong size");
  return {};
}

Result<FlightLog::Entry> entryFrom(const Record& record, bool is_steered) {
  FlightLog::Entry entry{.time = record.time};
  const bool is_of_steered = record.kind == kSteered || record.kind == kChoice || record.kind == kJump;
  if (is_of_steered ? !is_steered : is_steered && record.kind == kFrame)
    return invalid("a record of a flight that was steered, in one that was planned, or the other way round");
  if (record.kind == kMessage) {
    entry.what = FlightLog::What::kMessage;
    entry.message.assign(record.bytes.begin(), record.bytes.end());
  } else if (record.kind == kReconnect) {
    entry.what = FlightLog::What::kReconnect;
  } else if (record.kind == kJump) {
    entry.what = FlightLog::What::kJump;
  } else if (record.kind == kSteered) {
    const auto pose = poseFrom(record.bytes);
    if (!pose) return invalid("a camera that is nowhere, or looks nowhere");
    entry.what = FlightLog::What::kSteered;
    entry.pose = *pose;
  } else if (record.kind == kChoice) {
    auto choice = choiceFromJson({record.bytes.begin(), record.bytes.end()});
    if (!choice) return choice.error();
    entry.what = FlightLog::What::kChoice;
    entry.choice = std::make_shared<const ViewChoice>(std::move(*choice));
  }
  return entry;
}

Result<Recording> parse(ByteSpan file) {
  if (file.size() < kRecordingLine.size() || !std::equal(kRecordingLine.begin(), kRecordingLine.end(), file.begin()))
    return invalid("it does not begin as recordings of `foreland fly --record` do");
  file = file.subspan(kRecordingLine.size());
  const auto first = takeRecord(file);
  if (!first || first->kind != kOptions || first->bytes.size() > kMaxOptionsBytes)
    return invalid("it ends before it says what is flown");
  auto options = optionsFromJson({first->bytes.begin(), first->bytes.end()});
  if (!options.ok()) return options.error();
  Recording recording{.log = {std::move(options).value(), {}}, .shown = {}};
  Time last{-kMaxTime_us};
  while (const auto record = takeRecord(file)) {
    if (Status s = check(*record, last); !s.ok()) return s.error();
    last = record->time;
    if (record->kind != kEnd) {
      auto entry = entryFrom(*record, recording.log.options.is_steered);
      if (!entry) return entry.error();
      recording.log.entries.push_back(std::move(*entry));
      continue;
    }
    recording.shown = digestFrom(record->bytes);
    if (!file.empty()) return invalid("something follows its end");
  }
  return recording;
}

}  // namespace

Result<RecordingWriter> RecordingWriter::create(const std::filesystem::path& path, const PlayerOptions& options) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(kRecordingLine.data(), kRecordingLine.size());
  RecordingWriter writer(path, std::move(file));
  const std::string text = optionsToJson(options);
  writer.put(kOptions, {}, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  if (Status s = writer.flush(); !s.ok()) return s.error();
  return writer;
}

Status RecordingWriter::append(std::span<const FlightLog::Entry> entries) {
  constexpr std::array<uint8_t, 6> kKinds{kFrame,   kMessage, kReconnect,
                                          kSteered, kChoice,  kJump};  // by FlightLog::What
  for (const FlightLog::Entry& entry : entries.subspan(std::min(appended_, entries.size()))) {
    Bytes bytes = entry.message;
    if (entry.what == FlightLog::What::kSteered)
      for (const double number : numbersOf(entry.pose))
        for (const char byte : littleEndian<8>(std::bit_cast<uint64_t>(number)))
          bytes.push_back(static_cast<uint8_t>(byte));
    if (entry.what == FlightLog::What::kChoice) {
      const std::string text = choiceToJson(*entry.choice);
      bytes.assign(text.begin(), text.end());
    }
    put(kKinds[static_cast<size_t>(entry.what)], entry.time, bytes);
  }
  appended_ = entries.size();
  return flush();
}

Status RecordingWriter::finish(const FlightDigest::Value& shown) {
  Bytes bytes;
  for (uint64_t number : {shown.frames, shown.sections, shown.drawn})
    for (char byte : littleEndian<8>(number)) bytes.push_back(static_cast<uint8_t>(byte));
  put(kEnd, {kMaxTime_us}, bytes);
  return flush();
}

void RecordingWriter::put(uint8_t what, Time time, ByteSpan bytes) {
  file_.put(static_cast<char>(what));
  file_.write(littleEndian<8>(static_cast<uint64_t>(time.us)).data(), 8);
  file_.write(littleEndian<4>(bytes.size()).data(), 4);
  file_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

Status RecordingWriter::flush() {
  file_.flush();
  if (file_) return {};
  return Error{ErrorCode::kIo,
               "cannot write the recording " + path_.string() + ": is its folder there, and the disk full?"};
}

Result<Recording> readRecording(const std::filesystem::path& path) {
  std::error_code error;
  std::ifstream file(path, std::ios::binary);
  if (!file || !std::filesystem::is_regular_file(path, error))
    return Error{ErrorCode::kNotFound, "cannot read " + path.string() + ": it must be a file"};
  const Bytes bytes((std::istreambuf_iterator<char>(file)), {});
  auto recording = parse(bytes);
  if (!recording.ok()) return invalid(path.string() + " is no sound recording: " + recording.error().message);
  return recording;
}

}  // namespace foreland::client
