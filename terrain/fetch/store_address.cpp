#include "terrain/fetch/store_address.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace foreland::terrain {

namespace {

constexpr std::string_view kBucket = "s3://";

std::string withSuffixBeforeQuery(std::string url, const std::string& suffix) {
  url.insert(std::min(url.find_first_of("?#"), url.size()), suffix);
  return url;
}

// Of a key, all but letters, digits, and -._~/ as % and two digits, as signatures have it.
std::string escaped(std::string_view key) {
  constexpr std::string_view kDigits = "0123456789ABCDEF", kOthers = "-._~/";
  std::string result;
  for (const char c : key) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (is_plain || kOthers.find(c) != std::string_view::npos)
      result += c;
    else
      (((result += '%') += kDigits[byte >> 4]) += kDigits[byte & 15]);
  }
  return result;
}

Result<StoreAddress> bucketAddress(const std::string& name, const Environment& environment) {
  const auto refused = [&](const std::string& what) { return Error{ErrorCode::kInvalidArgument, name + ": " + what}; };
  const std::string_view rest = std::string_view(name).substr(kBucket.size());
  const size_t slash = rest.find('/');
  if (slash == std::string_view::npos || slash == 0 || slash + 1 == rest.size())
    return refused("an address of an object is s3://BUCKET/KEY");
  const std::string bucket(rest.substr(0, slash)), key = escaped(rest.substr(slash + 1));
  if (!std::ranges::all_of(
          bucket, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.'; }))
    return refused("names of buckets have small letters, digits, points and hyphens only");
  StoreAddress address;
  address.name = name;
  address.is_bucket = true;
  address.region = environment("AWS_REGION");
  if (address.region.empty()) address.region = environment("AWS_DEFAULT_REGION");
  if (address.region.empty()) address.region = "us-east-1";
  address.key_id = environment("AWS_ACCESS_KEY_ID");
  address.secret = environment("AWS_SECRET_ACCESS_KEY");
  address.token = environment("AWS_SESSION_TOKEN");
  if (address.key_id.empty() != address.secret.empty())
    return refused("AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY go together; set both, or none for a public bucket");
  std::string endpoint = environment("AWS_ENDPOINT_URL");
  while (endpoint.ends_with('/')) endpoint.pop_back();
  if (!endpoint.empty() && !endpoint.starts_with("http://") && !endpoint.starts_with("https://"))
    return refused("AWS_ENDPOINT_URL must begin with https:// or http://, not as '" + endpoint + "'");
  if (!endpoint.empty())
    address.url = endpoint + "/" + bucket + "/" + key;
  else if (bucket.find('.') != std::string::npos)  // which certificates of buckets' own names do not hold for
    address.url = "https://s3." + address.region + ".amazonaws.com/" + bucket + "/" + key;
  else
    address.url = "https://" + bucket + ".s3." + address.region + ".amazonaws.com/" + key;
  return address;
}

}  // namespace

StoreAddress StoreAddress::withSuffix(const std::string& suffix) const {
  StoreAddress other = *this;
  other.name = is_bucket ? name + suffix : withSuffixBeforeQuery(name, suffix);
  other.url = withSuffixBeforeQuery(url, suffix);
  return other;
}

bool isInStore(const std::string& name) {
  return name.starts_with("https://") || name.starts_with("http://") || name.starts_with(kBucket);
}

Result<StoreAddress> addressOf(const std::string& name, const Environment& environment) {
  if (name.starts_with(kBucket)) return bucketAddress(name, environment);
  if (!isInStore(name)) return Error{ErrorCode::kInvalidArgument, name + ": it is no address of a file in a store"};
  StoreAddress address;
  address.name = address.url = name;
  return address;
}

}  // namespace foreland::terrain
