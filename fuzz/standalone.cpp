// Runs a target without libFuzzer: TARGET [--mutations N] [--seed S] FILE|DIRECTORY...: every file, then N mutations of
// them, which depend on the seed alone. It says which files end with a documented error. --keep names a file for the
// present input, so that a crash can be repeated.
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <random>
#include <vector>

#include "fuzz/target.hpp"

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes read(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path.string() + ": cannot be read");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// One to four small changes, as a fuzzer makes them; now and then the front of one input before the back of another.
class Mutator {
 public:
  Mutator(const std::vector<Bytes>& seeds, std::uint64_t seed) : seeds_(seeds), random_(seed) {}

  Bytes next() {
    Bytes out = any();
    if (below(8) == 0) {
      const Bytes other = any();
      out.resize(below(out.size() + 1));
      out.insert(out.end(), other.begin() + static_cast<std::ptrdiff_t>(below(other.size() + 1)), other.end());
    }
    for (std::size_t left = 1 + below(4); left > 0; --left) change(out);
    return out;
  }

 private:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random_() % n); }
  const Bytes& any() { return seeds_[below(seeds_.size())]; }
  void change(Bytes& bytes) {
    const std::size_t at = below(bytes.size());
    const auto here = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const std::size_t length = std::min(1 + below(16), bytes.size() - at);
    const auto to = here + static_cast<std::ptrdiff_t>(length);
    switch (below(6)) {
      case 0: bytes.insert(here, static_cast<std::uint8_t>(random_())); break;
      case 1: bytes.erase(here, to); break;
      case 2: {
        const Bytes copy(here, to);
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size() + 1)), copy.begin(), copy.end());
        break;
      }
      case 3:
        if (!bytes.empty()) *here ^= static_cast<std::uint8_t>(1u << below(8));
        break;
      case 4:
        if (!bytes.empty()) *here = static_cast<std::uint8_t>(random_());
        break;
      default: std::fill(here, to, static_cast<std::uint8_t>(below(2) == 0 ? 0 : 0xFF));
    }
  }

  const std::vector<Bytes>& seeds_;
  std::mt19937_64 random_;
};

int run(int argc, char** argv) {
  std::vector<std::filesystem::path> files;
  std::uint64_t mutations = 0, seed = 1;
  std::string keep;
  for (int n = 1; n < argc; ++n) {
    const std::string_view argument = argv[n];
    const bool option = argument.starts_with("--");
    if (option && n + 1 == argc) throw std::runtime_error(std::string(argument) + ": a value is missing");
    if (argument == "--mutations")
      mutations = std::stoull(argv[++n]);
    else if (argument == "--seed")
      seed = std::stoull(argv[++n]);
    else if (argument == "--keep")
      keep = argv[++n];
    else if (option)
      throw std::runtime_error(std::string(argument) + ": known are --mutations, --seed and --keep");
    else if (std::filesystem::is_directory(argument))
      for (const auto& entry : std::filesystem::directory_iterator(argument)) files.push_back(entry.path());
    else
      files.emplace_back(argument);
  }
  if (files.empty()) throw std::runtime_error("a file or directory of inputs is expected");
  std::sort(files.begin(), files.end());

  const auto give = [&keep](const Bytes& input) {
    if (!keep.empty())
      std::ofstream(keep, std::ios::binary)
          .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
    LLVMFuzzerTestOneInput(input.data(), input.size());
  };
  std::vector<Bytes> seeds;
  for (const auto& file : files) {
    fuzz::refusal.clear();
    give(seeds.emplace_back(read(file)));
    if (!fuzz::refusal.empty())
      std::fprintf(stderr, "%s is refused: %s\n", file.filename().c_str(), fuzz::refusal.c_str());
  }
  Mutator mutator(seeds, seed);
  for (std::uint64_t n = 0; n < mutations; ++n) give(mutator.next());
  std::fprintf(stderr, "%zu files and %llu mutations\n", files.size(), static_cast<unsigned long long>(mutations));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 2;
  }
}
