#include "lab/proxy/link_stream.h"

#include <algorithm>
#include <utility>

#include "base/check.h"

namespace foreland::lab {

namespace {

constexpr size_t kMaxPieceBytes = 64u << 10;
constexpr double kPiece_s = 0.01;

size_t pieceOf(const sim::LinkOptions& options) {
  const double rate = options.trace ? options.trace->bytesPerSecond() : options.bytes_per_second;
  if (rate <= 0) return kMaxPieceBytes;
  return static_cast<size_t>(std::clamp(rate * kPiece_s, static_cast<double>(sim::LinkTrace::kPacketBytes),
                                        static_cast<double>(kMaxPieceBytes)));
}

}  // namespace

LinkStream::LinkStream(const sim::LinkOptions& options, uint64_t seed)
    : link_(options, seed), piece_bytes_(pieceOf(options)) {}

void LinkStream::take(Bytes piece, Time now) {
  CHECK_TRUE(!piece.empty() && !has_ended_);
  bytes_ += piece.size();
  link_.send(std::move(piece), now);
}

// The end is a message without bytes.
void LinkStream::end(Time now) {
  if (std::exchange(has_ended_, true)) return;
  link_.send({}, now);
}

Bytes LinkStream::arrived(Time now) {
  Bytes all;
  for (auto next = link_.nextArrival(); next && *next <= now; next = link_.nextArrival()) {
    const Bytes piece = link_.receive();
    is_over_ = piece.empty();
    all.insert(all.end(), piece.begin(), piece.end());
  }
  bytes_ -= all.size();
  return all;
}

std::optional<Time> LinkStream::nextChange(Time now) const {
  std::optional<Time> change;
  const auto consider = [&](Time t) {
    if (t > now && (!change || t < *change)) change = t;
  };
  if (const auto next = link_.nextArrival()) consider(*next);
  if (!has_ended_) consider(link_.drainedAt());
  return change;
}

}  // namespace foreland::lab
