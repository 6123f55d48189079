#pragma once
// Text files line by line, plain or compressed (gzip, xz); the first bytes of a file say which.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace cli {

class TextLines {
 public:
  /// Throws InputError if the file cannot be opened.
  explicit TextLines(std::string path);
  ~TextLines();
  TextLines(const TextLines&) = delete;
  TextLines& operator=(const TextLines&) = delete;

  /// Reads the next line, without its end; false after the last one. Throws InputError if the file is damaged or cut
  /// off.
  bool next(std::string& line);
  /// Number of the line that next() gave last, counted from 1.
  std::uint64_t number() const { return number_; }
  const std::string& path() const { return path_; }

  /// Gives decompressed bytes; 0 at the end.
  class Source {
   public:
    virtual ~Source() = default;
    virtual std::size_t read(char* to, std::size_t size) = 0;
  };

 private:
  std::string path_;
  std::unique_ptr<Source> source_;
  std::vector<char> buffer_;
  std::size_t at_ = 0, end_ = 0;
  std::uint64_t number_ = 0;
};

}  // namespace cli
