#include "server/net/access/tls.h"

#include <fmt/format.h>
#include <openssl/ssl.h>

namespace foreland::server {
namespace ssl = boost::asio::ssl;

Result<std::shared_ptr<ssl::context>> loadTls(const std::filesystem::path& certificate,
                                              const std::filesystem::path& key) try {
  auto context = std::make_shared<ssl::context>(ssl::context::tls_server);
  SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_2_VERSION);
  SSL_CTX_set_mode(context->native_handle(), SSL_MODE_RELEASE_BUFFERS);  // while a connection is idle
  context->set_options(ssl::context::single_dh_use | SSL_OP_NO_RENEGOTIATION);
  boost::system::error_code error;
  context->use_certificate_chain_file(certificate.string(), error);
  if (error)
    return Error{ErrorCode::kInvalidArgument, fmt::format("--tls-cert: '{}' is no certificate chain in PEM format ({})",
                                                          certificate.string(), error.message())};
  context->use_private_key_file(key.string(), ssl::context::pem, error);
  if (error || SSL_CTX_check_private_key(context->native_handle()) != 1)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("--tls-key: '{}' is not the private key of '{}', in PEM format ({})", key.string(),
                             certificate.string(), error ? error.message() : "they do not match")};
  return context;
} catch (const std::exception& e) {  // Asio's constructor
  return Error{ErrorCode::kIo, fmt::format("TLS cannot be used: {}", e.what())};
}

}  // namespace foreland::server
