// Bearer tokens: JSON Web Tokens (RFC 7519), signed by HMAC-SHA256 (HS256) with a secret that servers share. A server
// keeps no list of them. Pure; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.h"

namespace foreland::server {

struct Token {
  std::string name;          // "sub": whose it is; limits hold for all tokens of one name together
  int64_t expires_s = 0;     // "exp": seconds since 1970
  size_t viewers = 0;        // at once, on one server; 0 for no limit
  size_t section_nodes = 0;  // of each viewer; 0 for the server's limit
};

// The shared secret: the bytes of a file without the white space at its end, 32 at least.
Result<std::string> readTokenSecret(const std::filesystem::path& file);

std::string signToken(const Token& token, std::string_view secret);

// An Error says what is wrong, and shows nothing of the token. `now_s` is seconds since 1970.
Result<Token> verifyToken(std::string_view text, std::string_view secret, int64_t now_s);

}  // namespace foreland::server
