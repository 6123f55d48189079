#pragma once
/// The base of errors whose message quotes a file.
#include <string_view>

#include "io/print.hpp"

namespace io {

/// A byte 0 of the file does not end the message.
/// \tparam Base an exception of the standard library that is made of a text
template <class Base>
class TextError : public Base {
 public:
  explicit TextError(std::string_view message) : Base(exception_text(message)) {}
};

}  // namespace io
