#include "io/gzip_stream.hpp"

#include <zlib.h>

#include <array>
#include <new>
#include <streambuf>

namespace io {

class GzipStream::Buffer final : public std::streambuf {
 public:
  explicit Buffer(std::ostream& to) : out_(to) {
    constexpr int gzip = 16 + MAX_WBITS, memory = 8;
    if (deflateInit2(&stream_, level, Z_DEFLATED, gzip, memory, Z_DEFAULT_STRATEGY) != Z_OK) throw std::bad_alloc();
    clear();
  }
  ~Buffer() override { deflateEnd(&stream_); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  /// \returns whether all of it was written
  bool pack(int flush) {
    stream_.next_in = reinterpret_cast<Bytef*>(pbase());
    stream_.avail_in = static_cast<uInt>(pptr() - pbase());
    int status = Z_OK;
    do {
      stream_.next_out = packed_.data();
      stream_.avail_out = static_cast<uInt>(packed_.size());
      status = deflate(&stream_, flush);
      out_.write(reinterpret_cast<const char*>(packed_.data()),
                 static_cast<std::streamsize>(packed_.size() - stream_.avail_out));
    } while (stream_.avail_out == 0 || (flush == Z_FINISH && status == Z_OK));
    clear();
    return out_.good();
  }

 protected:
  int_type overflow(int_type c) override {
    if (!pack(Z_NO_FLUSH)) return traits_type::eof();
    if (!traits_type::eq_int_type(c, traits_type::eof())) {
      *pptr() = traits_type::to_char_type(c);
      pbump(1);
    }
    return traits_type::not_eof(c);
  }

 private:
  // This level needs a third of the time of zlib's usual level, and files are a tenth larger.
  static constexpr int level = 3;

  void clear() { setp(plain_.data(), plain_.data() + plain_.size()); }

  std::ostream& out_;
  z_stream stream_{};
  std::array<char, 1 << 16> plain_{};
  std::array<Bytef, 1 << 16> packed_{};
};

GzipStream::GzipStream(std::ostream& to) : std::ostream(nullptr), buffer_(std::make_unique<Buffer>(to)) {
  rdbuf(buffer_.get());
}

GzipStream::~GzipStream() = default;

void GzipStream::finish() {
  if (!buffer_->pack(Z_FINISH)) setstate(badbit);
}

}  // namespace io
