// What a file in a store is called: https://HOST/PATH, http://HOST/PATH, or s3://BUCKET/KEY, whose endpoint, region and
// credentials come from the environment, as other programs' do (AWS_ENDPOINT_URL, AWS_REGION, AWS_ACCESS_KEY_ID,
// AWS_SECRET_ACCESS_KEY, AWS_SESSION_TOKEN). Pure; any thread.
#pragma once

#include <functional>
#include <string>

#include "base/result.h"

namespace foreland::terrain {

struct StoreAddress {
  std::string name;  // as the user wrote it
  std::string url;
  // Of requests that are signed (AWS Signature Version 4); empty of others.
  std::string region, key_id, secret, token;
  bool is_bucket = false;  // an s3:// address

  bool isSigned() const { return !key_id.empty(); }
  // Of a file beside it whose name ends with `suffix` in addition.
  StoreAddress withSuffix(const std::string& suffix) const;
};

// The value of a variable of the environment, or empty.
using Environment = std::function<std::string(const char* name)>;

// Whether a name is that of a file in a store, and not a path.
bool isInStore(const std::string& name);
// An Error if it lacks something.
Result<StoreAddress> addressOf(const std::string& name, const Environment& environment);

}  // namespace foreland::terrain
