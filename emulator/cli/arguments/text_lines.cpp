#include "cli/arguments/text_lines.hpp"

#include <fmt/format.h>
#include <lzma.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "cli/arguments/options.hpp"
#include "io/input_file.hpp"

namespace cli {
namespace {

constexpr std::size_t buffer_size = 1u << 18;

/// Reads plain text and gzip; zlib passes on data that is not compressed.
class GzipSource : public TextLines::Source {
 public:
  explicit GzipSource(const std::string& path) : path_(path), file_(gzopen(path.c_str(), "rb")) {
    if (file_ == nullptr) throw InputError(fmt::format("{}: cannot be read", path));
  }
  ~GzipSource() override { gzclose(file_); }
  GzipSource(const GzipSource&) = delete;
  GzipSource& operator=(const GzipSource&) = delete;

  std::size_t read(char* to, std::size_t size) override {
    const int count = gzread(file_, to, static_cast<unsigned>(size));
    int error = Z_OK;
    gzerror(file_, &error);
    if (count < 0 || (error != Z_OK && error != Z_STREAM_END))
      throw InputError(fmt::format("{}: the compressed data is damaged or cut off", path_));
    return static_cast<std::size_t>(count);
  }

 private:
  std::string path_;
  gzFile file_;
};

class XzSource : public TextLines::Source {
 public:
  explicit XzSource(const std::string& path) : path_(path), file_(path, std::ios::binary) {
    constexpr std::uint64_t memory_limit = std::uint64_t{1} << 30;
    if (!file_ || lzma_stream_decoder(&stream_, memory_limit, LZMA_CONCATENATED) != LZMA_OK)
      throw InputError(fmt::format("{}: cannot be read", path));
  }
  ~XzSource() override { lzma_end(&stream_); }
  XzSource(const XzSource&) = delete;
  XzSource& operator=(const XzSource&) = delete;

  std::size_t read(char* to, std::size_t size) override {
    stream_.next_out = reinterpret_cast<std::uint8_t*>(to);
    stream_.avail_out = size;
    while (stream_.avail_out != 0 && !ended_) {
      if (stream_.avail_in == 0 && file_) {
        file_.read(input_.data(), static_cast<std::streamsize>(input_.size()));
        stream_.next_in = reinterpret_cast<const std::uint8_t*>(input_.data());
        stream_.avail_in = static_cast<std::size_t>(file_.gcount());
      }
      const lzma_ret result = lzma_code(&stream_, file_ ? LZMA_RUN : LZMA_FINISH);
      ended_ = result == LZMA_STREAM_END;
      if (!ended_ && result != LZMA_OK)
        throw InputError(fmt::format("{}: the compressed data is damaged or cut off", path_));
    }
    return size - stream_.avail_out;
  }

 private:
  std::string path_;
  std::ifstream file_;
  lzma_stream stream_ = LZMA_STREAM_INIT;
  std::array<char, 1u << 16> input_{};
  bool ended_ = false;
};

std::unique_ptr<TextLines::Source> open_source(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw InputError(fmt::format("{}: no such file", path));
  if (std::filesystem::is_directory(path, error))
    throw InputError(fmt::format("{}: is a directory; a text file is expected", path));
  std::ifstream file(path, std::ios::binary);
  std::array<char, 6> start{};
  file.read(start.data(), start.size());
  constexpr std::array<char, 6> xz_magic{'\xFD', '7', 'z', 'X', 'Z', '\0'};
  if (file && start == xz_magic) return std::make_unique<XzSource>(path);
  return std::make_unique<GzipSource>(path);
}

}  // namespace

TextLines::TextLines(std::string path) : path_(std::move(path)), source_(open_source(path_)), buffer_(buffer_size) {}
TextLines::~TextLines() = default;

bool TextLines::next(std::string& line) {
  line.clear();
  for (bool any = false;; any = true) {
    if (at_ == end_) {
      at_ = 0;
      end_ = source_->read(buffer_.data(), buffer_.size());
      if (end_ == 0) {
        number_ += any && !line.empty() ? 1u : 0u;
        return any && !line.empty();
      }
    }
    const auto from = buffer_.begin() + static_cast<std::ptrdiff_t>(at_),
               to = buffer_.begin() + static_cast<std::ptrdiff_t>(end_);
    const auto newline = std::find(from, to, '\n');
    line.append(from, newline);
    if (line.size() > io::largest_input)
      throw InputError(fmt::format("{}:{}: a line longer than {} MiB; a text file is expected", path_, number_ + 1,
                                   io::largest_input >> 20));
    at_ = static_cast<std::size_t>(newline - buffer_.begin());
    if (newline == to) continue;
    ++at_;
    ++number_;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return true;
  }
}

}  // namespace cli
