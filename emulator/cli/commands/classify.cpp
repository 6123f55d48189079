// emulator classify: what each word is
#include <fmt/format.h>

#include <algorithm>
#include <future>
#include <thread>

#include "cli/arguments/options.hpp"
#include "cli/arguments/program.hpp"
#include "cli/output_files/progress_line.hpp"
#include "io/print.hpp"
#include "isa/classify.hpp"

namespace cli {
namespace {

struct Range {
  isa::Word first = 0;
  std::uint64_t count = std::uint64_t{1} << 32;
};

/// FIRST:COUNT
Range parse_range(const std::string& text) {
  const auto colon = text.find(':');
  if (colon == std::string::npos) throw InputError(fmt::format("--range: \"{}\" is not FIRST:COUNT", text));
  Range out;
  out.first = parse_address(std::string_view(text).substr(0, colon), nullptr, "--range");
  out.count = parse_address(std::string_view(text).substr(colon + 1), nullptr, "--range");
  return out;
}

isa::Classification classify_all(const Range& range) {
  constexpr std::uint64_t lot = std::uint64_t{1} << 25;
  isa::Classification total;
  ProgressLine line(report::Time{}, true);
  std::vector<std::future<isa::Classification>> lots;
  const auto workers = std::max(1U, std::thread::hardware_concurrency());
  for (std::uint64_t done = 0; done < range.count;) {
    lots.clear();
    for (unsigned i = 0; i < workers && done < range.count; ++i) {
      const std::uint64_t size = std::min(lot, range.count - done);
      lots.push_back(std::async(std::launch::async, isa::classify, static_cast<isa::Word>(range.first + done), size));
      done += size;
    }
    for (auto& part : lots) total += part.get();
    line.show(fmt::format("{:.0f} %", 100.0 * static_cast<double>(done) / static_cast<double>(range.count)));
  }
  return total;
}

}  // namespace

int classify(const ClassifyOptions& options) {
  const isa::Classification total = classify_all(options.range ? parse_range(*options.range) : Range{});
  if (options.rows)
    for (std::size_t i = 0; i < total.rows.size(); ++i) {
      const isa::Row& row = isa::rows()[i];
      io::print("{:>12}  {}  {}{}{}\n", total.rows[i], row.picture, row.mnemonic, row.parallel() ? " || " : "",
                row.mnemonic2);
    }
  io::print("{:>12}  words\n{:>12}  instructions of {} encodings\n{:>12}  reserved\n", total.words,
            total.instructions(),
            std::count_if(total.rows.begin(), total.rows.end(), [](std::uint64_t n) { return n != 0; }),
            total.reserved_words());
  for (std::size_t i = 0; i < total.reserved.size(); ++i)
    io::print("{:>12}    {}\n", total.reserved[i], isa::describe(static_cast<isa::Reserved::Reason>(i)));
  io::print("{:>12}  suit more than one encoding\n", total.ambiguous);
  return total.ambiguous == 0 && total.instructions() + total.reserved_words() == total.words ? success : run_failed;
}

}  // namespace cli
