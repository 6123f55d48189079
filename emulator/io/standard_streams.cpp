#include "io/standard_streams.hpp"

#include <fcntl.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "io/print.hpp"

namespace io {

void take_closed_streams() {
  for (int descriptor = 0; descriptor <= 2; ++descriptor) {
    if (::fcntl(descriptor, F_GETFD) != -1) continue;
    // open gives the lowest free number, which is this one. Read-only, so that writing fails.
    [[maybe_unused]] const int taken = ::open("/dev/null", O_RDONLY);
  }
}

std::string flush_output() {
  errno = 0;
  std::cout.flush();
  const bool failed = std::ferror(stdout) != 0 || !std::cout;
  if (std::fflush(stdout) == 0 && !failed) return {};
  if (lost_in_saying() != 0) return std::strerror(lost_in_saying());
  return std::strerror(errno == 0 ? EIO : errno);
}

}  // namespace io
