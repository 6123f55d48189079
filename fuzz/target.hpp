#pragma once
// Shared by the targets (docs/fuzzing.md): a parser for the input, a file for readers that want a name, the report of a
// broken promise. A target is one function. libFuzzer or fuzz/standalone.cpp calls it with one input after another.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <typeinfo>
#include <utility>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fuzz {

/// The program has broken a promise: ends the process, which the fuzzer counts as a finding.
[[noreturn]] inline void broken(const std::string& how) {
  std::fprintf(stderr, "broken promise: %s\n", how.c_str());
  std::abort();
}
inline void expect(bool kept, const std::string& how) {
  if (!kept) broken(how);
}

/// The latest documented error with which work ended.
inline std::string refusal;

/// Does the work. Returns false when the work throws one of its documented errors. Another error is a finding, and so
/// is an error with an empty message.
template <class Documented, class... Others, class Work>
bool done(Work&& work) {
  try {
    if constexpr (sizeof...(Others) == 0)
      work();
    else
      return done<Others...>(std::forward<Work>(work));
    return true;
  } catch (const Documented& error) {
    expect(!std::string_view(error.what()).empty(), std::string("an error without a message: ") + typeid(error).name());
    refusal = error.what();
    return false;
  }
}

/// Reads values from the front of an input. After the end of the input every value is 0 or empty.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data, size) {}

  std::uint8_t byte() {
    if (data_.empty()) return 0;
    const std::uint8_t first = data_.front();
    data_ = data_.subspan(1);
    return first;
  }
  /// Four bytes, the low one first.
  std::uint32_t word() {
    std::uint32_t value = 0;
    for (unsigned shift = 0; shift < 32; shift += 8) value |= std::uint32_t{byte()} << shift;
    return value;
  }
  bool empty() const { return data_.empty(); }

  std::string_view text() const { return {reinterpret_cast<const char*>(data_.data()), data_.size()}; }
  std::span<const std::byte> bytes() const { return std::as_bytes(data_); }
  /// The text before the next line of four dashes, and on behind that line; all of it where there is none.
  std::string_view part() {
    constexpr std::string_view line = "\n----\n";
    const std::string_view all = text();
    const std::size_t end = all.find(line);
    data_ = end == std::string_view::npos ? data_.subspan(data_.size()) : data_.subspan(end + line.size());
    return all.substr(0, end);
  }

 private:
  std::span<const std::uint8_t> data_;
};

/// The file of one name that this process gives its inputs to, in a directory of its own.
class InputFile {
 public:
  /// \param name with the suffix that the reader goes by \param beside names and contents of files that inputs can name
  explicit InputFile(const std::string& name,
                     std::initializer_list<std::pair<const char*, std::string_view>> beside = {}) {
    std::string made = (std::filesystem::temp_directory_path() / "cmrc-fuzz-XXXXXX").string();
    expect(::mkdtemp(made.data()) != nullptr, "no directory can be made for the input");
    directory_ = made;
    path_ = (directory_ / name).string();
    for (const auto& [other, contents] : beside)
      std::ofstream(directory_ / other, std::ios::binary)
          .write(contents.data(), static_cast<std::streamsize>(contents.size()));
  }
  ~InputFile() {
    std::error_code ignored;
    std::filesystem::remove_all(directory_, ignored);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::string& write(std::string_view contents) const {
    std::ofstream(path_, std::ios::binary).write(contents.data(), static_cast<std::streamsize>(contents.size()));
    return path_;
  }

 private:
  std::filesystem::path directory_;
  std::string path_;
};

}  // namespace fuzz
