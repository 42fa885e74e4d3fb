#include "terrain/fetch/http_source.h"

#include <curl/curl.h>

#include <array>
#include <atomic>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/check.h"

namespace foreland::terrain {

namespace {

struct EasyDelete {
  void operator()(CURL* handle) const { curl_easy_cleanup(handle); }
};
using Easy = std::unique_ptr<CURL, EasyDelete>;
struct ListDelete {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};

void initialise() {
  static std::once_flag once;
  std::call_once(once, [] { CHECK_EQ(curl_global_init(CURL_GLOBAL_DEFAULT), CURLE_OK); });
}

// What a reply's body is put into.
struct Body {
  Bytes bytes;
  uint64_t most = 0;
  bool is_too_long = false;
};

size_t onBytes(char* data, size_t, size_t count, void* user) {
  Body& body = *static_cast<Body*>(user);
  if (body.bytes.size() + count > body.most) {
    body.is_too_long = true;
    return 0;  // ends the transfer
  }
  body.bytes.insert(body.bytes.end(), data, data + count);
  return count;
}

int onProgress(void* user, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
  return static_cast<std::atomic<bool>*>(user)->load(std::memory_order_relaxed) ? 1 : 0;
}

class HttpSource final : public RangeSource {
 public:
  explicit HttpSource(StoreAddress address) : address_(std::move(address)) { initialise(); }

  Result<Bytes> read(uint64_t offset, uint64_t bytes) override {
    return get(std::to_string(offset) + "-" + std::to_string(offset + bytes - 1), bytes);
  }
  void stop() override { stops_ = true; }
  // With an empty range all of it.
  Result<Bytes> get(const std::string& range, uint64_t most_bytes);

 private:
  Easy take();
  std::unique_ptr<curl_slist, ListDelete> signedHeaders() const;
  void prepare(CURL* handle, const std::string& range, Body& body);
  Error error(ErrorCode code, const std::string& what) const { return {code, address_.name + ": " + what}; }
  Status check(long status, const std::string& range, const Body& body) const;
  Error failure(CURLcode code, const char* text) const;

  const StoreAddress address_;
  std::atomic<bool> stops_{false};
  std::mutex mutex_;        // of the handles that nobody uses
  std::vector<Easy> idle_;  // with their connections
};

Easy HttpSource::take() {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) return Easy(curl_easy_init());
  Easy handle = std::move(idle_.back());
  idle_.pop_back();
  return handle;
}

void HttpSource::prepare(CURL* handle, const std::string& range, Body& body) {
  constexpr long kConnect_s = 10, kSilent_s = 10, kSilentBytes = 1, kRedirections = 5;
  curl_easy_reset(handle);  // keeps its connection
  curl_easy_setopt(handle, CURLOPT_URL, address_.url.c_str());
  curl_easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
  // Not of signed requests: the token is a header of ours, which would go to wherever it is led.
  curl_easy_setopt(handle, CURLOPT_FOLLOWLOCATION, address_.isSigned() ? 0L : 1L);
  curl_easy_setopt(handle, CURLOPT_MAXREDIRS, kRedirections);
  curl_easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(handle, CURLOPT_CONNECTTIMEOUT, kConnect_s);
  curl_easy_setopt(handle, CURLOPT_LOW_SPEED_LIMIT, kSilentBytes);
  curl_easy_setopt(handle, CURLOPT_LOW_SPEED_TIME, kSilent_s);
  curl_easy_setopt(handle, CURLOPT_USERAGENT, "foreland");
  curl_easy_setopt(handle, CURLOPT_WRITEFUNCTION, onBytes);
  curl_easy_setopt(handle, CURLOPT_WRITEDATA, &body);
  curl_easy_setopt(handle, CURLOPT_NOPROGRESS, 0L);
  curl_easy_setopt(handle, CURLOPT_XFERINFOFUNCTION, onProgress);
  curl_easy_setopt(handle, CURLOPT_XFERINFODATA, &stops_);
  if (!range.empty()) curl_easy_setopt(handle, CURLOPT_RANGE, range.c_str());
  if (!address_.isSigned()) return;
  curl_easy_setopt(handle, CURLOPT_AWS_SIGV4, ("aws:amz:" + address_.region + ":s3").c_str());
  curl_easy_setopt(handle, CURLOPT_USERNAME, address_.key_id.c_str());
  curl_easy_setopt(handle, CURLOPT_PASSWORD, address_.secret.c_str());
}

// What object stores want to be signed in addition, which libcurl 7.88 does not send by itself: the SHA-256 of the
// body, which has no bytes.
std::unique_ptr<curl_slist, ListDelete> HttpSource::signedHeaders() const {
  if (!address_.isSigned()) return nullptr;
  curl_slist* list = curl_slist_append(
      nullptr, "x-amz-content-sha256: e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  if (!address_.token.empty()) list = curl_slist_append(list, ("x-amz-security-token: " + address_.token).c_str());
  return std::unique_ptr<curl_slist, ListDelete>(list);
}

Result<Bytes> HttpSource::get(const std::string& range, uint64_t most_bytes) {
  Easy handle = take();
  if (!handle) return error(ErrorCode::kIo, "no memory for a request");
  Body body{.bytes = {}, .most = most_bytes};
  prepare(handle.get(), range, body);
  const auto headers = signedHeaders();
  if (headers) curl_easy_setopt(handle.get(), CURLOPT_HTTPHEADER, headers.get());
  std::array<char, CURL_ERROR_SIZE> text{};
  curl_easy_setopt(handle.get(), CURLOPT_ERRORBUFFER, text.data());
  const CURLcode code = curl_easy_perform(handle.get());
  long status = 0;
  curl_easy_getinfo(handle.get(), CURLINFO_RESPONSE_CODE, &status);
  curl_easy_setopt(handle.get(), CURLOPT_ERRORBUFFER, nullptr);
  {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(handle));
  }
  if (code != CURLE_OK && !body.is_too_long) return failure(code, text.data());
  if (Status s = check(status, range, body); !s.ok()) return s.error();
  return std::move(body.bytes);
}

Error HttpSource::failure(CURLcode code, const char* text) const {
  const std::string what = *text != '\0' ? text : curl_easy_strerror(code);
  if (code == CURLE_OPERATION_TIMEDOUT || code == CURLE_COULDNT_CONNECT || code == CURLE_COULDNT_RESOLVE_HOST)
    return error(ErrorCode::kIo, "the store cannot be reached (" + what + "); check the address and the network");
  return error(ErrorCode::kIo, "the store does not answer as it should (" + what + ")");
}

Status HttpSource::check(long status, const std::string& range, const Body& body) const {
  if (status == 200 && !range.empty())
    return error(ErrorCode::kUnsupported,
                 "the store answers no ranges (200 to a request for a part); serve the file by one that does, such as "
                 "nginx, Caddy or an object store");
  if (status == (range.empty() ? 200 : 206)) {
    if (!body.is_too_long) return {};
    return error(ErrorCode::kIo, range.empty() ? "it is too long" : "the store gives more than was asked for");
  }
  if ((status == 401 || status == 403) && address_.is_bucket)
    return error(ErrorCode::kIo,
                 std::string("the store refuses it (") + std::to_string(status) +
                     (address_.isSigned() ? "); is AWS_ACCESS_KEY_ID that of somebody who may read it, and AWS_REGION "
                                            "right?"
                                          : "); set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY"));
  if (status == 401 || status == 403)
    return error(ErrorCode::kIo, "the store refuses it (" + std::to_string(status) +
                                     "); give an address that may be read without a password, or one that is signed");
  if (status >= 300 && status < 400 && address_.isSigned())
    return error(ErrorCode::kIo,
                 "the store leads elsewhere (" + std::to_string(status) +
                     "), where signed requests are not sent; are AWS_REGION and AWS_ENDPOINT_URL right?");
  if (status == 404) return error(ErrorCode::kNotFound, "the store has no such file (404); check its name");
  if (status == 416)
    return error(ErrorCode::kIo, "the file is shorter in the store than it was (416); copy it there again");
  return error(ErrorCode::kIo, "the store answers " + std::to_string(status));
}

}  // namespace

std::shared_ptr<RangeSource> httpSource(const StoreAddress& address) { return std::make_shared<HttpSource>(address); }

Result<Bytes> fetchWhole(const StoreAddress& address, uint64_t most_bytes) {
  return HttpSource(address).get({}, most_bytes);
}

}  // namespace foreland::terrain
