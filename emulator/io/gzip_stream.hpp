#pragma once
// A stream that packs what is written (gzip) into another one.
#include <memory>
#include <ostream>

namespace io {

class GzipStream final : public std::ostream {
 public:
  /// `to` must outlive this. \throws std::bad_alloc
  explicit GzipStream(std::ostream& to);
  ~GzipStream() override;
  /// Writes what is still held back and the end mark; nothing may follow. What `to` cannot take it says itself.
  void finish();

 private:
  class Buffer;
  std::unique_ptr<Buffer> buffer_;
};

}  // namespace io
