#pragma once
#include <exception>
#include <new>

namespace io {

/// The text of an error, for users. The standard library's for memory that is used up is "std::bad_alloc".
inline const char* reason(const std::exception& error) {
  return dynamic_cast<const std::bad_alloc*>(&error) == nullptr ? error.what() : "no memory is left";
}

}  // namespace io
