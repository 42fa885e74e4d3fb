#include "client/c/session_loop.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <variant>

#include "client/c/session.h"

namespace foreland::client {
namespace {

using std::chrono::milliseconds;

constexpr Duration kFirstWait = Duration::milliseconds(500), kLongestWait = Duration::milliseconds(8000);
constexpr milliseconds kTimeout{10'000}, kLongestRun{100}, kLongestIdle{1000}, kClosing{100};
constexpr size_t kMaxUnsent = 1u << 20;  // bytes, beside the largest message
constexpr size_t kMaxUntaken = 8;        // meshes that were made and not taken; while there are so many none is made

constexpr const char* kNoSession =
    "There is no connection with a session: ask again after the next FORELAND_EVENT_SCENE.";

}  // namespace

SessionLoop::SessionLoop(SessionOptions options, const std::stop_token& stop, Post post)
    : options_(std::move(options)), post_(std::move(post)), next_at_(sessionNow()), wait_(kFirstWait) {
  options_.connection.stop = stop;
  makeViewer();
}

void SessionLoop::makeViewer() {
  held_.reset();
  Held& held = held_.emplace(options_.request);
  held.viewer.drawAhead();
  if (!options_.has_meshes) held.viewer.leaveMeshesEmpty();
  if (clock_) held.viewer.setSceneClock(*clock_);
  if (path_) held.viewer.announcePath(*path_);
  applyBlend();
}

// Splines do not go with scene time that runs (docs/decisions/0015-blends.md).
void SessionLoop::applyBlend() {
  const bool runs = clock_ && clock_->rate != 0;
  held_->viewer.setBlend(runs && orderOf(options_.blend) > 1 ? Blend::kKeyframe : options_.blend);
}

// ---- what the host says

void SessionLoop::handle(ToSession message) {
  std::visit([this](auto& m) { on(std::move(m)); }, message);
  sendOutgoing();
}

void SessionLoop::on(told::Frame message) {
  std::erase_if(untaken_, [&](uint32_t version) { return version <= message.taken; });
  held_->viewer.frame(message.now, message.pose);
  sendMesh();
  from::State state{held_->viewer.statistics(), held_->viewer.tiles().bytes(), is_greeted_};
  if (is_greeted_) state.ground = held_->ground.update(held_->viewer, message.pose.eye, message.ground_reach);
  post_(std::move(state));
}

void SessionLoop::on(told::Jump) { held_->viewer.jump(); }

void SessionLoop::on(told::Request message) {
  const bool may_occlude = options_.request.occlusion;
  options_.request = message.request;
  held_->viewer.setRequest(message.request);
  if (message.request.occlusion && !may_occlude && is_greeted_) on(told::Reconnect{});
}

void SessionLoop::on(told::SetBlend message) {
  options_.blend = message.blend;
  applyBlend();
}

void SessionLoop::on(told::Clock message) {
  clock_ = message.clock;
  held_->viewer.setSceneClock(message.clock);
  applyBlend();
}

void SessionLoop::on(told::Path message) {
  path_ = std::move(message.path);
  if (path_->poses.empty())
    path_.reset();
  else
    held_->viewer.announcePath(*path_);
}

void SessionLoop::on(told::Token message) { options_.connection.token = std::move(message.token); }

void SessionLoop::on(told::Seen message) {
  is_seen_ = message.is_seen;
  if (is_seen_ && next_ == Next::kWhenSeen) next_ = Next::kAtTime;
}

void SessionLoop::on(told::Reconnect) {
  leaveUnanswered(kNoSession);
  connection_.reset();
  is_greeted_ = false;
  next_ = Next::kAtTime;
  next_at_ = sessionNow();
}

void SessionLoop::on(told::Redraw message) {
  redraws_ = message.count;
  held_->newest.redraw();
  untaken_.clear();
  is_update_whole_ = true;
  sendMesh();
}

void SessionLoop::on(told::Heights message) {
  heights_.push_back({message.question, std::move(message.positions)});
  askHeights();
}

void SessionLoop::on(told::Sight message) {
  if (!is_greeted_) return unanswered(message.question, kNoSession);
  sights_[held_->viewer.requestSight(std::move(message.request))] = message.question;
}

void SessionLoop::on(told::Viewshed message) {
  if (!is_greeted_) return unanswered(message.question, kNoSession);
  if (viewshed_) unanswered(viewshed_->second, "Another viewshed was asked for, and one is made at a time.");
  viewshed_.emplace(held_->viewer.requestViewshed(message.request), message.question);
}

void SessionLoop::on(told::Cancel message) {
  for (HeightsQuestion& asked : heights_)
    if (asked.question == message.question) asked.question = 0;
  if (viewshed_ && viewshed_->second == message.question) {
    held_->viewer.cancelRequest(viewshed_->first);
    viewshed_.reset();
  }
  std::erase_if(sights_, [&](const auto& sight) { return sight.second == message.question; });
}

// ---- the connection

milliseconds SessionLoop::idle() const {
  if (next_ != Next::kAtTime) return kLongestIdle;
  return std::clamp(milliseconds((next_at_ - sessionNow()).us / 1000 + 1), milliseconds(1), kLongestIdle);
}

void SessionLoop::connectIfDue() {
  if (connection_ || next_ != Next::kAtTime || sessionNow() < next_at_) return;
  if (!is_seen_ && was_greeted_) {
    next_ = Next::kWhenSeen;
    return;
  }
  options_.connection.area = held_->viewer.area();
  auto made = WebSocketClient::connect(options_.url, kTimeout, options_.connection);
  if (options_.connection.stop.stop_requested()) return;
  if (!made.ok()) return waitAndReconnect(made.error().message);
  connection_ = std::make_shared<WebSocketClient>(std::move(*made));
  begin();
}

// After a lost connection the viewer resumes from what it holds.
void SessionLoop::begin() {
  is_greeted_ = has_refused_ = false;
  largest_bytes_ = 0;
  asked_heights_.reset();
  if (was_greeted_) {
    held_->viewer.reconnect(sessionNow());
    held_->ground.reconnect();
  } else {
    makeViewer();
  }
  sendOutgoing();
}

void SessionLoop::run() {
  const auto until = WebSocketClient::Clock::now() + kLongestRun;
  const Status status = connection_->run(until, [this](ByteSpan message) { return receive(message); });
  if (status.ok()) return;
  if (!has_refused_) return lose(status.error().message, connection_->lostBy());
  leaveUnanswered(kNoSession);
  connection_.reset();
  is_greeted_ = false;
  next_ = Next::kWhenTold;
  post_(from::Refused{status.error().message});
}

void SessionLoop::lose(const std::string& reason, LostBy by) {
  leaveUnanswered("The connection was lost, and the question with it: ask again.");
  connection_.reset();
  is_greeted_ = false;
  if (by != LostBy::kMigrate || wait_ != kFirstWait) return waitAndReconnect(reason);
  // Once, until a message has arrived.
  wait_ = kFirstWait * 2;
  next_at_ = sessionNow();
  post_(from::Migrate{});
}

void SessionLoop::waitAndReconnect(const std::string& reason) {
  std::uniform_real_distribution<double> share(0.5, 1);
  next_ = Next::kAtTime;
  next_at_ = sessionNow() + Duration{static_cast<int64_t>(static_cast<double>(wait_.us) * share(random_))};
  post_(from::Stall{wait_, reason});
  wait_ = std::min(wait_ * 2, kLongestWait);
}

void SessionLoop::end() {
  if (connection_) connection_->close(kClosing);
  connection_.reset();
}

// Messages are coded against earlier ones, so all are sent until a connection is given up.
void SessionLoop::sendOutgoing() {
  for (Bytes message; held_->viewer.takeOutgoing(message);) {
    if (!connection_) continue;  // the next connection begins anew
    largest_bytes_ = std::max(largest_bytes_, message.size());
    connection_->send(std::move(message));
  }
  if (connection_ && connection_->unsentBytes() > kMaxUnsent + largest_bytes_)
    lose("The network took up nothing more.", LostBy::kFailure);
}

// ---- what the server says

Status SessionLoop::receive(ByteSpan message) {
  wait_ = kFirstWait;
  const Status status = held_->viewer.receive(message, sessionNow());
  if (!status.ok()) {
    has_refused_ = true;
    return status;
  }
  if (!is_greeted_ && held_->viewer.isGreeted()) greet();
  takeReplies();
  sendMesh();
  for (Bytes outgoing; held_->viewer.takeOutgoing(outgoing);) connection_->send(std::move(outgoing));
  return {};
}

void SessionLoop::greet() {
  is_greeted_ = was_greeted_ = true;
  post_(from::Welcome{*held_->viewer.welcome()});
  askHeights();
}

void SessionLoop::askHeights() {
  while (!heights_.empty() && heights_.front().question == 0 && !asked_heights_) heights_.pop_front();
  if (!is_greeted_ || asked_heights_ || heights_.empty()) return;
  asked_heights_ = held_->viewer.requestGround(heights_.front().positions);
}

void SessionLoop::takeReplies() {
  if (auto ground = asked_heights_ ? held_->viewer.takeGround(*asked_heights_) : std::nullopt) {
    const uint64_t question = heights_.front().question;
    if (question != 0) post_(from::Heights{question, std::move(ground->heights_m), std::move(ground->undulations_m)});
    heights_.pop_front();
    asked_heights_.reset();
    askHeights();
  }
  while (auto reply = held_->viewer.takeSight()) {
    const auto asked = sights_.extract(reply->id);
    if (asked.empty()) continue;
    if (reply->error.empty())
      post_(from::Sights{asked.mapped(), std::move(*reply)});
    else
      unanswered(asked.mapped(), reply->error);
  }
  takeViewsheds();
}

void SessionLoop::takeViewsheds() {
  while (auto reply = held_->viewer.takeViewshed()) {
    if (!viewshed_ || viewshed_->first != reply->id) continue;
    const uint64_t question = viewshed_->second;
    const bool is_over = reply->begin + reply->cells.size() == size_t{reply->columns} * reply->rows;
    if (is_over || !reply->error.empty()) viewshed_.reset();
    if (reply->error.empty())
      post_(from::Viewshed{question, std::move(*reply)});
    else
      unanswered(question, reply->error);
  }
}

void SessionLoop::leaveUnanswered(const std::string& reason) {
  for (const auto& [id, question] : sights_) unanswered(question, reason);
  sights_.clear();
  if (viewshed_) unanswered(viewshed_->second, reason);
  viewshed_.reset();
}

void SessionLoop::unanswered(uint64_t question, const std::string& reason) {
  post_(from::Unanswered{question, reason});
}

void SessionLoop::sendMesh() {
  if (untaken_.size() >= kMaxUntaken) return;
  const Interval* newest = held_->newest.take();
  if (newest == nullptr) return;
  from::Mesh mesh{redraws_, *newest, held_->viewer.timeline().oldestVersion(), nullptr};
  if (options_.has_meshes)
    mesh.update = std::make_unique<const MeshUpdate>(
        takeUpdate(held_->viewer.drawn(), *newest, mesh.oldest_version, std::exchange(is_update_whole_, false)));
  untaken_.push_back(newest->version);
  post_(std::move(mesh));
}

}  // namespace foreland::client
