#include "machine/boards/board_vme.hpp"

namespace machine {
namespace {

/// Bits that a program cannot write: the read-only ones of vic068.h.
constexpr std::uint8_t read_only(std::size_t number) {
  switch (number) {
    case 0x13:
    case 0x14: return 0x03;  // number of the ICGS, ICMS interrupt
    case 0x15:
    case 0x16: return 0x07;  // number of the local, the error interrupt
    case 0x17: return 0xF0;  // ICGS in ICSR
    case 0x1D: return 0xFF;  // ICR5: the revision
    default: return 0;
  }
}

}  // namespace

c40::Word Vic068a::read(c40::Address number, c40::Cycles) { return static_cast<c40::Word>(held_[number]) << shift_; }

/// Bits as vic068.h has them.
std::optional<Vic068a::Request> Vic068a::request_of(std::size_t number, std::uint8_t value) {
  constexpr std::size_t last_interrupt = 0x12, virsr = 0x20, ss0cr0 = 0x30, btcr = 0x35, srr = 0x38;
  constexpr unsigned disabled = 0x80, set = 0x01, frequency = 0xC0, transfers = 0xE0;
  if (number <= last_interrupt && (value & disabled) == 0) return Request::interrupts;
  if (number == virsr && (value & set) != 0 && value != set) return Request::vme_interrupt;
  if (number == ss0cr0 && (value & frequency) != 0) return Request::timer;
  if (number == btcr && (value & transfers) != 0) return Request::block_transfer;
  if (number == srr && value != 0) return Request::system_reset;
  return std::nullopt;
}

std::vector<BoardDevice::NotModelled> Vic068a::not_modelled() const {
  constexpr std::array<std::string_view, static_cast<std::size_t>(Request::count)> names{
      "interrupts, of which it hands none on", "an interrupt on the VMEbus", "the timer of SS0CR0", "a block transfer",
      "a system reset"};
  std::vector<NotModelled> out;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (asked_[i] != never_asked) out.push_back({names[i], asked_[i]});
  return out;
}

void Vic068a::write(c40::Address number, c40::Word value, c40::Cycles now) {
  const std::uint8_t kept = read_only(number);
  held_[number] =
      static_cast<std::uint8_t>((held_[number] & kept) | ((value >> shift_) & static_cast<unsigned>(~kept)));
  const auto asked = request_of(number, static_cast<std::uint8_t>(value >> shift_));
  if (!asked) return;
  c40::Cycles& first = asked_[static_cast<std::size_t>(*asked)];
  if (first == never_asked) first = now;
}

}  // namespace machine
