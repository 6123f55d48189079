#include "state/sha256.hpp"

#include <fmt/format.h>
#include <openssl/sha.h>

#include <array>
#include <new>

namespace state {

std::string sha256(std::string_view text) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  if (SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data()) == nullptr)
    throw std::bad_alloc();  // NOLINT: bytes
  return fmt::format("{:02x}", fmt::join(digest, ""));
}

}  // namespace state
