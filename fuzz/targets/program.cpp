// Programs of any words on a small board with two windows, from any registers: each way to run has the same result.
#include <array>

#include "fuzz/ways.hpp"
#include "isa/types.hpp"

namespace {

using c40::Address;
using c40::Word;

constexpr Address code = 0x300000, global = 0x80000000, chip_ram = c40::on_chip_ram, window_a = 0xC0000000,
                  window_b = 0x70000000;
constexpr Word local_words = 0x400, global_words = 0x200;
constexpr c40::Cycles limit = 600;

c40::Board board_of(std::uint8_t choice) {
  using Kind = c40::Region::Kind;
  using Bus = c40::Region::Bus;
  const int waits = choice & 3, page = choice >> 2 & 1, fast = choice >> 3 & 1;
  c40::Board board;
  board.name = "fuzz";
  board.regions = {{"local", code, local_words, waits, waits, Kind::ram, Bus::local, page},
                   {"global", global, global_words, fast, fast, Kind::ram, Bus::global},
                   {"window b", window_b, 0x1000, 0, 0, Kind::external_window, Bus::local},
                   {"window a", window_a, 0x1000, 0, 0, Kind::external_window, Bus::global}};
  return board;
}

/// An address for a pointer: mostly one with memory.
Address place(std::uint8_t choice) {
  static constexpr std::array<Address, 8> places{code,   code + 0x200, chip_ram, chip_ram + 0x400,
                                                 global, 0x100000,     window_a, window_b};
  return places[choice & 7] + (choice >> 3) * 4u;
}

/// Content of a window, and its answer time: functions of the address only.
std::uint64_t answers = 0;

c40::WindowAnswer answer_of(const c40::ExternalAccess& access) {
  ++answers;
  const Word at = access.address;
  return {
      .value = at * 0x9E3779B1u >> (at & 8), .arbitration = at & 3, .transfer = (at & 16) != 0 ? 4 + (at >> 2 & 1) : 0};
}

bool answer_window(c40::Chip& chip, const c40::StopInfo& stop) {
  if (stop.reason != c40::StopInfo::Reason::external_access) return false;
  const c40::WindowAnswer answer = answer_of(stop.access);
  if (stop.access.write)
    chip.complete_write(answer.arbitration, answer.transfer);
  else
    chip.complete_read(answer.value, answer.arbitration, answer.transfer);
  return true;
}

/// Gives half of the answers before the chip stops.
struct AtOnce final : c40::WindowListener {
  bool answer_at_once(const c40::ExternalAccess& access, c40::WindowAnswer& answer) override {
    if ((access.address & 2) != 0) return false;
    if (access.write && (access.address & 4) != 0) chip->catch_up();
    answer = answer_of(access);
    return true;
  }
  c40::Chip* chip = nullptr;
};

struct Setting {
  std::uint8_t board = 0;
  std::array<std::uint8_t, 20> pointers{};
  std::array<Word, 4> status{};
  std::vector<c40::Cycles> cuts;
  std::vector<Word> words;
};

Setting setting_of(fuzz::Input input) {
  Setting s;
  s.board = input.byte();
  for (std::uint8_t& pointer : s.pointers) pointer = input.byte();
  for (Word& word : s.status) word = input.word();
  for (int n = 0; n < 4; ++n) s.cuts.push_back(1 + input.byte());
  while (!input.empty() && s.words.size() < local_words) s.words.push_back(input.word());
  return s;
}

fuzz::Start make(const Setting& s) {
  using enum isa::Register;
  auto made = std::make_unique<c40::Chip>(board_of(s.board));
  c40::Chip& chip = *made;
  chip.reset();
  chip.write_block(code, s.words);
  static constexpr std::array pointing{AR0, AR1, AR2, AR3, AR4, AR5, AR6, AR7, SP};
  std::size_t n = 0;
  for (const isa::Register r : pointing) chip.set_register(r, place(s.pointers[n++]));
  for (const isa::Register r : {IR0, IR1, BK, RC}) chip.set_register(r, s.pointers[n++]);
  for (const isa::Register r : {RS, RE}) chip.set_register(r, code + s.pointers[n++]);
  for (const isa::Register r : {R0, R1, R2}) chip.set_register(r, std::uint64_t{s.pointers[n++]} << 30);
  chip.set_register(DP, place(s.pointers[n++]) >> 16);
  const std::uint8_t target = s.pointers[n++];
  chip.set_expansion(isa::Expansion::IVTP, chip_ram + 0x200);
  chip.set_expansion(isa::Expansion::TVTP, chip_ram + 0x200);
  std::array<Word, 0x40> vectors{};
  for (Word vector = 1; vector < vectors.size(); ++vector) vectors[vector] = code + (target * vector & 0xFFu);
  chip.write_block(chip_ram + 0x200, vectors);
  chip.set_register(ST, s.status[0] & 0x3FFF);
  chip.set_register(IIE, s.status[1]);
  chip.set_register(IIF, s.status[2]);
  chip.set_register(DIE, s.status[3]);
  chip.set_pc(code);
  static AtOnce at_once;
  at_once.chip = made.get();
  return {std::move(made), answer_window, &at_once, &answers};
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 41 + 4 * 256;
  if (size > most) return 0;
  const Setting setting = setting_of({data, size});
  if (setting.words.empty()) return 0;
  fuzz::expect_same_ends([&] { return make(setting); }, limit, setting.cuts);
  return 0;
}
