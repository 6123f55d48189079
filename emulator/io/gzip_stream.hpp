#pragma once
// A stream that compresses (gzip) what is written, into another stream.
#include <memory>
#include <ostream>

namespace io {

class GzipStream final : public std::ostream {
 public:
  /// `to` must outlive this. \throws std::bad_alloc
  explicit GzipStream(std::ostream& to);
  ~GzipStream() override;
  /// Writes what is still buffered and the end mark; nothing may follow. The state of `to` says whether it took
  /// everything.
  void finish();

 private:
  class Buffer;
  std::unique_ptr<Buffer> buffer_;
};

}  // namespace io
