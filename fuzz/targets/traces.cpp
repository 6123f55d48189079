// Two traces, separated by four dashes: where they differ. A trace does not differ from itself.
#include <sstream>

#include "fuzz/target.hpp"
#include "report/events/trace_text.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 16384;
  if (size > most) return 0;
  fuzz::Input input(data, size);
  const std::string left(input.part()), right(input.text());
  const auto compare = [](const std::string& a, const std::string& b) {
    std::istringstream first(a), second(b);
    return report::compare_traces(first, second);
  };
  fuzz::done<std::invalid_argument>([&] {
    const auto there = compare(left, right), back = compare(right, left);
    fuzz::expect(there.has_value() == back.has_value(), "two traces differ one way round only");
    if (there) there->message();
  });
  fuzz::done<std::invalid_argument>([&] { fuzz::expect(!compare(left, left), "a trace differs from itself"); });
  return 0;
}
