// Streams for the boot loader, from memory or through a port: each way to run a boot has the same result.
#include <algorithm>
#include <array>

#include "fuzz/ways.hpp"
#include "machine/chips/boot.hpp"

namespace {

constexpr c40::Address stream_at = 0x80000000;
constexpr std::size_t most_words = 256;
// The boot ROM takes 11 cycles for a word from a port, up to 80 for one from bytes: a stream that is read to its end
// starts its program. A block that is longer than the stream is not copied for long.
constexpr c40::Cycles before_words = 400, for_a_word = 80, longest = 4000;

const c40::Board& board(bool port) {
  static const std::array<c40::Board, 2> boards = [] {
    using Kind = c40::Region::Kind;
    c40::Board plain;
    plain.name = "fuzz";
    plain.regions = {{"local", 0x300000, 0x400, 0, 0, Kind::ram, c40::Region::Bus::local},
                     {"global", stream_at, 0x200, 0, 0, Kind::ram, c40::Region::Bus::global}};
    return std::array{machine::with_boot_from_memory(plain, stream_at), machine::with_boot_from_port(plain)};
  }();
  return boards[port];
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 4 * most_words + 2) return 0;
  fuzz::Input input(data, size);
  const std::uint8_t choice = input.byte();
  const bool by_port = (choice & 8) != 0;
  const int port = (choice & 7) % c40::port_count;
  const c40::Cycles cut = 1 + input.byte();
  std::vector<c40::Word> stream;
  while (!input.empty()) stream.push_back(input.word());
  if (stream.empty()) return 0;
  const auto make = [&] {
    auto chip = std::make_unique<c40::Chip>(board(by_port));
    if (!by_port) chip->write_block(stream_at, stream);
    chip->boot();
    fuzz::Answer answer = [](c40::Chip&, const c40::StopInfo&) { return false; };
    if (by_port) {
      const auto feeder = std::make_shared<machine::BootFeeder>(*chip, port, stream);
      answer = [feeder](c40::Chip&, const c40::StopInfo& stop) {
        return stop.reason == c40::StopInfo::Reason::port_wait && feeder->serve(stop.port);
      };
    }
    return fuzz::Start{std::move(chip), std::move(answer)};
  };
  const auto limit = std::min(longest, before_words + for_a_word * static_cast<c40::Cycles>(stream.size()));
  fuzz::expect_same_ends(make, limit, {cut, 7, cut});
  return 0;
}
