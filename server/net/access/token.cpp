#include "server/net/access/token.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

namespace foreland::server {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kHeader = R"({"alg":"HS256","typ":"JWT"})";
constexpr size_t kMaxBytes = 4096, kMinSecret = 32, kMaxName = 200;
constexpr size_t kMax = 1'000'000'000;  // of any limit

// RFC 4648, section 5, without padding.
std::string toBase64Url(std::string_view bytes) {
  std::string text(4 * (bytes.size() / 3 + 1) + 1, '\0');
  const int size =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.resize(static_cast<size_t>(size));
  text.resize(text.find_last_not_of('=') + 1);
  std::replace(text.begin(), text.end(), '+', '-');
  std::replace(text.begin(), text.end(), '/', '_');
  return text;
}

std::optional<std::string> fromBase64Url(std::string_view text) {
  if (text.empty() || text.size() % 4 == 1 || text.find_first_of("+/= \t\r\n") != std::string_view::npos)
    return std::nullopt;
  std::string padded(text);
  std::replace(padded.begin(), padded.end(), '-', '+');
  std::replace(padded.begin(), padded.end(), '_', '/');
  const size_t missing = (4 - padded.size() % 4) % 4;
  padded.append(missing, '=');
  std::string bytes(padded.size() / 4 * 3, '\0');
  const int size =
      EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()),
                      reinterpret_cast<const unsigned char*>(padded.data()), static_cast<int>(padded.size()));
  if (size < 0) return std::nullopt;
  bytes.resize(static_cast<size_t>(size) - missing);
  return bytes;
}

std::string signatureOf(std::string_view text, std::string_view secret) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()),
       reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data(), &size);
  return {reinterpret_cast<const char*>(digest.data()), size};
}

bool isSignedBy(std::string_view text, std::string_view signature, std::string_view secret) {
  const auto given = fromBase64Url(signature);
  const std::string expected = signatureOf(text, secret);
  return given && given->size() == expected.size() &&
         CRYPTO_memcmp(given->data(), expected.data(), expected.size()) == 0;
}

// A whole number from 0 to `most`; `otherwise` if there is none of that name.
std::optional<int64_t> numberIn(const Json& claims, const char* name, int64_t otherwise, int64_t most) {
  const auto at = claims.find(name);
  if (at == claims.end()) return otherwise;
  if (!at->is_number_integer()) return std::nullopt;
  const auto value = at->get<int64_t>();
  return value < 0 || value > most ? std::nullopt : std::optional(value);
}

Error wrong(const char* why) { return {ErrorCode::kInvalidArgument, std::string("the token ") + why}; }

Result<Token> readClaims(std::string_view payload) {
  const auto bytes = fromBase64Url(payload);
  const Json claims = bytes ? Json::parse(*bytes, nullptr, false) : Json();
  if (!claims.is_object()) return wrong("is malformed");
  const auto expires = numberIn(claims, "exp", -1, INT64_MAX), viewers = numberIn(claims, "viewers", 0, kMax),
             nodes = numberIn(claims, "nodes", 0, kMax);
  const auto name = claims.find("sub");
  if (!expires || *expires < 0) return wrong("does not say when it expires");
  if (!viewers || !nodes || name == claims.end() || !name->is_string()) return wrong("is malformed");
  Token token{name->get<std::string>(), *expires, static_cast<size_t>(*viewers), static_cast<size_t>(*nodes)};
  if (token.name.size() > kMaxName) return wrong("has too long a name");
  return token;
}

}  // namespace

Result<std::string> readTokenSecret(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return Error{ErrorCode::kNotFound, fmt::format("cannot read the tokens' secret '{}'", file.string())};
  std::string secret{std::istreambuf_iterator<char>(in), {}};
  secret.resize(secret.find_last_not_of(" \t\r\n") + 1);
  if (secret.size() < kMinSecret || secret.size() > kMaxBytes)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the tokens' secret '{}' must have {} to {} bytes; make one with: openssl rand -base64 48",
                             file.string(), kMinSecret, kMaxBytes)};
  return secret;
}

std::string signToken(const Token& token, std::string_view secret) {
  Json claims = {{"sub", token.name}, {"exp", token.expires_s}};
  if (token.viewers > 0) claims["viewers"] = token.viewers;
  if (token.section_nodes > 0) claims["nodes"] = token.section_nodes;
  const std::string text = toBase64Url(kHeader) + "." + toBase64Url(claims.dump());
  return text + "." + toBase64Url(signatureOf(text, secret));
}

Result<Token> verifyToken(std::string_view text, std::string_view secret, int64_t now_s) {
  if (text.size() > kMaxBytes) return wrong("is too long");
  const size_t first = text.find('.'), last = text.rfind('.');
  if (first == std::string_view::npos || first == last) return wrong("is malformed");
  if (!isSignedBy(text.substr(0, last), text.substr(last + 1), secret)) return wrong("is not signed by this server");
  const auto header = fromBase64Url(text.substr(0, first));
  const Json kind = header ? Json::parse(*header, nullptr, false) : Json();
  if (!kind.is_object() || kind.value("alg", Json()) != "HS256") return wrong("is not of the kind HS256");
  auto token = readClaims(text.substr(first + 1, last - first - 1));
  if (token && token->expires_s <= now_s) return wrong("has expired");
  return token;
}

}  // namespace foreland::server
